"""What was learnt from a structure that would collapse, so that no other one repeats it.

A mechanism is the set of cells that come loose, with every cell around it that could have held it
and was not there. Wherever the same cells stand with nothing more around them, the same magnets
have to bear the same load, and fail. So a mechanism is forbidden everywhere in the box, in every
direction, and in boxes of every size.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from cellctl.assembly import Cell
from cellctl.validating.repairing.hinge import Hinge
from cellctl.validating.repairing.score import Size
from cellctl.validating.rules import Cells, lateral
from cellctl.validating.stability import Verdict

_UNIT = 10_000
"""Loads are integers: this many are what the joints bear."""


class Stands(NamedTuple):
    """A structure that can be built: the order in which it stands at every step."""

    order: tuple[Cell, ...]
    verdicts: tuple[Verdict, ...]
    """One a step: margins that are proven, though not always exact."""

    @property
    def margin(self) -> float:
        """The least of all steps."""
        return min((verdict.margin for verdict in self.verdicts), default=math.inf)


class Collapses(NamedTuple):
    """A structure that cannot: what comes loose in which state, and where."""

    moving: Cells
    state: Cells
    """All cells that stand at that step, the moving ones included."""
    placed: Cell | None
    """The part that is placed at that step; None for the finished object at rest."""
    margin: float
    joint: str
    """The weakest joint, in words."""
    inevitable: bool = True
    """Whether no other part of its layer could have been placed before."""
    hinge: Hinge | None = None
    """What each moving cell contributes, where they come off as one piece."""


@dataclass(frozen=True)
class Mechanism:
    """Cells that come loose when all are there and none of ``missing`` is.

    Their common corner is at [0, 0, z]; z is kept, for the floor matters.
    """

    moving: Cells
    missing: Cells
    on_floor: bool
    first: Cell | None = None
    """The cell whose placing is at fault where it is the first of its surroundings in its layer.
    Beside another one it may hold; so the layer must be begun elsewhere."""
    loads: tuple[tuple[Cell, int], ...] = ()
    """What moving cells contribute, at most ``limit`` of which holds; without it, all together
    are too many."""
    limit: int = 0
    exact: bool = True
    """Whether no order of building helps; else another one than was tried might."""

    @classmethod
    def of(cls, found: Collapses, finished: Cells) -> Mechanism:
        """The mechanism of a collapse that was found on the way to a finished object.

        Layers are built one after the other: what belongs to a later one cannot hold it yet.
        """
        top = max(cell.z for cell in found.state)
        around = {beside for cell in found.moving for beside in cell.neighbours()}
        missing = frozenset(c for c in around - found.state if 0 <= c.z <= top)
        first = found.placed
        late: frozenset[Cell] = frozenset()
        if first is not None and _alone(first, found):
            missing = frozenset(cell for cell in missing if cell.z < top)
        else:
            first = None
            # Parts of the same layer that come later in this order.
            late = missing & finished
        x0 = min(cell.x for cell in found.moving)
        y0 = min(cell.y for cell in found.moving)

        def moved(cells: Iterable[Cell]) -> Cells:
            return frozenset(Cell(c.x - x0, c.y - y0, c.z) for c in cells)

        return cls(
            moving=moved(found.moving),
            missing=moved(missing - late),
            on_floor=any(cell.z == 0 for cell in found.moving),
            first=None if first is None else Cell(first.x - x0, first.y - y0, first.z),
            loads=_rounded(found.hinge, x0, y0),
            limit=0 if found.hinge is None else math.ceil(found.hinge.limit * _UNIT),
            exact=not late or found.inevitable,
        )

    def turned(self) -> tuple[Mechanism, ...]:
        """Itself in the eight directions of the floor, each once, always in the same order."""
        found: dict[tuple[tuple[Cell, ...], ...], Mechanism] = {}
        for turn in range(4):
            for mirrored in (False, True):
                turned = _turned(self, turn, mirrored)
                key = (tuple(sorted(turned.moving)), tuple(sorted(turned.missing)))
                found.setdefault(key, turned)
        return tuple(found[key] for key in sorted(found))

    def places(self, size: Size, floor_grips: bool) -> Iterator[Mechanism]:
        """Itself everywhere in a box, without the missing cells that lie outside.

        Args:
            size: of the box.
            floor_grips: whether the floor holds as well as a part does; only then does a mechanism
                that stands on the floor also fail on top of parts.
        """
        wide = max(c.x for c in self.moving) + 1
        deep = max(c.y for c in self.moving) + 1
        low = min(c.z for c in self.moving)
        high = max(c.z for c in self.moving)
        if self.on_floor:
            shifts = range(size[2] - high) if floor_grips else range(min(1, size[2] - high))
        else:
            # Down to the first layer above the floor: on the floor itself it would be held.
            shifts = range(1 - low, size[2] - high)
        for dz in shifts:
            for dx in range(size[0] - wide + 1):
                for dy in range(size[1] - deep + 1):
                    yield self._shifted(dx, dy, dz, size)

    def _shifted(self, dx: int, dy: int, dz: int, size: Size) -> Mechanism:
        nx, ny, nz = size

        def moved(cell: Cell) -> Cell:
            x, y, z = cell
            return Cell(x + dx, y + dy, z + dz)

        return replace(
            self,
            moving=frozenset(map(moved, self.moving)),
            missing=frozenset(
                cell
                for cell in map(moved, self.missing)
                if 0 <= cell.x < nx and 0 <= cell.y < ny and 0 <= cell.z < nz
            ),
            first=None if self.first is None else moved(self.first),
            loads=tuple((moved(cell), load) for cell, load in self.loads),
        )


def _rounded(hinge: Hinge | None, x0: int, y0: int) -> tuple[tuple[Cell, int], ...]:
    """Loads as integers, rounded down so that nothing that stands is excluded."""
    if hinge is None:
        return ()
    return tuple(
        (Cell(cell.x - x0, cell.y - y0, cell.z), math.floor(load * _UNIT))
        for cell, load in sorted(hinge.loads.items())
    )


def _alone(placed: Cell, found: Collapses) -> bool:
    """Whether a part rests on another one, with nothing of its layer beside it."""
    return (
        placed in found.moving
        and placed.below() in found.state
        and not any(beside in found.state for beside in lateral(placed))
        and not any(cell.z == placed.z for cell in found.moving - {placed})
    )


def _turned(mechanism: Mechanism, turn: int, mirrored: bool) -> Mechanism:
    def image(cell: Cell) -> Cell:
        x, y, z = (cell.y, cell.x, cell.z) if mirrored else cell
        for _ in range(turn):
            x, y = -y, x
        return Cell(x, y, z)

    x0 = min(image(cell).x for cell in mechanism.moving)
    y0 = min(image(cell).y for cell in mechanism.moving)

    def moved(cell: Cell) -> Cell:
        x, y, z = image(cell)
        return Cell(x - x0, y - y0, z)

    return replace(
        mechanism,
        moving=frozenset(map(moved, mechanism.moving)),
        missing=frozenset(map(moved, mechanism.missing)),
        first=None if mechanism.first is None else moved(mechanism.first),
        loads=tuple((moved(cell), load) for cell, load in mechanism.loads),
    )
