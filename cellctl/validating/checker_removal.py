"""What a part does to its neighbours while it comes off as a plan says, for the judge of plans.

Shares no code with the planner, only the model that docs/planning/changing.md states: the movement
is that of a rigid body at its beginning, and says of every joint whether it opens, opens about a
line that stays in touch, slides, or would be pressed together. Lengths are in halves of a part's
edge and forces in pulls of a magnet, with the part's centre as the origin.
"""

from __future__ import annotations

import itertools
from collections.abc import Set as AbstractSet
from typing import NamedTuple

import numpy as np

from cellctl.assembly import Cell, TakeOff
from cellctl.config import CellConfig
from cellctl.validating.checker_model import GRAVITY_M_S2, Floats

_STILL = 1e-6
"""Slower than this is at rest: plans state hinges to the precision of a float."""
_SHORT = 0.01
"""By which share a stated force may be less than what is needed."""
_UP = np.array([0.0, 0.0, 1.0])


class TakingOff(NamedTuple):
    """What a stated way of taking a part does."""

    wrong: str
    """Why it cannot be, in words; empty if it can."""
    loads: dict[Cell, Floats]
    """What each neighbour feels: force (3) and moment (3) about its centre, in pulls of a magnet
    and halves of an edge."""


def taking_off(
    cells: AbstractSet[Cell], cell: Cell, stated: TakeOff | None, config: CellConfig
) -> TakingOff:
    """Work out a stated way of taking a part.

    Args:
        cells: what stands, ``cell`` included.
        cell: the part to take.
        stated: how; without it the part is pulled straight up, with whatever force that takes.
        config: the cell, with its ``[stability]``.
    """
    stability, half_m = config.stability, config.voxel.pitch_m / 2
    if stated is None:
        stated = TakeOff(how="pull", force_n=float("inf"))
    movement = _movement(stated, half_m)
    if movement is None:
        return TakingOff("it is not said about which axis it tilts", {})
    if _leans_into(cells, cell, stated):
        return TakingOff("it would tilt or turn into another part", {})
    linear, angular = movement
    # At unit speed, power is force; of a turn it is a couple, told as a force on a whole edge.
    power = config.voxel.mass_kg * GRAVITY_M_S2 / stability.magnet_force_n * float(linear @ _UP)
    loads = {}
    for axis, sign in itertools.product(range(3), (-1, 1)):
        beside = Cell(*(cell[k] + (sign if k == axis else 0) for k in range(3)))
        on_floor = beside.z < 0
        if not on_floor and beside not in cells:
            continue
        pull = 0.0 if on_floor and stability.floor == "bare" else 1.0
        face = _face(axis, sign, linear, angular, (pull, stability.friction, stability.contact))
        if face is None:
            return TakingOff("it would be pressed into a neighbour", {})
        load, taken = face
        power += taken
        if not on_floor:
            loads[beside] = load
    needed_n = power * stability.magnet_force_n / (1.0 if stated.how == "pull" else 2.0)
    if stated.force_n < needed_n * (1.0 - _SHORT):
        return TakingOff(f"{stated.force_n:g} N are stated and it takes {needed_n:.2f} N", {})
    return TakingOff("", loads)


def _movement(stated: TakeOff, half_m: float) -> tuple[Floats, Floats] | None:
    """How the part's centre moves and how it turns, at unit speed; None if that is unsaid."""
    if stated.how == "pull":
        return _UP, np.zeros(3)
    if stated.how == "twist":
        return np.zeros(3), _UP
    if stated.direction is None or stated.hinge_m is None or not any(stated.direction):
        return None
    if not all(part in (-1, 0, 1) for part in stated.direction):
        return None
    ahead = np.array([*stated.direction, 0.0])
    ahead /= np.linalg.norm(ahead)
    # The top, straight above the hinge, goes ahead; the centre circles about the hinge.
    turn = np.cross(_UP, ahead)
    hinge = (stated.hinge_m[0] * ahead + stated.hinge_m[1] * _UP) / half_m
    return np.cross(hinge, turn), turn


def _leans_into(cells: AbstractSet[Cell], cell: Cell, stated: TakeOff) -> bool:
    """Whether something stands where part and gripper lean or turn to, its own faces apart."""
    if stated.how == "pull":
        return False
    x, y, z = cell
    if stated.how == "twist":
        over = {(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)}
    else:
        i, j = stated.direction or (0, 0)
        over = {(x + i, y), (x, y + j), (x + i, y + j)} - {(x, y)}
        # Along a diagonal, the edge that goes foremost passes the part across it.
        back = -1 if stated.hinge_m is not None and stated.hinge_m[1] >= 0.0 else 1
        if i and j and Cell(x + back * i, y + back * j, z) in cells:
            return True
    return any(other.z > z and (other.x, other.y) in over for other in cells)


def _face(
    axis: int, sign: int, linear: Floats, angular: Floats, joint: tuple[float, float, str]
) -> tuple[Floats, float] | None:
    """What the neighbour behind one face feels, (6,), and the power that its joint takes up.

    None if the two would be pressed into each other. The joint is told by its pull, friction and
    contact.
    """
    pull, friction, contact = joint
    normal = np.zeros(3)
    normal[axis] = sign
    one, two = np.roll(np.eye(3), -axis - 1, axis=0)[:2]
    spots = (one, -one, two, -two) if contact == "diamond" else (one + two, one - two)
    corners = normal + np.array(spots if contact == "diamond" else (*spots, two - one, -one - two))
    away = -(linear + np.cross(angular, corners)) @ normal
    if away.min() < -_STILL:
        return None
    opening = -float((linear + np.cross(angular, normal)) @ normal)
    opens = opening > _STILL
    force, moment, power = np.zeros(3), np.zeros(3), 0.0
    if opens:
        # The magnets draw the neighbour after the part.
        force -= pull * normal
        power += pull * opening
    touching = corners[away < _STILL]
    if len(touching):
        spot = touching.mean(axis=0) if opens else normal
        # Where the faces stay in touch, they press with what the magnets pull, and rub.
        contact_force = pull * normal if opens else np.zeros(3)
        slide = linear + np.cross(angular, spot)
        slide = slide - (slide @ normal) * normal
        spin = float(angular @ normal)
        much = float(np.abs(slide).sum()) + abs(spin)
        if much > _STILL:
            # Shears and spin share one limit, each as fast as it slides; the arm must overcome
            # the whole circle of friction.
            contact_force = contact_force + friction * pull * slide / much
            moment += friction * pull * spin / much * normal
            power += friction * pull * float(np.sqrt(slide @ slide + spin**2))
        force = force + contact_force
        moment += np.cross(spot - normal, contact_force)
    # About the neighbour's centre, half an edge behind the face.
    return np.concatenate([force, moment - np.cross(normal, force)]), power
