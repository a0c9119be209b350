"""Whether one state of a structure stands, and how much stronger than needed its magnets are."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells, pieces
from cellctl.validating.stability.joints import Floats, Ints, Joint
from cellctl.validating.stability.loads import placement_pushes
from cellctl.validating.stability.physics import Physics
from cellctl.validating.stability.programme import Programme, Solution

_NO_PULL = 1e-9
"""A needed pull below this is rounding."""


class Verdict(NamedTuple):
    """How a state stands."""

    margin: float
    """How many times stronger the magnets are than this state needs; infinite where it needs none,
    0 where it cannot stand whatever the magnets. At least 1 stands."""
    weakest: Joint | None
    """The joint that would give way first; None where none has to pull."""
    moving: frozenset[Cell]
    """The cells that would move in the collapse; without one of them, or with one more part
    beneath or beside them, it would not happen like this."""


STANDS = Verdict(math.inf, None, frozenset())
"""Of a state that needs no magnets."""


def assess(cells: Cells, physics: Physics, placed: Cell | None = None) -> Verdict:
    """The worst of a state at rest and, where ``placed`` is given, while that part is pressed in.

    Args:
        cells: what stands, ``placed`` included.
        physics: what holds it.
        placed: the part that is just being placed.

    Returns:
        Exact margin, weakest joint and collapse.

    Raises:
        PlanError: the solver failed.
    """
    worst = STANDS
    for piece in pieces(cells):
        if not any(cell.z == 0 for cell in piece):
            return Verdict(0.0, None, piece)
        here = placed if placed in piece else None
        if here is None and rooted(piece):
            continue
        numbered = sorted(piece)
        programme = Programme(as_array(numbered), physics)
        for loads in _load_cases(programme, numbered, here, physics):
            verdict = to_verdict(programme.solve(loads), numbered)
            if verdict.margin < worst.margin:
                worst = verdict
    return worst


def _load_cases(
    programme: Programme, numbered: list[Cell], placed: Cell | None, physics: Physics
) -> Iterable[Floats]:
    """Loads (n, 6) of the state at rest and while the part is placed."""
    rest = programme.weights()
    if not rooted(numbered):
        yield rest
    if placed is not None:
        for push in placement_pushes(placed, frozenset(numbered), physics):
            loads = rest.copy()
            loads[numbered.index(placed)] += push
            yield loads


def rooted(cells: Iterable[Cell]) -> bool:
    """Whether every cell stands on a column of cells down to the floor.

    Such a state needs no magnets at rest: each joint between two parts of a column presses evenly
    with the weight above it, and all other joints do nothing.
    """
    found = frozenset(cells)
    return all(cell.z == 0 or cell.below() in found for cell in found)


def as_array(cells: Iterable[Cell]) -> Ints:
    """(n, 3)."""
    return np.array(list(cells), dtype=np.int64).reshape(-1, 3)


def to_verdict(solution: Solution, numbered: list[Cell]) -> Verdict:
    """A solution in terms of cells; ``numbered`` has them in the programme's order."""
    if solution.pull <= _NO_PULL:
        return STANDS
    moving = frozenset(numbered[number] for number in solution.moving.tolist())
    return Verdict(1.0 / solution.pull, solution.weakest, moving)
