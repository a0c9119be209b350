"""Whether a structure bears that one of its parts is taken away."""

from __future__ import annotations

import numpy as np

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells, pieces
from cellctl.validating.stability.assess import STANDS, Verdict, as_array, assess, to_verdict
from cellctl.validating.stability.joints import Floats
from cellctl.validating.stability.loads import SIDES
from cellctl.validating.stability.physics import Physics
from cellctl.validating.stability.programme import Programme


def assess_removal(cells: Cells, cell: Cell, physics: Physics) -> Verdict:
    """The worst of what is left at rest, and while the part's joints are broken.

    The gripper lifts the part straight up, or tilts it about one of its edges, whichever the rest
    bears better. Until they part, the joints pull on the neighbours with all their force.

    Args:
        cells: what stands, ``cell`` included.
        cell: the part to take; nothing stands on it.
        physics: what holds it.

    Raises:
        PlanError: the solver failed.
    """
    left = cells - {cell}
    verdict = assess(left, physics)
    if verdict.margin == 0.0:
        return verdict
    pull = physics.magnet_force_n
    lever_m = physics.pitch_m / 2
    ways = [_under(left, _lifting(cell, left, physics), physics)]
    for x, y in SIDES:
        # Tilting: the contact at one edge presses as hard as the magnets pull, so the neighbour
        # beneath feels a moment and no force.
        loads: dict[Cell, Floats] = {}
        if cell.below() in left:
            loads[cell.below()] = np.array([0.0, 0.0, 0.0, x, y, 0.0]) * pull * lever_m
        loads |= _slipping(cell, left, physics)
        ways.append(_under(left, loads, physics))
    best = max(ways, key=lambda way: way.margin)
    return min(verdict, best, key=lambda v: v.margin)


def _lifting(cell: Cell, left: Cells, physics: Physics) -> dict[Cell, Floats]:
    """Loads (6,) on the neighbours of a part that is lifted straight up."""
    loads = _slipping(cell, left, physics)
    if cell.below() in left:
        loads[cell.below()] = np.array([0.0, 0.0, physics.magnet_force_n, 0.0, 0.0, 0.0])
    return loads


def _slipping(cell: Cell, left: Cells, physics: Physics) -> dict[Cell, Floats]:
    """Loads (6,) on the neighbours at the sides of a part: friction drags them up with it."""
    loads = {}
    drag = np.array([0.0, 0.0, physics.friction * physics.magnet_force_n])
    for x, y in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        neighbour = Cell(cell.x + x, cell.y + y, cell.z)
        if neighbour in left:
            arm_m = np.array([-x, -y, 0.0]) * physics.pitch_m / 2
            loads[neighbour] = np.concatenate([drag, np.cross(arm_m, drag)])
    return loads


def _under(left: Cells, extra: dict[Cell, Floats], physics: Physics) -> Verdict:
    """The state under its weight and the extra loads."""
    worst = STANDS
    for piece in pieces(left):
        numbered = sorted(piece)
        if not any(cell in piece for cell in extra):
            continue
        programme = Programme(as_array(numbered), physics)
        loads = programme.weights()
        for number, cell in enumerate(numbered):
            if cell in extra:
                loads[number] += extra[cell]
        worst = min(worst, to_verdict(programme.solve(loads), numbered), key=lambda v: v.margin)
    return worst
