"""Whether a state of a structure stands, for the judge of plans; shares no code with the planner.

The planner minimises the magnets' pull over forces of contact points. Here the pull is fixed at
what a joint may be asked for, and a balance of the joints' *resultants* is sought: at each joint a
press, two shears, a twist and two tilts of either sign, within the planes that bound them.
"""

from __future__ import annotations

import itertools
from collections.abc import Set as AbstractSet

import numpy as np
import numpy.typing as npt
from scipy.optimize import linprog
from scipy.sparse import coo_array

from cellctl.assembly import Cell
from cellctl.config import CellConfig

_GRAVITY_M_S2 = 9.80665
_SLACK = 1e-6
"""The share of a joint's strength that rounding may cost."""
_X, _Y, _Z = 0, 1, 2

Floats = npt.NDArray[np.float64]


def stands(cells: AbstractSet[Cell], config: CellConfig, pressed: Cell | None = None) -> bool:
    """Whether some forces within the joints' strength over the least margin balance all loads.

    Args:
        cells: what stands.
        config: the cell, with its ``[stability]``.
        pressed: a part that is being placed: it is pressed down too, and where it is set on
            something also pushed aside, in any of four directions.
    """
    pieces = _pieces(cells)
    return all(
        _piece_stands(piece, config, pressed if pressed in piece else None) for piece in pieces
    )


def _piece_stands(piece: set[Cell], config: CellConfig, pressed: Cell | None) -> bool:
    if not any(z == 0 for _, _, z in piece):
        return False
    on_columns = all(z == 0 or (x, y, z - 1) in piece for x, y, z in piece)
    if on_columns and pressed is None:
        # Each column carries itself.
        return True
    order = sorted(piece)
    balance, bounds = _balance(order, config)
    weight_n = config.voxel.mass_kg * _GRAVITY_M_S2
    rest = np.zeros((len(order), 6))
    rest[:, _Z] = -weight_n
    loads = [] if on_columns else [rest]
    if pressed is not None:
        down_n, side_n = config.stability.placement_down_n, config.stability.placement_side_n
        x, y, z = pressed
        sides = (
            ((1, 0), (-1, 0), (0, 1), (0, -1)) if z == 0 or (x, y, z - 1) in piece else ((0, 0),)
        )
        arm_m = config.voxel.pitch_m / 2
        for i, j in sides:
            load = rest.copy()
            # A force (fx, fy) at the height of the top face turns by (-fy, fx) about the centre.
            load[order.index(pressed)] += [
                i * side_n,
                j * side_n,
                -down_n,
                -j * side_n * arm_m,
                i * side_n * arm_m,
                0.0,
            ]
            loads.append(load)
    return all(_feasible(balance, bounds, load, config) for load in loads)


def _balance(order: list[Cell], config: CellConfig) -> tuple[coo_array, tuple[coo_array, Floats]]:
    """The equations of balance, and the planes that bound what joints bear, with their offsets.

    The unknowns of a joint are force (3) and moment (3) along x, y, z that the part on its lower
    side, or the floor, exerts on the other one, the moment about the middle of the faces.
    """
    number = {cell: index for index, cell in enumerate(order)}
    pitch_m = config.voxel.pitch_m
    stability = config.stability
    strength_n = stability.magnet_force_n / stability.least_margin * (1.0 + _SLACK)
    entries: list[tuple[int, int, float]] = []
    planes: list[tuple[int, int, float]] = []
    offsets: list[float] = []
    joint = 0
    for cell in order:
        for axis in (_X, _Y, _Z):
            lower = cell._replace(**{"xyz"[axis]: cell[axis] - 1})
            on_floor = axis == _Z and cell.z == 0
            if lower not in number and not on_floor:
                continue
            for body, sign in ((number[cell], 1.0), (number.get(lower, -1), -1.0)):
                if body < 0:
                    continue
                # The faces are half a cell down the axis from the upper part, up from the lower.
                arm_m = -sign * pitch_m / 2
                entries += [(6 * body + k, 6 * joint + k, sign) for k in range(6)]
                # r x f with r along the axis.
                one, two = (axis + 1) % 3, (axis + 2) % 3
                entries.append((6 * body + 3 + two, 6 * joint + one, sign * arm_m))
                entries.append((6 * body + 3 + one, 6 * joint + two, -sign * arm_m))
            holds_n = 0.0 if on_floor and stability.floor == "bare" else strength_n
            for plane in _planes(axis, pitch_m / 2, stability.friction, stability.contact):
                planes += [(len(offsets), 6 * joint + k, v) for k, v in enumerate(plane[:6]) if v]
                offsets.append(plane[6] * holds_n)
            joint += 1
    return (
        _sparse(entries, (6 * len(order), 6 * joint)),
        (_sparse(planes, (len(offsets), 6 * joint)), np.array(offsets)),
    )


def _planes(axis: int, arm_m: float, friction: float, contact: str) -> list[list[float]]:
    """Planes ``a . (force, moment) <= b * strength`` of one joint: six of a, and b."""
    one, two = (axis + 1) % 3, (axis + 2) % 3
    found = []
    for first, second in itertools.product((1.0, -1.0), repeat=2):
        tilts = (
            [(first / arm_m, second / arm_m)]
            if contact == "diamond"
            else [(first / arm_m, 0.0), (0.0, second / arm_m)]
        )
        for about_one, about_two in tilts:
            plane = [0.0] * 7
            plane[3 + one], plane[3 + two] = about_one, about_two
            plane[axis], plane[6] = -1.0, 1.0
            found.append(plane)
        for turn in (1.0, -1.0):
            plane = [0.0] * 7
            plane[one], plane[two], plane[3 + axis] = first, second, turn / arm_m
            plane[axis], plane[6] = -friction, friction
            found.append(plane)
    return found


def _feasible(
    balance: coo_array, bounds: tuple[coo_array, Floats], load: Floats, config: CellConfig
) -> bool:
    """Whether the equations and planes have a common point."""
    planes, offsets = bounds
    # In units of the magnets' force and of half a cell, as the solver likes numbers near one.
    force_n, arm_m = config.stability.magnet_force_n, config.voxel.pitch_m / 2
    unit = np.tile([force_n] * 3 + [force_n * arm_m] * 3, balance.shape[1] // 6)
    rows = np.tile([1.0 / force_n] * 3 + [1.0 / (force_n * arm_m)] * 3, len(load))
    equations = balance.tocsr().multiply(rows[:, None]).multiply(unit[None, :]).tocsc()
    limits = planes.tocsr().multiply(unit[None, :] / force_n).tocsc()
    found = linprog(
        np.zeros(balance.shape[1]),
        A_ub=limits,
        b_ub=offsets / force_n + 1e-9,
        A_eq=equations,
        b_eq=-load.ravel() * rows,
        bounds=(None, None),
        method="highs",
    )
    return bool(found.status == 0)


def _sparse(entries: list[tuple[int, int, float]], shape: tuple[int, int]) -> coo_array:
    rows, columns, values = zip(*entries, strict=True)
    return coo_array((values, (rows, columns)), shape=shape)


def _pieces(cells: AbstractSet[Cell]) -> list[set[Cell]]:
    """Parts that hang together by faces."""
    left, found = set(cells), []
    while left:
        piece, front = set(), [min(left)]
        while front:
            cell = front.pop()
            if cell in left:
                left.discard(cell)
                piece.add(cell)
                for axis, step in itertools.product("xyz", (1, -1)):
                    front.append(cell._replace(**{axis: getattr(cell, axis) + step}))
        found.append(piece)
    return found
