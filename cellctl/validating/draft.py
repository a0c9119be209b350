"""What is to be built and in which order, before it is known where in the workspace it stands."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from cellctl.assembly import Cell, Change, Check, Closeness, Weakest
from cellctl.config import LimitsSection
from cellctl.errors import PlanError
from cellctl.validating import words
from cellctl.validating.access import Gripper
from cellctl.validating.layer_orders import tight_fits
from cellctl.validating.order import find_order, sketch_order
from cellctl.validating.paper.policy import PaperPlan, judge
from cellctl.validating.paper.sequencing import Order as PaperOrder
from cellctl.validating.rules import (
    Cells,
    check_access,
    check_connectivity,
    check_count,
    check_grounded,
)
from cellctl.validating.stability import Joint, Physics, Verdict, assess_order
from cellctl.validating.stability.growth import GOOD_MARGIN

_SOUGHT_UP_TO = 150
"""Parts up to which an order is sought by proofs, which takes seconds; the order of a larger object
is sketched, and proven once."""
_ADVICE = {
    "count": "Make it smaller, or get more parts and tell of them (`limits.inventory_parts`, "
    "`cellctl refill`).",
    "connectivity": "Join the pieces by parts that touch face to face, or plan each by itself.",
    "grounded": "Move it down until a part is in layer 0.",
    "access": "Set something beneath these cells, or beside them in their layer.",
    "order": "Plan it anew from its cells.",
    "stability": "Support these cells from beneath, or plan it anew from its cells.",
    "overhang": "Let these cells reach out less far, or plan by the policy `cellctl`.",
    "stack": "Give this column a neighbour or make it lower, or plan by the policy `cellctl`.",
}
"""What to do about a check that failed, by its name."""
_PAPER_ADVICE = _ADVICE | dict.fromkeys(("connectivity", "access"), _ADVICE["order"])
"""The same where the paper's policy judges a given order: these two are about the order then."""


@dataclass(frozen=True)
class Draft:
    """An ordered object and what was asked of it; all checks have passed."""

    order: tuple[Cell, ...]
    checks: tuple[Check, ...]
    verdicts: tuple[Verdict, ...]
    """How it stands after each step."""
    policy: str = "cellctl"
    changes: tuple[Change, ...] = ()
    questions: tuple[str, ...] = ()
    closeness: Closeness | None = None
    wanted: Cells = frozenset()
    """Cells of the shape where some were changed; see ``BuildPlan``."""
    exact: bool = True
    """Whether the least margin is, or is at least ``GOOD_MARGIN``; else each is a lower bound."""

    @property
    def cells(self) -> Cells:
        """The finished object."""
        return frozenset(self.order)

    @property
    def weakest(self) -> Weakest | None:
        """The joint that comes nearest to giving way; None where no step needs a magnet."""
        step, verdict = min(enumerate(self.verdicts), key=lambda each: each[1].margin)
        if verdict.weakest is None or not math.isfinite(verdict.margin):
            return None
        return Weakest(
            step=step,
            margin=verdict.margin,
            cell=verdict.weakest.a,
            other=verdict.weakest.b,
            description=verdict.weakest.describe(),
        )

    def moved(self, dx: int, dy: int) -> Draft:
        """The same, so many cells further along x and y."""
        return self._put(lambda cell: Cell(cell.x + dx, cell.y + dy, cell.z))

    def mirrored(self, axis: Literal["x", "y"]) -> Draft | None:
        """The same object in the mirrored order, which stands as well; None where its mirror image
        is another object."""
        ends = [getattr(cell, axis) for cell in self.order]
        both = min(ends) + max(ends)
        image = self._put(lambda cell: cell._replace(**{axis: both - getattr(cell, axis)}))
        return replace(image, wanted=self.wanted) if image.cells == self.cells else None

    def _put(self, there: Callable[[Cell], Cell]) -> Draft:
        verdicts = tuple(
            Verdict(
                verdict.margin,
                verdict.weakest and Joint(there(verdict.weakest.a), there(verdict.weakest.b)),
                frozenset(there(cell) for cell in verdict.moving),
            )
            for verdict in self.verdicts
        )
        order = tuple(there(cell) for cell in self.order)
        wanted = frozenset(there(cell) for cell in self.wanted)
        return replace(self, order=order, verdicts=verdicts, wanted=wanted)


def draft(cells: Cells, physics: Physics, gripper: Gripper, parts: int) -> Draft:
    """Check cells and order them so that every state on the way stands.

    Raises:
        PlanError: they break a rule, or there is no order; the message names the rule and cells.
    """
    refuse_failed(_of_shape(cells, parts))
    if len(cells) > _SOUGHT_UP_TO:
        order = sketch_order(cells, gripper)
        return _proven(order, assess_order(order, physics), physics, parts)
    found = find_order(cells, physics, gripper)
    return _proven(found.cells, found.verdicts, physics, parts)


def redraft(
    order: Sequence[Cell],
    physics: Physics,
    gripper: Gripper,
    parts: int,
    verdicts: Sequence[Verdict] = (),
) -> Draft:
    """Check an order that is given.

    Args:
        order: the cells.
        physics: what holds them.
        gripper: what comes down with each.
        parts: how many there are.
        verdicts: of its steps, where they were proven before; then the least margin may be more
            than they say.

    Raises:
        PlanError: it breaks a rule; the message names the rule and cells.
    """
    refuse_failed((*_of_shape(frozenset(order), parts), check_order(order)))
    placed: set[Cell] = set()
    for cell in order:
        if blockers := gripper.blockers(cell, placed):
            raise PlanError(
                f"It breaks the rule of access: the part at {list(cell)} cannot come down past "
                f"{words.named(blockers)}.",
                "Plan it anew from its cells.",
                rule="access",
                cells=(cell, *blockers),
            )
        placed.add(cell)
    if len(verdicts) != len(order):
        return _proven(tuple(order), assess_order(order, physics), physics, parts)
    exact = min(verdict.margin for verdict in verdicts) >= GOOD_MARGIN
    return replace(_proven(tuple(order), tuple(verdicts), physics, parts), exact=exact)


def sharpened(draft: Draft, verdicts: Sequence[Verdict], physics: Physics) -> Draft:
    """The same with the exact least margin.

    Args:
        draft: one whose margins are lower bounds.
        verdicts: of its steps, by ``assess_order``.
        physics: what holds them.

    Raises:
        PlanError: it does not stand.
    """
    stands = check_stability(draft.order, verdicts, physics.least_margin)
    refuse_failed([stands])
    checks = tuple(stands if check.name == stands.name else check for check in draft.checks)
    return replace(draft, checks=checks, verdicts=tuple(verdicts), exact=True)


def paper_draft(found: PaperPlan, physics: Physics) -> Draft:
    """A plan by the paper's rules, which ask for no margin; where it has none, one is asked."""
    verdicts = assess_order(found.order, physics)
    failed = [n for n, verdict in enumerate(verdicts) if verdict.margin < physics.least_margin]
    questions: tuple[str, ...] = ()
    if failed:
        first = failed[0]
        questions = (
            "By the rules of the Speech-to-Reality paper it can be built, but by the strength of "
            f"its joints it would come apart in step {first + 1}. Shall I build it all the same?",
        )
    return Draft(found.order, found.checks, verdicts, "paper", found.changes, questions)


def paper_redraft(
    order: Sequence[Cell], physics: Physics, limits: LimitsSection, parts: int
) -> Draft:
    """Check an order that is given by the paper's rules.

    Raises:
        PlanError: it breaks one; the message names the rule and cells.
    """
    cells = frozenset(order)
    checks = judge(cells, PaperOrder(tuple(order)), limits, parts)
    refuse_failed(checks, _PAPER_ADVICE)
    return paper_draft(PaperPlan(cells, tuple(order), checks, ()), physics)


def check_order(order: Sequence[Cell]) -> Check:
    """Every part is grounded or touches a placed one, and none goes beneath another."""
    placed: set[Cell] = set()
    tops: dict[tuple[int, int], int] = {}
    wrong = []
    for cell in order:
        held = cell.z == 0 or any(beside in placed for beside in cell.neighbours())
        covered = tops.get((cell.x, cell.y), -1) > cell.z
        if not held or covered or cell in placed:
            wrong.append(cell)
        placed.add(cell)
        tops[cell.x, cell.y] = max(cell.z, tops.get((cell.x, cell.y), -1))
    tight = len(tight_fits(order))
    message = (
        f"{words.parts(len(wrong))} would float, or go beneath another."
        if wrong
        else "Every part rests on the floor or touches one before it; "
        f"{tight or 'none'} go{'es' if tight == 1 else ''} between two others."
    )
    return Check(name="order", passed=not wrong, message=message, cells=tuple(wrong))


def check_stability(
    order: Sequence[Cell], verdicts: Sequence[Verdict], least_margin: float
) -> Check:
    """The structure stands after every step, and while its part is pressed in."""
    step, worst = min(enumerate(verdicts), key=lambda each: each[1].margin)
    if worst.margin < least_margin:
        joint = "" if worst.weakest is None else f" at the joint {worst.weakest.describe()}"
        return Check(
            name="stability",
            passed=False,
            message=f"It would come apart in step {step + 1}, at {list(order[step])}{joint}: its "
            f"joints bear {worst.margin:.2f} times what is asked of them, and {least_margin:g} "
            "times is due.",
            cells=tuple(sorted(worst.moving or {order[step]}, key=lambda c: (c.z, c.x, c.y))),
        )
    message = (
        f"It stands at every step; the joints bear {worst.margin:.2f} times what the hardest step "
        "asks of them."
        if math.isfinite(worst.margin)
        else "It stands at every step, by its weight alone."
    )
    return Check(name="stability", passed=True, message=message)


def refuse_failed(checks: Sequence[Check], advice: Mapping[str, str] = _ADVICE) -> None:
    """Raises PlanError for the first check that failed, naming its rule and cells."""
    for check in checks:
        if not check.passed:
            raise PlanError(
                f"It breaks the rule of {check.name}: {check.message} "
                f"Cells: {words.named(check.cells)}.",
                advice[check.name],
                rule=check.name,
                cells=check.cells,
            )


def _of_shape(cells: Cells, parts: int) -> tuple[Check, ...]:
    return (
        check_count(cells, parts),
        check_connectivity(cells),
        check_grounded(cells),
        check_access(cells),
    )


def _proven(
    order: tuple[Cell, ...], verdicts: tuple[Verdict, ...], physics: Physics, parts: int
) -> Draft:
    checks = (
        *_of_shape(frozenset(order), parts),
        check_order(order),
        check_stability(order, verdicts, physics.least_margin),
    )
    refuse_failed(checks)
    return Draft(order, checks, verdicts)
