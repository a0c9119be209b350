"""How long a path takes: trapezoids of speed over straight legs and rounded corners.

Speed along the path is as high as each stretch allows, changes no faster than its acceleration, and
is zero at the ends and at corners without a blend. A blend is as fast as both of its legs allow;
its own radius and a bound on the centripetal acceleration limit the speed on it. Acceleration jumps
where a trapezoid begins or ends: a controller rounds that off by itself, in some milliseconds.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import NamedTuple

import numpy as np

from cellctl.assembling.poses import Floats
from cellctl.assembling.rounded import Piece, even


class _Stretch(NamedTuple):
    length: float
    speed: float
    acceleration: float
    stops: bool


@dataclass(frozen=True)
class Timing:
    """When the arm is where, from rest at a path's start to rest at its end.

    Lengths are metres of a line, or radians of all joints together; speeds and accelerations are
    the same a second and a second squared.

    Args:
        pieces: of the path.
        blend_acceleration: the most across a blend.
        speeds: of each leg.
        accelerations: of each leg.
    """

    pieces: tuple[Piece, ...]
    blend_acceleration: float
    speeds: tuple[float, ...]
    accelerations: tuple[float, ...]

    @property
    def duration_s(self) -> float:
        """From rest to rest."""
        return sum(self.seconds)

    @property
    def seconds(self) -> list[float]:
        """How long each piece takes."""
        return [
            _trapezoid_s(stretch, entry, leave)
            for stretch, (entry, leave) in zip(
                self._stretches, itertools.pairwise(self._joint_speeds), strict=True
            )
        ]

    def samples(self) -> tuple[Floats, Floats]:
        """Speed and acceleration along the path at each sample of each piece."""
        counts = tuple(len(piece.shares) for piece in self.pieces)
        rows = np.array(
            [
                (entry, leave, stretch.speed, stretch.acceleration, stretch.length)
                for stretch, (entry, leave) in zip(
                    self._stretches, itertools.pairwise(self._joint_speeds), strict=True
                )
            ]
        )
        entry, leave, most, rate, length = np.repeat(rows, counts, axis=0).T
        way = length * _evens(counts)
        up = np.sqrt(entry**2 + 2.0 * rate * way)
        down = np.sqrt(leave**2 + 2.0 * rate * (length - way))
        speed = np.minimum(most, np.minimum(up, down))
        return speed, np.where(speed < most, np.where(up < down, rate, -rate), 0.0)

    @cached_property
    def _stretches(self) -> tuple[_Stretch, ...]:
        stretches = []
        for i, piece in enumerate(self.pieces):
            speed, a = self.speeds[piece.leg], self.accelerations[piece.leg]
            if piece.arc:
                curve = math.sqrt(self.blend_acceleration * piece.radius)
                speed = min(speed, self.speeds[piece.leg + 1], curve)
                a = min(a, self.accelerations[piece.leg + 1])
            stops = not piece.arc and (i + 1 == len(self.pieces) or not self.pieces[i + 1].arc)
            stretches.append(_Stretch(piece.length, speed, a, stops))
        return tuple(stretches)

    @cached_property
    def _joint_speeds(self) -> tuple[float, ...]:
        """Speed at the start, between neighbours, and at the end."""
        stretches = self._stretches
        speeds = [0.0]
        for stretch, after in itertools.pairwise(stretches):
            reached = math.sqrt(speeds[-1] ** 2 + 2.0 * stretch.acceleration * stretch.length)
            passing = min(stretch.speed, after.speed, reached)
            speeds.append(0.0 if stretch.stops else passing)
        speeds.append(0.0)
        for i, stretch in reversed(list(enumerate(stretches))):
            braking = math.sqrt(speeds[i + 1] ** 2 + 2.0 * stretch.acceleration * stretch.length)
            speeds[i] = min(speeds[i], braking)
        return tuple(speeds)


@lru_cache(maxsize=64)
def _evens(counts: tuple[int, ...]) -> Floats:
    """Of pieces with so many samples: at which shares of its piece each is."""
    return np.concatenate([even(count) for count in counts])


def _trapezoid_s(stretch: _Stretch, entry: float, leave: float) -> float:
    a = stretch.acceleration
    peak = min(stretch.speed, math.sqrt(a * stretch.length + (entry**2 + leave**2) / 2.0))
    ramps = (2.0 * peak**2 - entry**2 - leave**2) / (2.0 * a)
    ramps_s = (2.0 * peak - entry - leave) / a
    return ramps_s + max(0.0, stretch.length - ramps) / peak if peak > 0.0 else 0.0
