"""What joints and TCP allow: the highest speeds and accelerations along a path that none exceeds.

Along a path of any kind, each joint turns by q'(s) and that rate changes by q''(s), a unit of way.
At a speed v and an acceleration a along the path, a joint turns at q' v and is accelerated by
q' a + q'' v^2; and so it is with the TCP.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cellctl.assembling.arm import JointWaypoint, Path, Waypoint
from cellctl.assembling.course import Course
from cellctl.assembling.poses import Floats
from cellctl.assembling.timing import Timing
from cellctl.config import Joints

_ROUNDS = 8
_ENOUGH = 1.005
"""A limit that is exceeded by less is kept: that is what sampling leaves."""
_LEAST_SHARE = 0.9
_SLOWER = 0.96
_LEAST_WAY = 1e-6
_TINY = 1e-9

Indexes = npt.NDArray[np.intp]


@dataclass(frozen=True)
class JointLimits:
    """Greatest joint speeds and accelerations, base to wrist 3."""

    speed_rad_s: Floats
    acceleration_rad_s2: Floats

    def direct_s(self, one_rad: Joints, other_rad: Joints) -> float:
        """How long the slowest joint takes from one position to another, from rest to rest, with
        nothing in the way."""
        way_rad = np.abs(np.subtract(one_rad, other_rad))
        speed, rate = self.speed_rad_s, self.acceleration_rad_s2
        cruising = way_rad / speed + speed / rate
        short = way_rad < speed**2 / rate
        return float(np.where(short, 2.0 * np.sqrt(way_rad / rate), cruising).max())


class Use:
    """How a path moves joints and TCP, per unit of its way.

    Args:
        course: the path.
    """

    def __init__(self, course: Course) -> None:
        self._course = course
        counts = [len(piece.shares) for piece in course.pieces]
        self._starts = np.cumsum([0, *counts[:-1]])
        steps = [
            piece.length / (count - 1) if piece.length > _LEAST_WAY else math.inf
            for piece, count in zip(course.pieces, counts, strict=True)
        ]
        step = np.repeat(steps, counts)[:, None]
        ends = self._starts + np.array(counts) - 1
        self._ends = ends
        self.turning, self.bending = _derivatives(course.joints_rad, step, self._starts, ends)
        """n x 6: q' and q''."""
        way, curve = _derivatives(course.points, step, self._starts, ends)
        self.moving = np.sqrt((way**2).sum(axis=1))
        """n: metres of the TCP a unit of way."""
        self.curving = np.sqrt((curve**2).sum(axis=1))
        """n: how that changes a unit of way."""

    def joint_speeds_rad_s(self, timing: Timing) -> Floats:
        """n x 6 at each sample of the path."""
        speed, _ = timing.samples()
        rates: Floats = self.turning * speed[:, None]
        return rates

    def joint_accelerations_rad_s2(self, timing: Timing) -> Floats:
        """n x 6 at each sample of the path."""
        speed, acceleration = timing.samples()
        rates: Floats = self.turning * acceleration[:, None] + self.bending * (speed**2)[:, None]
        return rates

    def tcp_speeds_m_s(self, timing: Timing) -> Floats:
        """At each sample of the path."""
        speed, _ = timing.samples()
        rates: Floats = self.moving * speed
        return rates

    def fitted(self, limits: JointLimits, tcp: Sequence[tuple[float, float]]) -> Timing:
        """As quick as the limits allow.

        An arc takes its speed from the legs beside it, so the shorter one of them pays for it.

        Args:
            limits: of the joints.
            tcp: of the TCP on each leg: greatest speed (m/s) and acceleration (m/s2).
        """
        speeds, rates = [math.inf] * len(tcp), [math.inf] * len(tcp)
        payer = self._payers(len(tcp))
        turning = _times(limits.speed_rad_s, self.turning)
        bending = _times(limits.acceleration_rad_s2, self.bending)
        ends = np.minimum(
            _times(limits.acceleration_rad_s2, self.turning[self._starts]),
            _times(limits.acceleration_rad_s2, self.turning[self._ends]),
        )
        for i, (piece, by_speed, by_bend, moving, curving) in enumerate(
            zip(
                self._course.pieces,
                self._least(turning),
                self._least(bending),
                self._most(self.moving),
                self._most(self.curving),
                strict=True,
            )
        ):
            leg = payer[i]
            tcp_speed, tcp_rate = tcp[leg]
            if piece.arc:
                tcp_rate = min(tcp[piece.leg][1], tcp[piece.leg + 1][1])
            else:
                rates[leg] = min(rates[leg], float(ends[i]), tcp_rate / max(moving, _TINY))
            speeds[leg] = min(
                speeds[leg],
                by_speed,
                math.sqrt(by_bend),
                tcp_speed / max(moving, _TINY),
                math.sqrt(tcp_rate / max(curving, _TINY)),
            )
        return self._tightened(speeds, rates, payer, limits)

    def _tightened(
        self, speeds: list[float], rates: list[float], payer: list[int], limits: JointLimits
    ) -> Timing:
        """With accelerations that leave room for what bending takes; slower where there is none."""
        most = limits.acceleration_rad_s2
        turning, bending = np.abs(self.turning), np.abs(self.bending)
        for _ in range(_ROUNDS):
            timing = self._timing(speeds, rates)
            speed, acceleration = timing.samples()
            used = self.turning * acceleration[:, None] + self.bending * (speed**2)[:, None]
            share = self._most((np.abs(used) / most).max(axis=1))
            if max(share) <= _ENOUGH:
                return timing
            room = (most - bending * (speed**2)[:, None]) / np.maximum(turning, _TINY)
            left = self._least(np.where(acceleration != 0.0, room.min(axis=1), np.inf))
            for leg, used_share, least in zip(payer, share, left, strict=True):
                if used_share <= _ENOUGH:
                    continue
                floor = _LEAST_SHARE * rates[leg]
                if least < floor:
                    speeds[leg] *= _SLOWER
                rates[leg] = min(rates[leg], max(least, floor))
        timing = self._timing(speeds, rates)
        worst = float((np.abs(self.joint_accelerations_rad_s2(timing)) / most).max())
        if worst > _ENOUGH:
            timing = self._timing(
                [speed / math.sqrt(worst) for speed in speeds], [rate / worst for rate in rates]
            )
        return timing

    def _timing(self, speeds: Sequence[float], rates: Sequence[float]) -> Timing:
        course = self._course
        return Timing(course.pieces, course.blend_acceleration, tuple(speeds), tuple(rates))

    def _least(self, values: Floats) -> list[float]:
        """The least of each piece."""
        return [float(value) for value in np.minimum.reduceat(values, self._starts)]

    def _most(self, values: Floats) -> list[float]:
        """The most of each piece."""
        return [float(value) for value in np.maximum.reduceat(values, self._starts)]

    def _payers(self, legs: int) -> list[int]:
        """The leg of each piece; of an arc, the shorter one beside it."""
        lengths = [0.0] * legs
        for piece in self._course.pieces:
            if not piece.arc:
                lengths[piece.leg] += piece.length
        return [
            min((piece.leg, piece.leg + 1), key=lengths.__getitem__) if piece.arc else piece.leg
            for piece in self._course.pieces
        ]


def timing_of(course: Course, path: Path) -> Timing:
    """With the speeds and accelerations that the waypoints have."""
    shares = leading_shares(course)
    speeds, rates = [], []
    for point, share in zip(path, shares, strict=True):
        if isinstance(point, JointWaypoint):
            speeds.append(point.speed_rad_s / share)
            rates.append(point.acceleration_rad_s2 / share)
        else:
            assert isinstance(point, Waypoint), "there are two kinds of corners"
            speeds.append(point.speed_m_s)
            rates.append(point.acceleration_m_s2)
    return Timing(course.pieces, course.blend_acceleration, tuple(speeds), tuple(rates))


def leading_shares(course: Course) -> list[float]:
    """How far the joint that turns farthest turns for a radian of all together, on each leg of a
    path on which the joints go straight."""
    shares = []
    for piece in course.pieces:
        if not piece.arc:
            way = np.abs(piece.values[-1] - piece.values[0])
            whole = math.sqrt(float(way @ way))
            shares.append(float(way.max()) / whole if whole > 0.0 else 1.0)
    return shares


def _derivatives(
    values: Floats, step: Floats, starts: Indexes, ends: Indexes
) -> tuple[Floats, Floats]:
    """First and second derivative by the way, of samples that are even within each piece."""
    slope, bend = np.empty_like(values), np.empty_like(values)
    slope[1:-1] = (values[2:] - values[:-2]) / (2.0 * step[1:-1])
    slope[starts] = 4.0 * values[starts + 1] - 3.0 * values[starts] - values[starts + 2]
    slope[ends] = 3.0 * values[ends] - 4.0 * values[ends - 1] + values[ends - 2]
    slope[starts] /= 2.0 * step[starts]
    slope[ends] /= 2.0 * step[ends]
    bend[1:-1] = (values[2:] - 2.0 * values[1:-1] + values[:-2]) / step[1:-1] ** 2
    bend[starts], bend[ends] = bend[starts + 1], bend[ends - 1]
    return slope, bend


def _times(limit: Floats, used: Floats) -> Floats:
    """At each sample, how many times its limit is what that joint uses which uses most of it."""
    least: Floats = (limit / np.maximum(np.abs(used), _TINY)).min(axis=1)
    return least
