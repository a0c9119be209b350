"""Where in the workspace an object stands, and the arm's way to every part of it."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Callable, Sequence
from functools import cache

from cellctl.assembling.route import RoutePlanner
from cellctl.assembly import Assembly, BuildPlan, Cell, Check, Step, StepKind
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.validating.draft import Draft
from cellctl.validating.rules import Cells, size_of

_AS_FAR_S = 0.01
"""Two parts whose ways from the pick station differ by less are as far."""


def site(draft: Draft, config: CellConfig, title: str, provenance: str) -> BuildPlan:
    """Stand an object, whose cells begin at [0, 0, 0], where the arm can place every part of it, as
    near to the pick station as possible.

    Raises:
        PlanError: there is no such place.
    """
    planner = RoutePlanner(config)
    refused: PlanError | None = None
    away_s = cache(planner.away_s)
    for dx, dy in _places(draft.cells, config.grid, away_s):
        try:
            placed = _far_first(draft.moved(dx, dy), away_s)
            return site_here(placed, config, title, provenance, planner)
        except PlanError as error:
            refused = refused or error
    assert refused is not None, "a place was tried"
    raise PlanError(
        f"The arm cannot place every part of this object anywhere in the workspace. "
        f"{refused.message}",
        refused.hint or "Ask for a smaller object.",
        rule="reach",
    )


def site_here(
    draft: Draft,
    config: CellConfig,
    title: str,
    provenance: str,
    planner: RoutePlanner | None = None,
) -> BuildPlan:
    """Plan an object where it is.

    Raises:
        PlanError: the arm cannot place every part there.
    """
    steps = _steps(draft, planner or RoutePlanner(config))
    highest_m = max(step.clearance_m or 0.0 for step in steps)
    reach = Check(
        name="reach",
        passed=True,
        message=f"The arm reaches every part; it crosses at {highest_m:.2f} m at most.",
    )
    return BuildPlan(
        plan_id=_plan_id(draft.order, config),
        title=title,
        pitch_m=config.voxel.pitch_m,
        assembly=Assembly.of(draft.order, config.voxel.pitch_m),
        steps=steps,
        checks=(*draft.checks, reach),
        changes=draft.changes,
        questions=draft.questions,
        policy=draft.policy,
        provenance=provenance,
        weakest=draft.weakest,
        closeness=draft.closeness,
        wanted=tuple(sorted(draft.wanted)),
    )


def _places(
    cells: Cells, grid: tuple[int, int, int], away_s: Callable[[Cell], float]
) -> list[tuple[int, int]]:
    """Offsets at which an object stands within the grid, those first at which its parts have the
    shortest way from the pick station."""
    size = size_of(cells)
    offsets = itertools.product(range(grid[0] - size[0] + 1), range(grid[1] - size[1] + 1))

    def way_s(offset: tuple[int, int]) -> float:
        dx, dy = offset
        return sum(away_s(Cell(cell.x + dx, cell.y + dy, cell.z)) for cell in sorted(cells))

    return sorted(offsets, key=lambda offset: (way_s(offset), offset))


def _far_first(draft: Draft, away_s: Callable[[Cell], float]) -> Draft:
    """The order, or its mirror image where that is far more from far to near: then the arm passes
    over less on its way."""
    if draft.policy == "paper":
        return draft
    images = [image for axis in ("x", "y") if (image := draft.mirrored(axis)) is not None]
    best = min(images, key=lambda image: _passed_over(image, away_s), default=draft)
    much = 2 * _passed_over(best, away_s) < _passed_over(draft, away_s)
    return best if much else draft


def _passed_over(draft: Draft, away_s: Callable[[Cell], float]) -> int:
    """How many pairs of a layer have the nearer part placed first."""
    nearer = 0
    for index, cell in enumerate(draft.order):
        ways_s = (away_s(other) for other in draft.order[:index] if other.z == cell.z)
        nearer += sum(way_s < away_s(cell) - _AS_FAR_S for way_s in ways_s)
    return nearer


def _steps(draft: Draft, planner: RoutePlanner) -> tuple[Step, ...]:
    """One step a cell, each with the way that the arm takes and how the structure stands then.

    Raises:
        PlanError: there is no way to some cell.
    """
    steps = []
    placed: set[Cell] = set()
    previous: Cell | None = None
    for index, (cell, verdict) in enumerate(zip(draft.order, draft.verdicts, strict=True)):
        route = planner.step(cell, placed, previous)
        steps.append(
            Step(
                index=index,
                kind=StepKind.PLACE,
                cell=cell,
                clearance_m=round(route.clearance_m, 4),
                duration_s=round(route.duration_s, 3),
                margin=verdict.margin if math.isfinite(verdict.margin) else None,
            )
        )
        placed.add(cell)
        previous = cell
    return tuple(steps)


def _plan_id(order: Sequence[Cell], config: CellConfig) -> str:
    """The same object in the same cell has the same."""
    identity = {
        "place": order,
        "pitch_m": config.voxel.pitch_m,
        "workspace": config.workspace.model_dump(),
        "base": config.base.frame,
        "feeder": config.feeder.frame,
    }
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:16]
