"""Every state of an order."""

from __future__ import annotations

from collections.abc import Sequence

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells
from cellctl.validating.stability.assess import Verdict, assess
from cellctl.validating.stability.physics import Physics


def assess_order(
    order: Sequence[Cell], physics: Physics, given: Cells = frozenset()
) -> tuple[Verdict, ...]:
    """One verdict a step: the state after it, and while its part is pressed in."""
    verdicts = []
    cells = set(given)
    for cell in order:
        cells.add(cell)
        verdicts.append(assess(frozenset(cells), physics, cell))
    return tuple(verdicts)
