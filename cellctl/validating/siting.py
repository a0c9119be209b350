"""Where in the workspace an object stands, and the arm's way to every part of it.

The arm's ways, what the judge says and the exact margins depend on the order and the place alone,
so they are worked out at the same time.
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Callable, Sequence
from functools import cache, lru_cache
from typing import NamedTuple

from cellctl.assembling.route import RoutePlanner, StepRoute
from cellctl.assembly import Assembly, BuildPlan, Cell, Check, Step, StepKind
from cellctl.beside import Task, share
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.validating.checker import verify
from cellctl.validating.draft import Draft, sharpened
from cellctl.validating.rules import Cells, size_of
from cellctl.validating.stability import Physics, Verdict, assess_order

_AS_FAR_S = 0.01
"""Two parts whose ways from the pick station differ by less are as far."""
_AT_ONCE = 2
"""So many steps of the arm are worked out in one go."""


class Sited(NamedTuple):
    """A plan, and what the independent checker says of it; it looks at the steps' order and cells,
    not at the arm's ways, which are found meanwhile."""

    plan: BuildPlan
    judgement: tuple[Check, ...]


def site(draft: Draft, config: CellConfig, title: str, provenance: str, parts: int) -> Sited:
    """Stand an object, whose cells begin at [0, 0, 0], where the arm can place every part of it, as
    near to the pick station as possible.

    Args:
        draft: what is built, and in which order.
        config: the cell.
        title: of the object.
        provenance: where its shape comes from.
        parts: how many there are.

    Raises:
        PlanError: there is no such place.
    """
    planner = _planner(config)
    refused: PlanError | None = None
    away_s = cache(planner.away_s)
    for dx, dy in _places(draft.cells, config.grid, away_s):
        try:
            placed = _far_first(draft.moved(dx, dy), away_s)
            return site_here(placed, config, title, provenance, parts)
        except PlanError as error:
            if error.rule == "stability":
                raise  # it is the same in every place
            refused = refused or error
    assert refused is not None, "a place was tried"
    raise PlanError(
        f"The arm cannot place every part of this object anywhere in the workspace. "
        f"{refused.message}",
        refused.hint or "Ask for a smaller object.",
        rule="reach",
    )


def site_here(draft: Draft, config: CellConfig, title: str, provenance: str, parts: int) -> Sited:
    """Plan an object where it is; the arguments are those of ``site``.

    Raises:
        PlanError: the arm cannot place every part there.
    """
    physics = Physics.of(config)
    plan = BuildPlan(
        plan_id=_plan_id(draft.order, config),
        title=title,
        pitch_m=config.voxel.pitch_m,
        assembly=Assembly.of(draft.order, config.voxel.pitch_m),
        steps=tuple(
            Step(index=index, kind=StepKind.PLACE, cell=cell)
            for index, cell in enumerate(draft.order)
        ),
        checks=draft.checks,
        changes=draft.changes,
        questions=draft.questions,
        policy=draft.policy,
        provenance=provenance,
        closeness=draft.closeness,
        wanted=tuple(sorted(draft.wanted)),
    )
    begins = range(0, len(draft.order), _AT_ONCE)
    tasks = [Task(_ways, (draft.order, begin, begin + _AT_ONCE, config)) for begin in begins]
    tasks.append(Task(verify, (plan, config, parts)))
    if not draft.exact:
        tasks.append(Task(assess_order, (draft.order, physics)))
    *found, last = share(tasks)
    if not draft.exact:
        draft = sharpened(draft, last, physics)
        *found, last = found
    ways: list[StepRoute] = list(itertools.chain.from_iterable(found))
    steps = tuple(map(_step, plan.steps, ways, draft.verdicts))
    highest_m = max(way.clearance_m for way in ways)
    reach = Check(
        name="reach",
        passed=True,
        message=f"The arm reaches every part; it crosses at {highest_m:.2f} m at most.",
    )
    told = {"steps": steps, "checks": (*draft.checks, reach), "weakest": draft.weakest}
    return Sited(plan.model_copy(update=told), last)


def _step(step: Step, way: StepRoute, verdict: Verdict) -> Step:
    """With the way that the arm takes, and how the structure stands then."""
    return step.model_copy(
        update={
            "clearance_m": round(way.clearance_m, 4),
            "duration_s": round(way.duration_s, 3),
            "margin": verdict.margin if math.isfinite(verdict.margin) else None,
        }
    )


@lru_cache(maxsize=1)
def _planner(config: CellConfig) -> RoutePlanner:
    """One for all steps: it knows its stances by then."""
    return RoutePlanner(config)


def _ways(order: Sequence[Cell], begin: int, end: int, config: CellConfig) -> tuple[StepRoute, ...]:
    """The arm's ways of some steps of an order.

    Raises:
        PlanError: there is no way to some cell.
    """
    planner = _planner(config)
    return tuple(
        planner.step(cell, set(order[:index]), order[index - 1] if index else None)
        for index, cell in enumerate(order[begin:end], begin)
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
