"""The arm's upper arm and forearm as boxes along their axes, for movements in joint space.

A straight path keeps one configuration, with the elbow up where home has it; turning the joints may
take the elbow anywhere. Lengths: Universal Robots, "DH Parameters"; sideways offsets of the two
tubes: the robot's own description files. Both nominal, with half a tube's width and to spare.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from cellctl.assembling.obstacles import Body, Obstacles, first_named
from cellctl.assembling.poses import Floats
from cellctl.config import Joints

_TUBE = Body((-0.09, -0.09, -0.09), (0.09, 0.09, 0.09))
_SPACING_M = 0.09
_OWN = frozenset({"the arm's own foot", "the pedestal"})
"""What the upper arm is fixed on; its shoulder is always near."""


class _Lengths(NamedTuple):
    """In metres."""

    shoulder: float
    """Height of the shoulder's axis above the foot."""
    upper_arm: float
    forearm: float
    upper_arm_aside: float
    forearm_aside: float


_LENGTHS = {
    "ur10": _Lengths(0.1273, 0.612, 0.5723, 0.2209, 0.0490),
    "ur10e": _Lengths(0.1807, 0.6127, 0.57155, 0.1762, 0.0393),
}


def link_points(joints_rad: Joints, model: Literal["ur10", "ur10e"]) -> Floats:
    """Points along upper arm and forearm in the base frame, n x 3 in metres, shoulder left out."""
    lengths = _LENGTHS[model]
    turn, lift, bend = joints_rad[:3]
    outward = np.array([math.cos(turn), math.sin(turn), 0.0])
    aside = np.array([math.sin(turn), -math.cos(turn), 0.0])
    up = np.array([0.0, 0.0, 1.0])

    def along(angle_rad: float, length_m: float) -> Floats:
        # The links point the other way at angle 0: their lengths are negative in the DH table.
        way: Floats = -length_m * (math.cos(angle_rad) * outward + math.sin(angle_rad) * up)
        return way

    shoulder = lengths.shoulder * up
    upper = along(lift, lengths.upper_arm)
    fore = along(lift + bend, lengths.forearm)
    points = [
        *_spread(shoulder + lengths.upper_arm_aside * aside, upper, skip_first=True),
        *_spread(shoulder + upper + lengths.forearm_aside * aside, fore, skip_first=False),
    ]
    return np.array(points)


def links_touch(
    joints_rad: Joints, model: Literal["ur10", "ur10e"], obstacles: Sequence[Obstacles]
) -> str | None:
    """Name of an obstacle that the upper arm or the forearm touches, or None."""
    pose = np.eye(4)
    for point in link_points(joints_rad, model):
        pose[:3, 3] = point
        for group in obstacles:
            if _OWN.isdisjoint(group.names):
                name = first_named(group, group.gaps_m(_TUBE, pose) < 0.0)
                if name is not None:
                    return name
    return None


def _spread(start: Floats, way: Floats, *, skip_first: bool) -> list[Floats]:
    count = math.ceil(float(np.linalg.norm(way)) / _SPACING_M)
    return [start + way * (i / count) for i in range(1 if skip_first else 0, count + 1)]
