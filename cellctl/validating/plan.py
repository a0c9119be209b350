"""From a shape to a build plan: fit, voxelise, check and repair, order, reach.

Everything here is a pure function of its arguments and importable by name, so that it can run in a
worker process.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from cellctl.assembling.route import RoutePlanner
from cellctl.assembly import Assembly, BuildPlan, Cell, Change, Check, Step, StepKind
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.mesh import GeneratedMesh
from cellctl.validating.files import read_json_plan, read_mesh
from cellctl.validating.fit import fit, size_changes, size_questions
from cellctl.validating.repair import repair, size_of
from cellctl.validating.rules import Cells, check_all
from cellctl.validating.sequence import check_order, sequence

Progress = Callable[[str], None]
"""Receives the name of each stage when it begins: discretising, checking, sequencing."""


def plan_build(
    generated: GeneratedMesh,
    config: CellConfig,
    inventory_parts: int | None = None,
    progress: Progress | None = None,
) -> BuildPlan:
    """Plan a generated shape; it is rescaled where the rules demand it, and the plan says so.

    Args:
        generated: the shape, z up.
        config: the cell.
        inventory_parts: how many parts there are now, where that is known to be fewer than the
            configured inventory.
        progress: told each stage as it begins.

    Raises:
        PlanError: it cannot be built; the message says which rule, and where.
    """
    tell = progress or _silent
    tell("discretising")
    fitted = fit(generated, config)
    tell("checking")
    repaired = repair(fitted.shape, config.limits, _parts(config, inventory_parts))
    size = size_of(repaired.cells)
    pitch_m = config.voxel.pitch_m
    changes = (
        *generated.changes,
        *fitted.changes,
        *repaired.changes,
        *size_changes(generated.stated_dimensions_m, size, pitch_m),
    )
    tell("sequencing")
    return _reachable_plan(
        repaired.cells,
        config,
        _parts(config, inventory_parts),
        title=generated.title,
        provenance=generated.provenance,
        changes=changes,
        questions=size_questions(generated.stated_dimensions_m, size, pitch_m),
    )


def plan_cells(
    cells: Iterable[Cell],
    config: CellConfig,
    inventory_parts: int | None = None,
    *,
    title: str = "object",
    provenance: str = "from cells",
) -> BuildPlan:
    """Plan cells exactly as given, apart from where in the workspace they stand.

    Raises:
        PlanError: they break a rule; cells are not repaired, only shapes are.
    """
    wanted = frozenset(Cell(*cell) for cell in cells)
    if not wanted:
        raise PlanError("There are no cells to build.", "Name at least one cell.")
    low = [min(axis) for axis in zip(*wanted, strict=True)]
    moved = frozenset(Cell(c.x - low[0], c.y - low[1], c.z - low[2]) for c in wanted)
    size, grid = size_of(moved), config.grid
    if any(edge > room for edge, room in zip(size, grid, strict=True)):
        raise PlanError(
            f"The object is {_times(size)} cells large; the workspace has {_times(grid)}.",
            "Make it smaller.",
        )
    parts = _parts(config, inventory_parts)
    return _reachable_plan(moved, config, parts, title=title, provenance=provenance)


def plan_file(
    name: str,
    content: bytes,
    config: CellConfig,
    inventory_parts: int | None = None,
    progress: Progress | None = None,
) -> BuildPlan:
    """Plan what a file holds: a mesh (.glb, .gltf, .obj, .ply, .stl), or a plan or cells (.json).

    A plan is not taken on trust: it is checked anew for this cell, in its own order and place.

    Args:
        name: the file's name; its suffix says what it holds.
        content: the file's bytes.
        config: the cell.
        inventory_parts: as in ``plan_build``.
        progress: as in ``plan_build``.

    Raises:
        UsageError: the file cannot be read as what it says it is.
        PlanError: what it holds cannot be built in this cell.
    """
    if Path(name).suffix.lower() != ".json":
        return plan_build(read_mesh(name, content), config, inventory_parts, progress)
    tell = progress or _silent
    tell("checking")
    found = read_json_plan(name, content)
    if isinstance(found, BuildPlan):
        tell("sequencing")
        return recheck(found, config, inventory_parts)
    if abs(found.pitch_m - config.voxel.pitch_m) > 1e-6:
        raise _other_pitch(name, found.pitch_m, config)
    tell("sequencing")
    return plan_cells(
        found.cells, config, inventory_parts, title=Path(name).stem, provenance=f"from {name}"
    )


def recheck(plan: BuildPlan, config: CellConfig, inventory_parts: int | None = None) -> BuildPlan:
    """Check a plan that came from elsewhere, with its own order and place, for this cell.

    Returns:
        The same steps, with checks, clearances and durations of this cell.

    Raises:
        PlanError: it breaks a rule, or it was made for another cell.
    """
    if abs(plan.pitch_m - config.voxel.pitch_m) > 1e-6:
        raise _other_pitch(f"The plan {plan.title!r}", plan.pitch_m, config)
    if any(step.kind is not StepKind.PLACE for step in plan.steps):
        raise PlanError(
            "The plan takes parts away; only plans that build from nothing can be run.",
            "Plan the object anew.",
        )
    order = tuple(step.cell for step in plan.steps)
    cells = frozenset(order)
    if len(cells) != len(order) or cells != frozenset(plan.assembly.cells):
        raise PlanError("The plan's steps do not build its own assembly.", "Plan it anew.")
    if not cells:
        raise PlanError("The plan has no steps.", "Plan it anew.")
    checks = _checked(cells, order, config, _parts(config, inventory_parts))
    steps = _steps(order, RoutePlanner(config))
    return _plan(order, steps, checks, config, like=plan)


def _reachable_plan(
    cells: Cells,
    config: CellConfig,
    parts: int,
    *,
    title: str,
    provenance: str,
    changes: tuple[Change, ...] = (),
    questions: tuple[str, ...] = (),
) -> BuildPlan:
    """Order the cells, and stand them where the arm can place every one, as central as possible."""
    order = sequence(cells, config.limits.overhang_cells)
    checks = _checked(cells, order, config, parts)
    planner = RoutePlanner(config)
    like = BuildPlan(
        plan_id="",
        title=title,
        pitch_m=config.voxel.pitch_m,
        assembly=Assembly.of(cells, config.voxel.pitch_m),
        steps=(),
        checks=(),
        changes=changes,
        questions=questions,
        provenance=provenance,
    )
    refused: PlanError | None = None
    for dx, dy in _places(size_of(cells), config.grid):
        moved = tuple(Cell(c.x + dx, c.y + dy, c.z) for c in order)
        try:
            steps = _steps(moved, planner)
        except PlanError as error:
            refused = refused or error
            continue
        return _plan(moved, steps, checks, config, like=like)
    assert refused is not None
    raise PlanError(
        f"The arm cannot place every part of this object anywhere in the workspace. "
        f"{refused.message}",
        refused.hint or "Ask for a smaller object.",
    )


def _checked(
    cells: Cells, order: tuple[Cell, ...], config: CellConfig, parts: int
) -> tuple[Check, ...]:
    """Every check that needs no robot; all pass.

    Raises:
        PlanError: one failed.
    """
    checks = (*check_all(cells, config.limits, parts), check_order(order))
    for check in checks:
        if not check.passed:
            places = ", ".join(str(list(cell)) for cell in check.cells[:6])
            raise PlanError(f"It breaks the rule of {check.name}: {check.message} Cells: {places}.")
    return checks


def _places(size: tuple[int, int, int], grid: tuple[int, int, int]) -> Iterator[tuple[int, int]]:
    """Offsets at which an object stands within the grid, the most central first."""
    room = (grid[0] - size[0], grid[1] - size[1])
    offsets = [(dx, dy) for dx in range(room[0] + 1) for dy in range(room[1] + 1)]
    yield from sorted(offsets, key=lambda o: (abs(2 * o[0] - room[0]) + abs(2 * o[1] - room[1]), o))


def _steps(order: tuple[Cell, ...], planner: RoutePlanner) -> tuple[Step, ...]:
    """One step a cell, each with the way that the arm takes.

    Raises:
        PlanError: there is no way to some cell.
    """
    steps = []
    placed: set[Cell] = set()
    previous: Cell | None = None
    for index, cell in enumerate(order):
        route = planner.step(cell, placed, previous)
        steps.append(
            Step(
                index=index,
                kind=StepKind.PLACE,
                cell=cell,
                clearance_m=round(route.clearance_m, 4),
                duration_s=round(route.duration_s, 3),
            )
        )
        placed.add(cell)
        previous = cell
    return tuple(steps)


def _plan(
    order: tuple[Cell, ...],
    steps: tuple[Step, ...],
    checks: tuple[Check, ...],
    config: CellConfig,
    like: BuildPlan,
) -> BuildPlan:
    """The finished plan: title, changes and provenance of one, steps and checks as found."""
    highest_m = max(step.clearance_m or 0.0 for step in steps)
    reach = Check(
        name="reach",
        passed=True,
        message=f"The arm reaches every part; it crosses at {highest_m:.2f} m at most.",
    )
    return like.model_copy(
        update={
            "plan_id": _plan_id(order, config),
            "assembly": Assembly.of(order, config.voxel.pitch_m),
            "steps": steps,
            "checks": (*checks, reach),
        }
    )


def _plan_id(order: tuple[Cell, ...], config: CellConfig) -> str:
    """The same object in the same cell has the same."""
    identity = {
        "place": order,
        "pitch_m": config.voxel.pitch_m,
        "workspace": config.workspace.model_dump(),
        "base": config.base.frame,
        "feeder": config.feeder.frame,
    }
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:16]


def _parts(config: CellConfig, inventory_parts: int | None) -> int:
    if inventory_parts is None:
        return config.limits.inventory_parts
    return min(inventory_parts, config.limits.inventory_parts)


def _other_pitch(what: str, pitch_m: float, config: CellConfig) -> PlanError:
    return PlanError(
        f"{what} is for parts of {pitch_m * 100:g} cm; this cell has parts of "
        f"{config.voxel.pitch_m * 100:g} cm.",
        "Plan it anew.",
    )


def _times(size: tuple[int, int, int]) -> str:
    return " x ".join(str(edge) for edge in size)


def _silent(_name: str) -> None:
    """For whoever wants no progress."""
