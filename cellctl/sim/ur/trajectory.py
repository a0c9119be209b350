"""Movements that are planned as a whole: lines of the TCP and of the joints, with blends.

A trajectory has a time of its own. How fast that time runs (the speed slider, a pause, a stop on
the path) is for the arm that follows it.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from bisect import bisect_right
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from operator import attrgetter
from typing import Literal

import numpy as np

from cellctl.sim.plant import Floats
from cellctl.sim.ur.kinematics import (
    Kinematics,
    inverse_matrix,
    joint_distance,
    pose_matrix,
    rotation_matrix,
    rotation_vector,
)
from cellctl.sim.ur.options import Six, UrOptions
from cellctl.sim.ur.polyline import Line, Piece, build_pieces, can_blend
from cellctl.sim.ur.profile import SpeedProfile, Stretch

_TINY = 1e-9
_BISECTIONS = 24
_JUMP_RAD = 0.2
"""Two neighbouring points of a line whose joints differ by more belong to different arm shapes."""


class MotionError(Exception):
    """The arm cannot do a movement; the text is what the robot's log would say."""


@dataclass(frozen=True)
class Waypoint:
    """One movement of a program. SI units; ``target`` is a pose or six joint positions."""

    kind: Literal["line", "joint"]
    target: Six
    speed: float
    acceleration: float
    blend_m: float = 0.0
    number: int = 0
    """Its place in the program's path, for the progress that the program reports."""


def runs(waypoints: Iterable[Waypoint]) -> Iterator[list[Waypoint]]:
    """Waypoints of one kind in a row: there are no blends from one run to the next."""
    for _, run in groupby(waypoints, key=attrgetter("kind")):
        yield list(run)


class Trajectory(ABC):
    """A speed profile over the pieces of a rounded polyline."""

    scalable = True

    def __init__(
        self, waypoints: Sequence[Waypoint], pieces: list[Piece], stretches: list[Stretch]
    ) -> None:
        self._waypoints = waypoints
        self._pieces = pieces
        self._stretches = stretches
        self._profile = SpeedProfile(stretches)
        self._starts = [0.0]
        for stretch in stretches:
            self._starts.append(self._starts[-1] + stretch.length)
        self._leg_ends_s = [
            end_s
            for piece, end_s in zip(pieces, self._profile.ends_s, strict=True)
            if isinstance(piece, Line)
        ]
        self._time_s = 0.0

    @property
    def duration_s(self) -> float:
        """How long it takes at full speed."""
        return self._profile.duration_s

    @property
    def done(self) -> bool:
        """Whether its end has been reached."""
        return self._time_s >= self._profile.duration_s

    @property
    def waypoint(self) -> Waypoint:
        """The waypoint that is being approached.

        Where a blend begins it is the next one: there the robot's program goes on.
        """
        passed = bisect_right(self._leg_ends_s, self._time_s)
        return self._waypoints[min(passed, len(self._waypoints) - 1)]

    def advance(self, duration_s: float, joints_rad: Six) -> Six:
        """Follow it for a time; ``joints_rad`` is where the arm is now.

        Raises:
            MotionError: the next point is out of reach.
        """
        self._time_s = min(self.duration_s, self._time_s + duration_s)
        distance = self._profile.at(self._time_s)
        i = min(bisect_right(self._starts, distance) - 1, len(self._pieces) - 1)
        length = self._stretches[i].length
        fraction = (distance - self._starts[i]) / length if length > 0.0 else 1.0
        return self._joints(self._pieces[i], min(1.0, fraction), joints_rad)

    @abstractmethod
    def _joints(self, piece: Piece, fraction: float, near_rad: Six) -> Six: ...


class JointTrajectory(Trajectory):
    """Straight lines in joint space: all joints start and arrive together.

    Speed and acceleration are those of the leading joint.
    """

    def __init__(
        self,
        waypoints: Sequence[Waypoint],
        corners: Sequence[Floats],
        blends_rad: Sequence[float],
        options: UrOptions,
    ) -> None:
        self.target_rad = waypoints[-1].target
        pieces = build_pieces(corners, blends_rad)
        leading = [
            max(float(np.abs(piece.direction).max()), _TINY)
            for piece in pieces
            if isinstance(piece, Line)
        ]
        speeds = [w.speed / share for w, share in zip(waypoints, leading, strict=True)]
        rates = [w.acceleration / share for w, share in zip(waypoints, leading, strict=True)]
        stretches = _stretches(pieces, speeds, rates, options.blend_acceleration_rad_s2)
        super().__init__(waypoints, pieces, stretches)

    def _joints(self, piece: Piece, fraction: float, near_rad: Six) -> Six:  # noqa: ARG002
        if self.done:
            return self.target_rad
        q0, q1, q2, q3, q4, q5 = piece.point(fraction * piece.length).tolist()
        return (q0, q1, q2, q3, q4, q5)


class _Leg:
    """Orientation of the TCP on the way from one pose to the next."""

    def __init__(self, start: Floats, end: Floats) -> None:
        self.length_m = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
        self._start = start[:3, :3]
        self._turn = np.array(rotation_vector(start[:3, :3].T @ end[:3, :3]))
        self.turn_rad = float(np.linalg.norm(self._turn))

    def rotation(self, fraction: float) -> Floats:
        """3x3 orientation; beyond 0 and 1 the same turn goes on."""
        if self.turn_rad < _TINY:
            return self._start
        return self._start @ rotation_matrix((self._turn * fraction).tolist())


class LineTrajectory(Trajectory):
    """Straight lines of the TCP, the orientation turning evenly along each.

    In a blend the position follows the arc, and the orientation passes over from that of the line
    behind to that of the line ahead, smoothly.
    """

    def __init__(
        self,
        poses: Sequence[Floats],
        waypoints: Sequence[Waypoint],
        blends_m: Sequence[float],
        *,
        tcp: Floats,
        kinematics: Kinematics,
        options: UrOptions,
    ) -> None:
        pieces = build_pieces([pose[:3, 3] for pose in poses], blends_m)
        self._legs = [_Leg(one, other) for one, other in pairwise(poses)]
        self._tcp_inverse = inverse_matrix(tcp)
        self._kinematics = kinematics
        # A turn takes as long as a line of `weight` metres a radian, if that is the longer one.
        weight = options.rotation_weight_m_per_rad
        slower = [
            1.0 if leg.length_m < _TINY else max(1.0, weight * leg.turn_rad / leg.length_m)
            for leg in self._legs
        ]
        speeds = [w.speed / factor for w, factor in zip(waypoints, slower, strict=True)]
        rates = [w.acceleration / factor for w, factor in zip(waypoints, slower, strict=True)]
        stretches = _stretches(pieces, speeds, rates, options.blend_acceleration_m_s2)
        for i, piece in enumerate(pieces):
            leg = self._legs[piece.leg]
            if leg.length_m < _TINY:  # turns on the spot
                stretch = stretches[i]
                stretches[i] = Stretch(
                    weight * leg.turn_rad, stretch.speed, stretch.acceleration, stops=True
                )
        super().__init__(waypoints, pieces, stretches)

    def _joints(self, piece: Piece, fraction: float, near_rad: Six) -> Six:
        leg = self._legs[piece.leg]
        target = np.eye(4)
        target[:3, 3] = piece.point(fraction * piece.length)
        if isinstance(piece, Line):
            if leg.length_m > _TINY:
                fraction = (piece.offset + fraction * piece.length) / leg.length_m
            target[:3, :3] = leg.rotation(fraction)
        else:
            target[:3, :3] = self._blended_rotation(piece, fraction)
        joints_rad = self._kinematics.joints(target @ self._tcp_inverse, near_rad)
        if joints_rad is None:
            raise MotionError("the line is out of reach, or a joint's limit is in its way")
        if joint_distance(joints_rad, near_rad) > _JUMP_RAD:
            raise MotionError("a singularity is in the way of the line")
        return joints_rad

    def _blended_rotation(self, piece: Piece, fraction: float) -> Floats:
        assert not isinstance(piece, Line)
        behind, ahead = self._legs[piece.leg], self._legs[piece.leg + 1]
        past_m = fraction * piece.length
        one = behind.rotation(1.0 + (past_m - piece.blend) / behind.length_m)
        other = ahead.rotation((piece.blend - piece.length + past_m) / ahead.length_m)
        between = np.array(rotation_vector(one.T @ other))
        weight = fraction * fraction * (3.0 - 2.0 * fraction)
        return one @ rotation_matrix((between * weight).tolist())


@dataclass
class Planner:
    """Plans trajectories for one arm, and counts the waypoints whose blends it could not keep."""

    kinematics: Kinematics
    options: UrOptions
    overlaps: int = 0

    def plan(self, start_rad: Six, tcp: Floats, run: Sequence[Waypoint]) -> Trajectory:
        """A trajectory through waypoints that are all lines, or all joint movements.

        Raises:
            MotionError: a target is beyond a joint's limit or not a number.
        """
        if not all(math.isfinite(value) for w in run for value in w.target):
            raise MotionError("a target is not a number")
        if not all(w.speed > 0.0 and w.acceleration > 0.0 for w in run):
            raise MotionError("a movement needs a speed and an acceleration")
        if run[0].kind == "line":
            return self._line(start_rad, tcp, run)
        return self._joint(start_rad, tcp, run)

    def _line(self, start_rad: Six, tcp: Floats, run: Sequence[Waypoint]) -> LineTrajectory:
        start = self.kinematics.flange(start_rad) @ tcp

        def corner(waypoint: Waypoint) -> Floats:
            return pose_matrix(waypoint.target)

        def reach_m(before: Floats, here: Floats, after: Floats, blend_m: float) -> float:
            ok = can_blend(before[:3, 3], here[:3, 3], after[:3, 3])
            return blend_m if ok else 0.0

        def distance_m(one: Floats, other: Floats) -> float:
            return float(np.linalg.norm(other[:3, 3] - one[:3, 3]))

        kept, poses, blends = self._without_overlaps(start, run, corner, reach_m, distance_m)
        return LineTrajectory(
            poses, kept, blends, tcp=tcp, kinematics=self.kinematics, options=self.options
        )

    def _joint(self, start_rad: Six, tcp: Floats, run: Sequence[Waypoint]) -> JointTrajectory:
        for waypoint in run:
            if not self.kinematics.within_limits(waypoint.target):
                raise MotionError("a target is beyond a joint's position limit")

        def corner(waypoint: Waypoint) -> Floats:
            return np.array(waypoint.target)

        def reach_rad(before: Floats, here: Floats, after: Floats, blend_m: float) -> float:
            if blend_m <= 0.0 or not can_blend(before, here, after):
                return 0.0
            return min(
                self._joint_distance(here, before, tcp, blend_m),
                self._joint_distance(here, after, tcp, blend_m),
            )

        def distance_rad(one: Floats, other: Floats) -> float:
            return float(np.linalg.norm(other - one))

        kept, corners, blends = self._without_overlaps(
            np.array(start_rad), run, corner, reach_rad, distance_rad
        )
        return JointTrajectory(kept, corners, blends, self.options)

    def _without_overlaps(
        self,
        start: Floats,
        run: Sequence[Waypoint],
        corner: Callable[[Waypoint], Floats],
        reach: Callable[[Floats, Floats, Floats, float], float],
        distance: Callable[[Floats, Floats], float],
    ) -> tuple[list[Waypoint], list[Floats], list[float]]:
        """The waypoints that stay, all corners with the start, and each corner's blend."""
        kept = list(run)
        while True:
            corners = [start, *(corner(waypoint) for waypoint in kept)]
            blends = [0.0] * len(corners)
            for i in range(1, len(corners) - 1):
                blend_m = kept[i - 1].blend_m
                blends[i] = reach(corners[i - 1], corners[i], corners[i + 1], blend_m)
            overlapping = next(
                (
                    i
                    for i in range(1, len(corners) - 1)
                    if blends[i] > 0.0
                    and (
                        blends[i - 1] + blends[i] > distance(corners[i - 1], corners[i]) + _TINY
                        or blends[i] + blends[i + 1] > distance(corners[i], corners[i + 1]) + _TINY
                    )
                ),
                None,
            )
            if overlapping is None:
                return kept, corners, blends
            self.overlaps += 1
            waypoint = kept.pop(overlapping - 1)
            if self.options.overlapping_blends == "stop":
                kept.insert(overlapping - 1, replace(waypoint, blend_m=0.0))

    def _joint_distance(self, corner: Floats, other: Floats, tcp: Floats, blend_m: float) -> float:
        """Joint-space distance from a corner at which the TCP is ``blend_m`` away from it."""
        centre = (self.kinematics.flange(corner.tolist()) @ tcp)[:3, 3]
        whole = float(np.linalg.norm(other - corner))
        low, high = 0.0, 1.0
        for _ in range(_BISECTIONS):
            middle = (low + high) / 2.0
            q = corner + (other - corner) * middle
            away_m = np.linalg.norm((self.kinematics.flange(q.tolist()) @ tcp)[:3, 3] - centre)
            low, high = (middle, high) if away_m < blend_m else (low, middle)
        return high * whole


def _stretches(
    pieces: Sequence[Piece], speeds: Sequence[float], rates: Sequence[float], centripetal: float
) -> list[Stretch]:
    """Limits of each piece; ``speeds`` and ``rates`` are by leg, ``centripetal`` is for arcs."""
    stretches = []
    for i, piece in enumerate(pieces):
        leg = piece.leg
        if isinstance(piece, Line):
            stops = i + 1 == len(pieces) or isinstance(pieces[i + 1], Line)
            stretches.append(Stretch(piece.length, speeds[leg], rates[leg], stops))
        else:
            speed = min(speeds[leg], speeds[leg + 1], (centripetal * piece.radius) ** 0.5)
            stretches.append(Stretch(piece.length, speed, min(rates[leg], rates[leg + 1])))
    return stretches
