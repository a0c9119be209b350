"""Repair that keeps the shape: from wanted cells to the closest ones that can be built."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

from cellctl.assembly import Cell, Change
from cellctl.errors import Nearest, PlanError
from cellctl.validating.access import Gripper
from cellctl.validating.repairing.collapse import Collapses, Stands
from cellctl.validating.repairing.judge import judge, judge_until, longest_row, probed
from cellctl.validating.repairing.model import SAME
from cellctl.validating.repairing.reasons import Reason, reasons, times, unstable
from cellctl.validating.repairing.score import Size, Wanted
from cellctl.validating.repairing.search import search, search_beyond
from cellctl.validating.repairing.symmetry import symmetries
from cellctl.validating.repairing.task import Found, Rules
from cellctl.validating.repairing.words import describe
from cellctl.validating.rules import Cells, to_corner
from cellctl.validating.stability import Physics, Verdict

LEAST_SCORE = 0.5
"""What keeps less than this of a shape is another object; it is refused, and told about."""

CLEARLY = 0.1
"""Symmetry is given up for an object whose score is higher by more than this."""

_CELLS_NAMED = 6


@dataclass(frozen=True)
class Repaired:
    """Cells that stand at every step, from [0, 0, 0], and what it took."""

    cells: Cells
    order: tuple[Cell, ...]
    """An order in which every state was found to stand."""
    verdicts: tuple[Verdict, ...]
    """How it stands after each step, as far as that was determined."""
    changes: tuple[Change, ...]
    score: float
    """Likeness to the wanted shape; 1 if nothing was changed."""
    bound: float
    """No object that the search covers has a higher score: none with the symmetry of the wanted
    shape, without notches or holes that it has not, within reach, and no larger than it."""
    proven: bool
    """Whether the score is the highest one of those."""
    baseline_score: float | None
    """Of the paper's rescaling, where that was given; None also where it keeps more, but breaks a
    rule or was not found to stand."""


def repair_shape(
    cells: Cells,
    physics: Physics,
    gripper: Gripper,
    *,
    parts: int,
    grid: Size,
    budget_s: float,
    rescaled: Callable[[], Cells] = frozenset,
) -> Repaired:
    """The object closest to wanted cells that can be built; the same cells if they can.

    Args:
        cells: the wanted shape, at the wanted size; it may break any rule.
        physics: what holds the parts.
        gripper: what comes down with each of them.
        parts: how many there are.
        grid: the workspace in cells.
        budget_s: how long to search (wall time); then the best object so far is taken.
        rescaled: what the paper's rescaling makes of the shape, if anything: for comparison, and
            to fall back on. Asked only when something must be changed.

    Raises:
        PlanError: nothing like it can be built; the message names the rule, the cells, and the
            nearest object that could be built.
    """
    if parts < 1:
        raise PlanError("There are no parts to build with.", "Put parts on the belt.")
    if not cells:
        raise PlanError("There are no cells to build.", "Name at least one cell.")
    wanted = Wanted(to_corner(cells))
    why = reasons(wanted.cells, wanted.size, parts, grid)
    if not why:
        verdict = _judged(wanted.cells, physics, gripper, budget_s)
        if isinstance(verdict, Stands):
            order, verdicts = verdict
            return Repaired(wanted.cells, order, verdicts, (), 1.0, 1.0, True, None)
        why = (unstable(verdict, physics.least_margin),)
    rules = Rules(
        parts=parts,
        grid=grid,
        reach=2 * longest_row(physics),
        floor_grips=physics.floor_grips,
        judge=partial(judge_until, physics=physics, gripper=gripper),
        known=probed(physics),
    )
    start_s = time.monotonic()
    # The search hardly ever asks for the rescaling, and needs no more than one processor.
    with ThreadPoolExecutor(max_workers=1) as beside:
        baseline = _Baseline(wanted, beside.submit(rescaled), parts, grid)
        found = search(wanted, rules, budget_s, baseline.usable)
        symmetric = found
        left_s = start_s + budget_s - time.monotonic()
        if found.score + CLEARLY < 1.0 and left_s > 0.0:
            beyond = search_beyond(wanted, rules, left_s, found.score + CLEARLY)
            found = beyond if beyond.stands is not None else found
        baseline_score = baseline.score()
    if baseline_score is not None and baseline_score > found.score + SAME:
        # It may be less symmetric than what was sought; nobody shall get less for that.
        usable = baseline.usable()
        stands = rules.judge(usable, start_s + budget_s) if usable else None
        if isinstance(stands, Stands):
            found = replace(found, cells=usable, score=baseline_score, stands=stands)
        else:
            baseline_score = None
    if found.collapses and all(reason.rule != "stability" for reason in why):
        why = (*why, unstable(found.collapses[0], physics.least_margin))
    if found.stands is None or found.score < LEAST_SCORE:
        raise _refusal(wanted, why, found, time.monotonic() - start_s)
    changes = describe(wanted, found.cells, why)
    kept = symmetries(found.cells, Wanted(found.cells).size)
    if found is not symmetric and not set(symmetries(wanted.cells, wanted.size)) <= set(kept):
        changes = (*changes, _asymmetric(symmetric.score, found.score))
    return Repaired(
        found.cells,
        found.stands.order,
        found.stands.verdicts,
        changes,
        found.score,
        max(found.bound, found.score),
        found.proven,
        baseline_score,
    )


class _Baseline:
    """What the paper's rescaling makes of a shape, which is being computed.

    Args:
        wanted: the shape.
        rescaling: its cells, once they are known.
        parts: how many there are.
        grid: the workspace in cells.
    """

    def __init__(self, wanted: Wanted, rescaling: Future[Cells], parts: int, grid: Size) -> None:
        self._wanted = wanted
        self._rescaling = rescaling
        self._parts = parts
        self._grid = grid

    def _cells(self) -> Cells:
        found = self._rescaling.result()
        return to_corner(found) if found else found

    def score(self) -> float | None:
        """How much of the shape it keeps; None if there is none."""
        cells = self._cells()
        return self._wanted.score(cells) if cells else None

    def usable(self) -> Cells:
        """Its cells where they break no rule; else none."""
        cells = self._cells()
        if not cells or reasons(cells, Wanted(cells).size, self._parts, self._grid):
            return frozenset()
        return cells


def _judged(
    cells: Cells, physics: Physics, gripper: Gripper, budget_s: float
) -> Stands | Collapses:
    """Whether the shape stands as it is; of a large one, as far as the budget goes.

    Raises:
        PlanError: that could not be found out in time.
    """
    until_s = time.monotonic() + budget_s
    verdict = judge_until(cells, until_s, physics, gripper)
    if verdict is None and time.monotonic() < until_s:
        return judge(cells, physics, gripper)
    if verdict is None:
        raise PlanError(
            f"It takes {len(cells)} parts, and whether it stands at every step was not found out "
            f"in {budget_s:g} s.",
            "Ask for something smaller, or give more time (planning.budget_s).",
            rule="stability",
        )
    return verdict


def _asymmetric(symmetric: float, score: float) -> Change:
    why = f"An object that is would keep {symmetric:.0%} of the shape; this one keeps {score:.0%}."
    if symmetric == 0.0:
        why = f"No object that is was found; this one keeps {score:.0%} of the shape."
    return Change(what="It is not as symmetric as the shape.", why=why)


def _refusal(wanted: Wanted, why: tuple[Reason, ...], found: Found, spent_s: float) -> PlanError:
    """Which rules, where, and what could be built instead."""
    said = []
    for reason in why:
        places = ", ".join(str(list(cell)) for cell in reason.cells[:_CELLS_NAMED])
        more = len(reason.cells) - _CELLS_NAMED
        rest = f" and {more} more" if more > 0 else ""
        said.append(f"It breaks the rule of {reason.rule}: {reason.words} Cells: {places}{rest}.")
    settled = found.proven or found.bound < LEAST_SCORE
    hint = "Ask for another shape, or a simpler one."
    if not settled:
        said.append(f"Something that keeps enough of it was not found in {spent_s:.1f} s.")
        hint = "Ask for another shape, or a simpler one; or give more time (planning.budget_s)."
    elif not found.cells:
        said.append(f"Nothing like its {times(wanted.size)} parts stands.")
    nearest = None
    if found.cells:
        count = len(found.cells)
        what = (
            f"something of {count} part{'' if count == 1 else 's'}, "
            f"{times(Wanted(found.cells).size)} (wide, deep, high), "
            f"that keeps {found.score:.0%} of the shape."
        )
        nearest = Nearest(what=what, cells=_sorted(found.cells))
    return PlanError(
        f"This shape cannot be built here. {' '.join(said)}",
        hint,
        rule=why[0].rule,
        cells=why[0].cells,
        nearest=nearest,
    )


def _sorted(cells: Cells) -> tuple[Cell, ...]:
    return tuple(sorted(cells, key=lambda c: (c.z, c.x, c.y)))
