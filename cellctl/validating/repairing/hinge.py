"""What each cell contributes to a collapse in which one rigid piece comes off.

The kinematic theorem of limit analysis: for any imagined motion, a structure that stands
dissipates at its joints at least the power of its loads. For a piece that moves rigidly while the
rest stays, both are linear in the cells: so one collapse yields an inequality for every structure
that has these joints or fewer, whichever cells of the piece it has. The joints are those of
``cellctl.validating.stability``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells
from cellctl.validating.stability import Physics

Floats = npt.NDArray[np.float64]

_SIDES = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))


class Hinge(NamedTuple):
    """An inequality: the loads of the cells that are there must not exceed ``limit``."""

    loads: dict[Cell, float]
    """Of every cell of the piece; negative where it is a counterweight."""
    limit: float
    """What the joints and the margin leave; it is exceeded by the structure at hand."""


def hinge(
    moving: Cells, state: Cells, placed: Cell | None, resting: bool, physics: Physics
) -> Hinge | None:
    """The strongest inequality for a piece that comes off rigidly; None if it does not.

    Args:
        moving: the cells that come off.
        state: all that stand.
        placed: the cell that is being placed, if any.
        resting: whether ``placed`` rests on something, so that it may be pushed aside, too.
        physics: what holds them.
    """
    conditions, pulls = _joints(moving, state, physics)
    if conditions is None:
        return None
    weights = {cell: _wrench(cell, (0.0, 0.0, -physics.weight_n), 0.0) for cell in sorted(moving)}
    total = np.sum(list(weights.values()), axis=0)
    pushes: list[Floats] = [np.zeros(6)]
    if placed in moving and placed is not None:
        down = -physics.placement_down_n
        sides = _SIDES if resting else ((0.0, 0.0),)
        pushes += [
            _wrench(
                placed,
                (x * physics.placement_side_n, y * physics.placement_side_n, down),
                0.5,
            )
            for x, y in sides
        ]
    worst: tuple[float, Floats, Floats] | None = None
    for push in pushes:
        answer = _least_pull(conditions, pulls, (total + push) / physics.magnet_force_n, physics)
        if answer is not None and (worst is None or answer[0] > worst[0]):
            worst = (*answer, push)
    if worst is None or worst[0] * physics.least_margin <= 1.0:
        return None
    _, velocity, push = worst
    force_n = physics.magnet_force_n
    loads = {cell: float(velocity @ weight) / force_n for cell, weight in weights.items()}
    return Hinge(loads, 1.0 / physics.least_margin - float(velocity @ push) / force_n)


def _wrench(cell: Cell, force: tuple[float, float, float], above: float) -> Floats:
    """Force, and its moment about the origin with the edge of a cell as the unit of length."""
    point = np.array([cell.x, cell.y, cell.z + above])
    return np.concatenate([force, np.cross(point, force)])


def _joints(moving: Cells, state: Cells, physics: Physics) -> tuple[Floats | None, Floats]:
    """What the joints can do to the piece, (6, 10 m), and its magnets' pull on it, (6,)."""
    columns: list[Floats] = []
    pulls = np.zeros(6)
    for cell in sorted(moving):
        for other in cell.neighbours():
            floor = other.z < 0
            if not floor and (other in moving or other not in state):
                continue
            along = np.array(cell, dtype=np.float64) - np.array(other)
            centre = np.array(cell) - along / 2
            u = np.roll(np.abs(along), 1)
            v = np.roll(np.abs(along), 2)
            corners = (
                (u, -u, v, -v) if physics.contact == "diamond" else (u + v, u - v, v - u, -u - v)
            )
            columns += [_at(centre + corner / 2, along) for corner in corners]
            columns += [_at(centre, shear) for shear in (u, -u, v, -v)]
            columns += [np.concatenate([np.zeros(3), s * along / 2]) for s in (1.0, -1.0)]
            if not floor or physics.floor_grips:
                pulls += _at(centre, -along)
    return (np.stack(columns, axis=1) if columns else None), pulls


def _at(point: Floats, force: Floats) -> Floats:
    return np.concatenate([force, np.cross(point, force)])


def _least_pull(
    conditions: Floats, pulls: Floats, loads: Floats, physics: Physics
) -> tuple[float, Floats] | None:
    """The least share of the magnets' force that balances loads (6,), and the motion (6,) that
    needs it; None where no share does."""
    joints = conditions.shape[1] // 10
    cost = np.zeros(conditions.shape[1] + 1)
    cost[-1] = 1.0
    slip = np.zeros((joints, len(cost)))
    for joint in range(joints):
        slip[joint, 10 * joint : 10 * joint + 4] = -physics.friction
        slip[joint, 10 * joint + 4 : 10 * joint + 10] = 1.0
    found = linprog(
        cost,
        A_ub=slip,
        b_ub=np.zeros(joints),
        A_eq=np.column_stack([conditions, pulls]),
        b_eq=-loads,
        bounds=(0, None),
        method="highs-ds",
    )
    if found.status != 0:
        return None
    return float(found.fun), -np.asarray(found.eqlin.marginals, dtype=np.float64)
