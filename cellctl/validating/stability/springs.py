"""How springs in place of the joints would share loads: a quick guess at forces that balance.

Each joint yields to what it bears in proportion, and the more the weaker it is in that direction:
so forces go many ways, and strain no joint without need. Whatever balances is a proof, whether the
joints are springs or not (witness.py); where the guess asks too much, the linear programme finds
the least.

Units inside: forces in N, moments in N times half an edge of a cell.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from cellctl.validating.stability.joints import FLOOR, Floats, Joints
from cellctl.validating.stability.physics import Physics

_LEAST_FRICTION = 0.1
"""Joints that hardly rub are taken for a little stiffer, lest the equations lose their digits."""
_OFF = 1e-9
"""Of the largest load: what is out of balance by more was not solved."""


def spread(joints: Joints, loads: Floats, physics: Physics) -> Floats | None:
    """What the joints would bear.

    Args:
        joints: of some parts.
        loads: cases of loads on each part, (k, n, 6): force in N and moment about its centre in
            N m.
        physics: what holds them.

    Returns:
        (k, m, 6), force in N and moment in N m about the centre of the faces, by the lower part on
        the upper one; None where some parts are held by nothing.
    """
    cases, count, _ = loads.shape
    stiff = _templates(physics.friction)
    inner = joints.lower != FLOOR
    upper, axis = joints.upper, joints.axis
    above, beneath, across = upper[inner], joints.lower[inner], axis[inner]
    blocks = np.zeros((count, count, 6, 6))
    blocks[above, beneath] = stiff.between[across]
    blocks[beneath, above] = stiff.between[across].transpose(0, 2, 1)
    own = np.bincount(3 * upper + axis, minlength=3 * count).reshape(count, 3) @ stiff.upper
    own += np.bincount(3 * beneath + across, minlength=3 * count).reshape(count, 3) @ stiff.lower
    blocks[np.arange(count), np.arange(count)] = own.reshape(count, 6, 6)
    whole = blocks.transpose(0, 2, 1, 3).reshape(6 * count, 6 * count)
    units = np.array([1.0, 1.0, 1.0, *(physics.pitch_m / 2,) * 3])
    sides = (loads / units).reshape(cases, -1).T
    try:
        moved = np.linalg.solve(whole, sides)
    except np.linalg.LinAlgError:
        return None
    if not np.abs(whole @ moved - sides).max() <= _OFF * np.abs(sides).max():
        return None
    each = moved.reshape(count, 6, cases)
    found = stiff.on_upper[axis] @ each[upper]
    found[inner] += stiff.on_lower[across] @ each[beneath]
    wrenches: Floats = -found.transpose(2, 0, 1) * units
    return wrenches


class _Stiffness(NamedTuple):
    """Of a joint along each of the three axes: what it takes to move its two parts by one."""

    upper: Floats
    """By the upper part on itself, (3, 36)."""
    lower: Floats
    """Of the lower one, (3, 36)."""
    between: Floats
    """What the lower one's movement asks of the upper one, (3, 6, 6)."""
    on_upper: Floats
    """What the joint bears as its upper part moves, (3, 6, 6)."""
    on_lower: Floats
    """The same of its lower part."""


@lru_cache(maxsize=4)
def _templates(friction: float) -> _Stiffness:
    """By how readily a joint takes up each force and moment: the square of what it can bear."""
    on_upper, on_lower = np.zeros((2, 3, 6, 6))
    ease = np.full((3, 6), max(friction, _LEAST_FRICTION) ** 2)
    for axis in range(3):
        along = np.eye(3)[axis]
        lever = np.cross(along, np.eye(3)).T
        on_upper[axis] = np.eye(6)
        on_upper[axis, 3:, :3] = -lever
        on_lower[axis] = -np.eye(6)
        on_lower[axis, 3:, :3] = -lever
        # It presses and pulls, and bears being tilted, with all that its magnets have.
        ease[axis, [axis, 3 + (axis + 1) % 3, 3 + (axis + 2) % 3]] = 1.0
    by_upper = ease[:, :, None] * on_upper.transpose(0, 2, 1)
    by_lower = ease[:, :, None] * on_lower.transpose(0, 2, 1)
    return _Stiffness(
        (on_upper @ by_upper).reshape(3, 36),
        (on_lower @ by_lower).reshape(3, 36),
        on_upper @ by_lower,
        by_upper,
        by_lower,
    )
