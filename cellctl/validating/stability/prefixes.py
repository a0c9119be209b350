"""Every state of an order."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells
from cellctl.validating.stability.assess import Verdict
from cellctl.validating.stability.growth import Growth
from cellctl.validating.stability.physics import Physics


def walk_order(
    order: Iterable[Cell], physics: Physics, given: Cells = frozenset()
) -> Iterator[Verdict]:
    """As ``assess_order``, step by step, for whoever may stop early."""
    growth = Growth(physics, given)
    for cell in order:
        yield growth.place(cell)


def assess_order(
    order: Sequence[Cell], physics: Physics, given: Cells = frozenset()
) -> tuple[Verdict, ...]:
    """One verdict a step: the worst of the state after it, and of the press that puts it there.

    Returns:
        Margins that are proven: no state has less than is said. The smallest of them is exact, or
        at least ``GOOD_MARGIN``.

    Raises:
        PlanError: the solver failed.
    """
    return tuple(walk_order(order, physics, given))
