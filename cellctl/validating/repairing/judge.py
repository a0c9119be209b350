"""Whether an object stands at every step of its building, by the stability of its states."""

from __future__ import annotations

from functools import lru_cache

from cellctl.assembly import Cell
from cellctl.validating.repairing.collapse import Collapses, Mechanism, Stands
from cellctl.validating.repairing.hinge import hinge
from cellctl.validating.rules import Cells, supported
from cellctl.validating.sequence import sequence
from cellctl.validating.stability import Physics, Verdict, assess, assess_order

_LONGEST_PROBE = 12
"""Rows and columns are tried up to this many cells; what holds longer is found when it matters."""


def judge(cells: Cells, physics: Physics) -> Stands | Collapses:
    """Order an object and assess every step of the order.

    Args:
        cells: connected, and accessible from above.
        physics: what holds them.
    """
    finished = assess(cells, physics)
    if finished.margin < physics.least_margin:
        return _collapse(finished, cells, None, physics)
    order = sequence(cells, longest_row(physics))
    verdicts = assess_order(order, physics)
    for number, verdict in enumerate(verdicts):
        if verdict.margin < physics.least_margin:
            return _collapse(verdict, frozenset(order[: number + 1]), order[number], physics)
    return Stands(order, min(verdict.margin for verdict in verdicts))


@lru_cache(maxsize=8)
def longest_row(physics: Physics) -> int:
    """How many cells a row may reach out from what carries it, as far as probed."""
    block = frozenset(Cell(x, y, z) for x in range(3) for y in range(3) for z in range(2))
    for length in range(1, _LONGEST_PROBE + 1):
        row = [Cell(3 + i, 1, 1) for i in range(length)]
        if assess(block | frozenset(row), physics, row[-1]).margin < physics.least_margin:
            return length - 1
    return _LONGEST_PROBE


@lru_cache(maxsize=8)
def probed(physics: Physics) -> tuple[Mechanism, ...]:
    """The simplest collapses: of a column that stands alone, and of a row over nothing."""
    found = []
    column = [Cell(0, 0, z) for z in range(_LONGEST_PROBE)]
    block = frozenset(Cell(x, y, z) for x in range(3) for y in range(3) for z in range(2))
    row = [Cell(3 + i, 1, 1) for i in range(_LONGEST_PROBE)]
    for base, added in ((frozenset[Cell](), column), (block, row)):
        for length in range(1, len(added) + 1):
            state = base | frozenset(added[:length])
            verdict = assess(state, physics, added[length - 1])
            if verdict.margin < physics.least_margin:
                found.append(
                    Mechanism.of(_collapse(verdict, state, added[length - 1], physics), state)
                )
                break
    return tuple(found)


def _collapse(verdict: Verdict, state: Cells, placed: Cell | None, physics: Physics) -> Collapses:
    moving = verdict.moving or state
    resting = placed is not None and supported(placed, state)
    return Collapses(
        moving,
        state,
        placed,
        verdict.margin,
        "" if verdict.weakest is None else verdict.weakest.describe(),
        hinge(moving, state, placed, resting, physics),
    )
