"""Whether an object stands at every step of its building, by the stability of its states."""

from __future__ import annotations

import time
from functools import lru_cache

from cellctl.assembly import Cell
from cellctl.errors import PlanError
from cellctl.validating.access import Gripper
from cellctl.validating.order import lay_all, sketch_order
from cellctl.validating.repairing.collapse import Collapses, Mechanism, Stands
from cellctl.validating.repairing.hinge import hinge
from cellctl.validating.rules import Cells, lateral, supported
from cellctl.validating.stability import Physics, Verdict, assess
from cellctl.validating.stability.growth import Growth

_LONGEST_PROBE = 12
"""Rows and columns are tried up to this many cells; what holds longer is found when it matters."""


_LARGE = 60
"""Objects of more parts are judged by one order, as far as the time goes: to try several takes
seconds."""


def judge_until(
    cells: Cells, until_s: float, physics: Physics, gripper: Gripper
) -> Stands | Collapses | None:
    """As ``judge``, but of a large object by one order, and None where time ends that.

    Args:
        cells: connected, and accessible from above.
        until_s: a time of the monotonic clock.
        physics: what holds them.
        gripper: what comes down with each part.
    """
    if len(cells) <= _LARGE:
        return judge(cells, physics, gripper)
    try:
        order = sketch_order(cells, gripper)
    except PlanError:
        return None
    verdicts = []
    # Quick proofs first: what they cannot show is shown exactly, or refuted.
    growth = Growth(physics, thorough=False)
    for step, cell in enumerate(order):
        verdict = growth.place(cell)
        if verdict.margin < physics.least_margin:
            state = frozenset(order[: step + 1])
            verdict = assess(state, physics, cell)
            if verdict.margin < physics.least_margin:
                return _collapse(verdict, state, cell, physics, begun=True)
        verdicts.append(verdict)
        if time.monotonic() > until_s:
            return None
    return Stands(order, tuple(verdicts))


def judge(cells: Cells, physics: Physics, gripper: Gripper) -> Stands | Collapses:
    """Order an object so that it stands at every step, or tell where it would collapse.

    Args:
        cells: connected, and accessible from above.
        physics: what holds them.
        gripper: what comes down with each part.
    """
    finished = assess(cells, physics)
    if finished.margin < physics.least_margin:
        return _collapse(finished, cells, None, physics)
    try:
        order = lay_all(cells, physics, gripper)
    except PlanError:
        return _one_by_one(cells, physics)
    return Stands(order.cells, order.verdicts)


def _one_by_one(cells: Cells, physics: Physics) -> Stands | Collapses:
    """Layer by layer, whichever part holds next; where none does, the collapse of the best one."""
    placed: list[Cell] = []
    verdicts: list[Verdict] = []
    growth = Growth(physics, thorough=False)
    left = sorted(cells, key=lambda cell: (cell.z, not _grounded(cell, cells), cell))
    while left:
        standing = frozenset(placed)
        failed: list[tuple[Verdict, Cell]] = []
        for cell in [cell for cell in left if cell.z == left[0].z]:
            if not supported(cell, standing) and standing.isdisjoint(lateral(cell)):
                continue
            after = growth.copy()
            verdict = after.place(cell)
            if verdict.margin < physics.least_margin:
                # What the quick proofs could not show is shown exactly, or refuted.
                verdict = assess(standing | {cell}, physics, cell)
            if verdict.margin >= physics.least_margin:
                growth = after
                verdicts.append(verdict)
                placed.append(cell)
                left.remove(cell)
                break
            failed.append((verdict, cell))
        else:
            verdict, cell = max(failed, key=lambda pair: pair[0].margin)
            begun = any(one.z == cell.z for one in standing)
            return _collapse(verdict, standing | {cell}, cell, physics, begun=begun)
    return Stands(tuple(placed), tuple(verdicts))


def _grounded(cell: Cell, cells: Cells) -> bool:
    """Whether a column of cells carries it."""
    return all(Cell(cell.x, cell.y, z) in cells for z in range(cell.z))


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
