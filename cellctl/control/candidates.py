"""Several shapes for one wish, of which the planner's verdict chooses; for the designer process.

The first shape is what was asked for, and stays unless it is refused or keeps too little of itself.
Only then others are planned, while there is time.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterator
from itertools import chain

from cellctl.assembly import BuildPlan, Change
from cellctl.config import CellConfig
from cellctl.control.plainly import reason
from cellctl.control.proposals import Chosen, Proposals
from cellctl.errors import CellctlError, DesignError, PlanError
from cellctl.generating.others import others
from cellctl.mesh import GeneratedMesh
from cellctl.validating.discretise import discretise
from cellctl.validating.fit import fit
from cellctl.validating.plan import foresee_removal, plan_build
from cellctl.validating.rules import to_corner

GOOD_SCORE = 0.75
"""A shape that keeps so much of itself is shown without a look at others."""
_LEAST_TIME_S = 0.5
"""A plan is not begun with less time than this left."""
_SAFE_MARGIN = 2.0
"""Joints that bear this many times what is asked of them count as well as those that bear more."""

Verdict = tuple[int, float, float, int]


def fingerprint(mesh: GeneratedMesh, config: CellConfig) -> str:
    """The same for two shapes that fill the same cells.

    Raises:
        PlanError: it fills none.
    """
    cells = sorted(to_corner(discretise(fit(mesh, config).shape)))
    return hashlib.sha256(repr([tuple(cell) for cell in cells]).encode()).hexdigest()[:16]


def design_another(present: GeneratedMesh, wish: Proposals, config: CellConfig) -> GeneratedMesh:
    """The next shape for a wish that has not been shown.

    Args:
        present: what is shown now.
        wish: what was asked for, and what was shown before.
        config: the cell.

    Raises:
        DesignError: there is no other.
    """
    seen = wish.shown | {_key(present, config)}
    for mesh, _ in _unseen(present, wish, seen, config):
        return mesh
    raise DesignError("I know no other shape for it.", "Say what to change, or ask anew.")


def choose(
    first: GeneratedMesh,
    wish: Proposals,
    config: CellConfig,
    available: int,
    progress: Callable[[str], None],
) -> Chosen:
    """Plan a shape; where it is refused or much changed, plan others and take the best.

    Args:
        first: the shape to begin with.
        wish: what was asked for, and what was shown before.
        config: the cell; ``planning.others_budget_s`` says how long others may be planned.
        available: how many parts there are.
        progress: told each stage as it begins.
    """
    end_s = time.monotonic() + config.planning.others_budget_s
    key = _key(first, config)
    tried = {key}
    best: tuple[Verdict, GeneratedMesh | None, BuildPlan] | None = None
    refusal: PlanError | None = None
    try:
        plan = plan_build(first, config, available, progress)
        best = (_verdict(first, plan), None, plan)
    except PlanError as error:
        refusal = error
    if best is None or not _good(best[2]):
        for mesh, key in _unseen(first, wish, wish.shown | tried, config):
            left_s = end_s - time.monotonic()
            if left_s < _LEAST_TIME_S:
                break
            tried.add(key)
            try:
                plan = plan_build(mesh, _within(left_s, config), available, progress)
            except PlanError:
                continue
            verdict = _verdict(mesh, plan)
            if best is None or verdict < best[0]:
                best = (verdict, mesh, plan if wish.shown else _told(plan, refusal))
            if _good(plan):
                break
    if best is None:
        return Chosen(None, None, refusal, frozenset(tried))
    plan = best[2]
    if config.policy.confirmation == "ask":
        plan = foresee_removal(plan, config)
    return Chosen(best[1], plan, refusal, frozenset(tried))


def _unseen(
    present: GeneratedMesh, wish: Proposals, seen: frozenset[str] | set[str], config: CellConfig
) -> Iterator[tuple[GeneratedMesh, str]]:
    """What fills other cells than everything that was seen, each once."""
    asked = wish.asked or present
    met = set(seen)
    for mesh in chain((asked,), others(wish.request, asked, config)):
        key = _key(mesh, config)
        if key not in met:
            met.add(key)
            yield mesh, key


def _key(mesh: GeneratedMesh, config: CellConfig) -> str:
    try:
        return fingerprint(mesh, config)
    except CellctlError:
        return ""  # planning says why; what fills no cells is never another shape


def _within(left_s: float, config: CellConfig) -> CellConfig:
    budget_s = min(left_s, config.planning.budget_s)
    planning = config.planning.model_copy(update={"budget_s": budget_s})
    return config.model_copy(update={"planning": planning})


def _score(plan: BuildPlan) -> float:
    return plan.closeness.score if plan.closeness is not None else 1.0


def _good(plan: BuildPlan) -> bool:
    return _score(plan) >= GOOD_SCORE


def _verdict(mesh: GeneratedMesh, plan: BuildPlan) -> Verdict:
    """Less is better: what was left out of the wish, the shape kept, its margin, its parts."""
    margin = plan.weakest.margin if plan.weakest is not None else _SAFE_MARGIN
    return (
        len(mesh.changes),
        -round(_score(plan), 1),
        -round(min(margin, _SAFE_MARGIN), 1),
        plan.parts,
    )


def _told(plan: BuildPlan, refusal: PlanError | None) -> BuildPlan:
    """The plan, which says that it is not of the shape that was thought of first."""
    why = reason(refusal) if refusal is not None else "I could have kept little of that shape."
    told = Change(what="It is another one than I thought of first.", why=why)
    return plan.model_copy(update={"changes": (told, *plan.changes)})
