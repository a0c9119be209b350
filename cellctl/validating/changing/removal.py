"""Taking one part away, and in which order all of them: every state is proven, none is guessed."""

from __future__ import annotations

from typing import NamedTuple

from cellctl.assembly import Cell, TakeOff
from cellctl.validating.access import Access
from cellctl.validating.changing.breaking import PULL, Breaking, Hinge, How, breakings
from cellctl.validating.rules import Cells, pieces
from cellctl.validating.stability import Physics, Verdict, assess
from cellctl.validating.stability.assess import STANDS, as_array, to_verdict
from cellctl.validating.stability.programme import Programme


class Removal(NamedTuple):
    """One part that goes back to the belt, and how it comes off."""

    cell: Cell
    how: How
    """``pull``: straight up; ``peel``: tilted first; ``twist``: turned about the vertical first."""
    direction: tuple[int, int] | None
    """Of a peel: where the part's top goes, along x, y or a diagonal."""
    hinge: Hinge | None
    """Of a peel: the level axis that it turns about."""
    margin: float
    """How many times stronger the rest's magnets are than it needs, while this part comes off and
    after; infinite where it needs none."""
    force_n: float
    """What the arm applies: upward; of a peel or twist, its couple divided by the part's edge."""

    def take_off(self, pitch_m: float) -> TakeOff:
        """As the arm is told it, with parts of that edge."""
        hinge = self.hinge
        return TakeOff(
            how=self.how,
            direction=self.direction,
            hinge_m=None
            if hinge is None
            else (hinge.towards * pitch_m / 2, hinge.up * pitch_m / 2),
            force_n=round(self.force_n, 2),
        )


class Attempt(NamedTuple):
    """What became of looking for a way to take one part."""

    removal: Removal | None
    """The gentlest way that the rest bears; None if it bears none."""
    verdict: Verdict
    """The worst of that way, or of the best of those that the rest does not bear."""
    barred: bool = False
    """Whether the rest bears some way, and there is no room for it."""


def assess_removal(
    cells: Cells,
    cell: Cell,
    physics: Physics,
    after: Verdict | None = None,
    access: Access | None = None,
) -> Attempt:
    """The gentlest way to take a part that the rest bears, and how well it does.

    Whether its way from above is free is not asked here, and a part that carries others is the
    caller's mistake: the verdict on what is left says only what happens without it.

    Args:
        cells: what stands, ``cell`` included.
        cell: the part to take.
        physics: what holds it.
        after: the verdict on what is left, where that is known.
        access: says for which ways there is room; for all that the neighbours allow, if None.

    Raises:
        PlanError: the solver failed.
    """
    left = cells - {cell}
    after = assess(left, physics) if after is None else after
    if after.margin < physics.least_margin:
        return Attempt(None, after)
    refused: Verdict | None = None
    barred = False
    for breaking in breakings(cells, cell, physics):
        verdict = min(while_breaking(left, breaking, physics), after, key=lambda v: v.margin)
        if verdict.margin >= physics.least_margin:
            way = breaking.way
            removal = Removal(
                cell, way.how, way.direction, way.hinge, verdict.margin, breaking.force_n
            )
            if access is None or access.frees(cell, removal.take_off(physics.pitch_m), cells):
                return Attempt(removal, verdict)
            barred = True
        if refused is None or verdict.margin > refused.margin:
            refused = verdict
    # A part between neighbours on all sides can still be pulled, so some way was tried.
    assert refused is not None
    return Attempt(None, refused, barred)


def while_breaking(left: Cells, breaking: Breaking, physics: Physics) -> Verdict:
    """How the rest bears that a part comes off it; pieces that do not touch the part are left out.

    Raises:
        PlanError: the solver failed.
    """
    worst = STANDS
    for piece in pieces(left):
        felt = [cell for cell in breaking.loads if cell in piece]
        if not felt:
            continue
        numbered = sorted(piece)
        programme = Programme(as_array(numbered), physics)
        loads = programme.weights()
        for cell in felt:
            loads[numbered.index(cell)] += breaking.loads[cell]
        verdict = to_verdict(programme.solve(loads), numbered)
        worst = min(worst, verdict, key=lambda v: v.margin)
    return worst


def pull_of(cells: Cells, cell: Cell, physics: Physics) -> Attempt:
    """As ``assess_removal``, by a straight pull alone: the baseline."""
    left = cells - {cell}
    pull = next(b for b in breakings(cells, cell, physics) if b.way == PULL)
    verdict = min(
        while_breaking(left, pull, physics), assess(left, physics), key=lambda v: v.margin
    )
    removal = Removal(cell, "pull", None, None, verdict.margin, pull.force_n)
    return Attempt(removal if verdict.margin >= physics.least_margin else None, verdict)
