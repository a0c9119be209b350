"""The paper's objects taken through its algorithms, for the tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from cellctl.assembling.route import RoutePlanner
from cellctl.assembly import Cell, Check
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.validating.fit import Shape
from cellctl.validating.paper import square_path
from cellctl.validating.paper.objects import OBJECTS, PaperObject, volume
from cellctl.validating.paper.policy import COMPLETE, Module, judge, order_by, process
from cellctl.validating.paper.printed import CELL_CM3, GRID, LIMITS, PITCH_M
from cellctl.validating.paper.scaling import Rescaled, occupy, scale_to_fit
from cellctl.validating.paper.sequencing import Order
from cellctl.validating.rules import size_of


@dataclass(frozen=True)
class Outcome:
    """One object after some of the modules, and what the paper's rules say of it."""

    found: Rescaled
    order: Order
    checks: tuple[Check, ...]

    @property
    def failed(self) -> Check | None:
        """The first rule that it breaks."""
        return next((check for check in self.checks if not check.passed), None)

    @property
    def verdict(self) -> str:
        """``pass`` or ``fail``, as the paper's tables have it."""
        return "pass" if self.failed is None else "fail"


@dataclass(frozen=True)
class Timed:
    """How long the arm needs; ``seconds`` is None where it cannot build the object."""

    seconds: float | None
    reason: str = ""


class Worked:
    """One object of the paper, and everything that is computed for it, when it is asked for.

    Args:
        subject: the object.
        config: the cell whose arm would build it.
    """

    def __init__(self, subject: PaperObject, config: CellConfig) -> None:
        self.subject = subject
        self._config = config

    @cached_property
    def shape(self) -> Shape:
        """Scaled to the paper's workspace (algorithm 1)."""
        return scale_to_fit(self.subject.surface, GRID)

    @cached_property
    def baseline(self) -> Rescaled:
        """As it is before any module."""
        return occupy(self.shape)

    def without(self, left_out: Module | None) -> Outcome:
        """The pipeline with one module left out, or complete, judged by all rules."""
        modules = COMPLETE - {left_out}
        parts = LIMITS.inventory_parts
        found = process(self.shape, LIMITS, parts, modules)
        order = order_by(found.cells, modules)
        return Outcome(found, order, judge(found.cells, order, LIMITS, parts))

    @cached_property
    def complete(self) -> Outcome:
        """The object that the paper builds."""
        return self.without(None)

    @property
    def volume_cm3(self) -> float:
        """Of the mesh, at the size at which it is built."""
        return volume(self.complete.found.shape.surface) * CELL_CM3

    @cached_property
    def square_path_s(self) -> float:
        """Algorithm 5 with the paper's speed and acceleration in m/s and m/s2, latch included."""
        path = square_path.square_path(self._placed_order, self._config)
        return square_path.duration_s(path, *square_path.PRINTED_M_S) + self._latch_s

    @cached_property
    def millimetres_s(self) -> float:
        """The same with speed and acceleration in mm/s and mm/s2, as they are printed."""
        path = square_path.square_path(self._placed_order, self._config)
        speed, acceleration = square_path.PRINTED_M_S
        return square_path.duration_s(path, speed / 1000, acceleration / 1000) + self._latch_s

    @cached_property
    def routes(self) -> Timed:
        """The same order by the routes of this cell, from home to the last part, latch included."""
        planner = RoutePlanner(self._config)
        total_s = 0.0
        placed: set[Cell] = set()
        previous: Cell | None = None
        for cell in self._placed_order:
            try:
                total_s += planner.step(cell, placed, previous).duration_s
            except PlanError as error:
                return Timed(None, f"Not in the middle of this workspace: {error.message}")
            placed.add(cell)
            previous = cell
        return Timed(total_s)

    @property
    def _latch_s(self) -> float:
        """The latch closes once and opens once a part; closing is taken to last as long."""
        return 2.0 * self._config.gripper.release_s * len(self._placed_order)

    @cached_property
    def _placed_order(self) -> tuple[Cell, ...]:
        """The complete pipeline's order, in the middle of this cell's workspace."""
        size, grid = size_of(self.complete.found.cells), self._config.grid
        dx, dy = (max(0, grid[axis] - size[axis]) // 2 for axis in (0, 1))
        return tuple(Cell(c.x + dx, c.y + dy, c.z) for c in self.complete.order.cells)


class Workbench:
    """All objects of the paper, and what else the tables need.

    Args:
        config: the cell whose arm would build them; with the paper's parts, whatever its own.
        phrase_of: what the cell understands of a sentence: the phrase that names the object.
    """

    def __init__(self, config: CellConfig, phrase_of: Callable[[str], str]) -> None:
        voxel = config.voxel.model_copy(update={"pitch_m": PITCH_M})
        self.config = config.model_copy(update={"voxel": voxel})
        self.phrase_of = phrase_of
        self.works = tuple(Worked(subject, self.config) for subject in OBJECTS)
