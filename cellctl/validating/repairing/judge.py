"""Whether an object stands at every step of its building, by the stability of its states."""

from __future__ import annotations

import math
from functools import lru_cache

from cellctl.assembly import Cell
from cellctl.validating.repairing.collapse import Collapses, Mechanism, Stands
from cellctl.validating.repairing.hinge import hinge
from cellctl.validating.rules import Cells, lateral, supported
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
            least = min((held.margin for held in verdicts[:number]), default=math.inf)
            return _otherwise(order, number, physics, least)
    return Stands(order, min(verdict.margin for verdict in verdicts))


def _otherwise(
    order: tuple[Cell, ...], number: int, physics: Physics, margin: float
) -> Stands | Collapses:
    """From the first part of an order that does not hold on: whichever part holds, one by one.

    Args:
        order: all parts, layer by layer.
        number: how many of it hold.
        physics: what holds them.
        margin: the least of these.
    """
    placed = list(order[:number])
    left = list(order[number:])
    while left:
        standing = frozenset(placed)
        layer = [cell for cell in left if cell.z == left[0].z]
        failed: list[tuple[Verdict, Cell]] = []
        for cell in layer:
            if not supported(cell, standing) and standing.isdisjoint(lateral(cell)):
                continue
            verdict = assess(standing | {cell}, physics, cell)
            if verdict.margin >= physics.least_margin:
                margin = min(margin, verdict.margin)
                placed.append(cell)
                left.remove(cell)
                break
            failed.append((verdict, cell))
        else:
            verdict, cell = max(failed, key=lambda pair: pair[0].margin)
            begun = any(one.z == cell.z for one in standing)
            return _collapse(verdict, standing | {cell}, cell, physics, begun=begun)
    return Stands(tuple(placed), margin)


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


def _collapse(
    verdict: Verdict,
    state: Cells,
    placed: Cell | None,
    physics: Physics,
    *,
    begun: bool = False,
) -> Collapses:
    moving = verdict.moving or state
    resting = placed is not None and supported(placed, state)
    return Collapses(
        moving=moving,
        state=state,
        placed=placed,
        margin=verdict.margin,
        joint="" if verdict.weakest is None else verdict.weakest.describe(),
        inevitable=not begun,
        hinge=hinge(moving, state, placed, resting, physics),
    )
