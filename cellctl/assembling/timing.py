"""How long a path takes: trapezoids over straight legs and rounded corners.

Speed along the path is as high as each stretch allows, changes no faster than its acceleration, and
is zero at the ends and at corners without a blend. A blend of radius r leaves one leg at r before
the corner and joins the next at r after it, on an arc, as fast as both legs allow; the arc's own
radius and a bound on the centripetal acceleration limit the speed on it. UR does not publish its
blends; this is the shape that its documents draw.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cellctl.assembling.arm import Waypoint
from cellctl.assembling.poses import interpolate, to_matrix
from cellctl.config import Pose

BLEND_ACCELERATION_M_S2 = 10.0
"""Assumed bound on the centripetal acceleration in a blend."""
TURN_WEIGHT_M_PER_RAD = 0.5
"""Assumed: a radian of turning takes as long as this many metres."""

_STRAIGHT_RAD = 1e-3
_REVERSAL_RAD = math.pi - 1e-2


@dataclass(frozen=True)
class _Stretch:
    length_m: float
    speed_m_s: float
    acceleration_m_s2: float
    stops: bool


def duration_s(start: Pose, path: Sequence[Waypoint]) -> float:
    """Predicted time from rest at ``start`` to rest at the last waypoint."""
    return _profile_s(_stretches(start, path))


def turn_rad(before: Pose, corner: Pose, after: Pose) -> float:
    """Change of direction at a corner: 0 goes straight on (or nowhere), pi turns back."""
    arriving = np.subtract(corner[:3], before[:3])
    leaving = np.subtract(after[:3], corner[:3])
    lengths = float(np.linalg.norm(arriving) * np.linalg.norm(leaving))
    if lengths < 1e-12:
        return 0.0
    return math.acos(max(-1.0, min(1.0, float(arriving @ leaving) / lengths)))


def leg_length_m(start: Pose, end: Pose) -> float:
    """Length of a straight leg as its duration sees it: turning counts as way."""
    a, b = to_matrix(start), to_matrix(end)
    cosine = (float(np.trace(a[:3, :3].T @ b[:3, :3])) - 1.0) / 2.0
    turned_rad = math.acos(max(-1.0, min(1.0, cosine)))
    return max(math.dist(start[:3], end[:3]), TURN_WEIGHT_M_PER_RAD * turned_rad)


def blend_chord(before: Pose, corner: Waypoint, after: Pose) -> tuple[Pose, Pose]:
    """The poses where the blend of a corner begins and ends."""

    def towards(end: Pose) -> Pose:
        length_m = math.dist(corner.pose[:3], end[:3])
        share = corner.blend_radius_m / length_m if length_m > 0.0 else 0.0
        between = interpolate(to_matrix(corner.pose), to_matrix(end), min(1.0, share))
        x, y, z = (float(value) for value in between[:3, 3])
        return (x, y, z, *corner.pose[3:])

    return towards(before), towards(after)


def _stretches(start: Pose, path: Sequence[Waypoint]) -> list[_Stretch]:
    stretches = []
    begun_m = 0.0  # how much of the leg the blend before it has used up
    before = start
    for i, waypoint in enumerate(path):
        onward = path[i + 1] if i + 1 < len(path) else None
        blend_m = 0.0 if onward is None else waypoint.blend_radius_m
        turn = 0.0 if onward is None else turn_rad(before, waypoint.pose, onward.pose)
        if turn > _REVERSAL_RAD:
            blend_m = 0.0
        length_m = max(0.0, leg_length_m(before, waypoint.pose) - begun_m - blend_m)
        speed_m_s, a = waypoint.speed_m_s, waypoint.acceleration_m_s2
        stretches.append(_Stretch(length_m, speed_m_s, a, stops=blend_m == 0.0))
        if onward is not None and blend_m > 0.0:
            corner_m_s = min(speed_m_s, onward.speed_m_s)
            around_m = 2.0 * blend_m
            if turn > _STRAIGHT_RAD:
                radius_m = blend_m / math.tan(turn / 2.0)
                corner_m_s = min(corner_m_s, math.sqrt(BLEND_ACCELERATION_M_S2 * radius_m))
                around_m = radius_m * turn
            stretches.append(_Stretch(around_m, corner_m_s, a, stops=False))
        begun_m = blend_m
        before = waypoint.pose
    return stretches


def _profile_s(stretches: Sequence[_Stretch]) -> float:
    """Time over all stretches, from rest to rest."""
    speeds = [0.0]
    for i, stretch in enumerate(stretches[:-1]):
        reached = math.sqrt(speeds[-1] ** 2 + 2.0 * stretch.acceleration_m_s2 * stretch.length_m)
        passing = min(stretch.speed_m_s, stretches[i + 1].speed_m_s, reached)
        speeds.append(0.0 if stretch.stops else passing)
    speeds.append(0.0)
    total_s = 0.0
    for i, stretch in reversed(list(enumerate(stretches))):
        leave = speeds[i + 1]
        braking = math.sqrt(leave**2 + 2.0 * stretch.acceleration_m_s2 * stretch.length_m)
        speeds[i] = min(speeds[i], braking)
        total_s += _trapezoid_s(stretch, speeds[i], leave)
    return total_s


def _trapezoid_s(stretch: _Stretch, entry: float, leave: float) -> float:
    a = stretch.acceleration_m_s2
    peak = min(
        stretch.speed_m_s,
        math.sqrt(a * stretch.length_m + (entry**2 + leave**2) / 2.0),
    )
    ramps_m = (2.0 * peak**2 - entry**2 - leave**2) / (2.0 * a)
    ramps_s = (2.0 * peak - entry - leave) / a
    return ramps_s + max(0.0, stretch.length_m - ramps_m) / peak if peak > 0.0 else 0.0
