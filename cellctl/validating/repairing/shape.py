"""Repair that keeps the shape: from wanted cells to the closest ones that can be built."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from cellctl.assembly import Cell, Change
from cellctl.errors import Nearest, PlanError
from cellctl.validating.access import Gripper
from cellctl.validating.repairing.collapse import Stands
from cellctl.validating.repairing.judge import judge, longest_row, probed
from cellctl.validating.repairing.reasons import Reason, reasons, times, unstable
from cellctl.validating.repairing.score import Size, Wanted
from cellctl.validating.repairing.search import Rules, search
from cellctl.validating.repairing.words import describe
from cellctl.validating.rules import Cells, to_corner
from cellctl.validating.stability import Physics

LEAST_SCORE = 0.5
"""What keeps less than this of a shape is another object; it is refused, and told about."""

_CELLS_NAMED = 6


@dataclass(frozen=True)
class Repaired:
    """Cells that stand at every step, from [0, 0, 0], and what it took."""

    cells: Cells
    order: tuple[Cell, ...]
    """An order in which every state was found to stand."""
    margin: float
    """The least stability margin of its steps."""
    changes: tuple[Change, ...]
    score: float
    """Likeness to the wanted shape; 1 if nothing was changed."""
    bound: float
    """No object that the search covers has a higher score."""
    proven: bool
    """Whether the score is the highest one."""
    baseline_score: float | None
    """Of the paper's rescaling, where that was given."""


def repair_shape(
    cells: Cells,
    physics: Physics,
    gripper: Gripper,
    *,
    parts: int,
    grid: Size,
    budget_s: float,
    rescaled: Callable[[], Cells] = frozenset,
    workers: int = 1,
    progress: Callable[[str], None] | None = None,
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
        workers: of the exact solver; one is deterministic.
        progress: told that a repair begins.

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
        verdict = judge(wanted.cells, physics, gripper)
        if isinstance(verdict, Stands):
            return Repaired(wanted.cells, verdict.order, verdict.margin, (), 1.0, 1.0, True, None)
        why = (unstable(verdict),)
    if progress is not None:
        progress("repairing")
    base = rescaled()
    base = to_corner(base) if base else base
    baseline_score = wanted.score(base) if base else None
    rules = Rules(
        parts=parts,
        grid=grid,
        reach=2 * longest_row(physics),
        floor_grips=physics.floor_grips,
        judge=partial(judge, physics=physics, gripper=gripper),
        known=probed(physics),
    )
    usable = base if base and not reasons(base, Wanted(base).size, parts, grid) else frozenset()
    found = search(wanted, rules, budget_s, workers, usable)
    if found.collapses and all(reason.rule != "stability" for reason in why):
        why = (*why, unstable(found.collapses[0]))
    if found.stands is None or found.score < LEAST_SCORE:
        raise _refusal(wanted, why, found.cells, found.score)
    return Repaired(
        found.cells,
        found.stands.order,
        found.stands.margin,
        describe(wanted, found.cells, why),
        found.score,
        found.bound,
        found.proven,
        baseline_score,
    )


def _refusal(wanted: Wanted, why: tuple[Reason, ...], nearest: Cells, score: float) -> PlanError:
    """Which rules, where, and what could be built instead."""
    said = []
    for reason in why:
        places = ", ".join(str(list(cell)) for cell in reason.cells[:_CELLS_NAMED])
        more = len(reason.cells) - _CELLS_NAMED
        rest = f" and {more} more" if more > 0 else ""
        said.append(f"It breaks the rule of {reason.rule}: {reason.words} Cells: {places}{rest}.")
    if nearest:
        count = len(nearest)
        could = (
            f"The nearest that could be built has {count} part{'' if count == 1 else 's'}, "
            f"{times(Wanted(nearest).size)} (wide, deep, high), and keeps {score:.0%} of the shape."
        )
    else:
        could = f"Nothing like its {times(wanted.size)} parts could be found that stands."
    return PlanError(
        f"This shape cannot be built here. {' '.join(said)} {could}",
        "Ask for another shape, or a simpler one.",
        rule=why[0].rule,
        cells=why[0].cells,
        nearest=Nearest(what=could, cells=_sorted(nearest)) if nearest else None,
    )


def _sorted(cells: Cells) -> tuple[Cell, ...]:
    return tuple(sorted(cells, key=lambda c: (c.z, c.x, c.y)))
