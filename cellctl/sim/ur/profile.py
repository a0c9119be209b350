"""Speed along a path: as fast as each stretch allows, from rest to rest."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

_NOTHING = 1e-12
"""A phase shorter than this is left out: its duration could not be told from rounding."""


@dataclass(frozen=True)
class Stretch:
    """A part of a path over which the limits are constant. Any unit of length, seconds."""

    length: float
    speed: float
    acceleration: float
    stops: bool = False
    """The path comes to rest at the end of this stretch."""


@dataclass(frozen=True)
class _Phase:
    start_s: float
    start: float
    speed: float
    acceleration: float


class SpeedProfile:
    """Trapezoids over a row of stretches.

    The speed at each joint between stretches is the highest from which every later one can still be
    met (a pass forward for accelerating, a pass back for braking); within a stretch the profile
    accelerates to its limit, holds it, and brakes to the speed at its end.
    """

    def __init__(self, stretches: Sequence[Stretch]) -> None:
        speeds = _joint_speeds(stretches)
        self._phases: list[_Phase] = []
        self._times: list[float] = []
        self.ends_s: list[float] = []
        """When each stretch is left."""
        time_s = 0.0
        start = 0.0
        for i, stretch in enumerate(stretches):
            for length, speed, acceleration in _phases(stretch, speeds[i], speeds[i + 1]):
                if length <= _NOTHING:
                    continue
                self._phases.append(_Phase(time_s, start, speed, acceleration))
                self._times.append(time_s)
                end_speed = math.sqrt(max(0.0, speed * speed + 2.0 * acceleration * length))
                time_s += 2.0 * length / (speed + end_speed)
                start += length
            self.ends_s.append(time_s)
        self.duration_s = time_s
        self.length = start

    def at(self, time_s: float) -> float:
        """Distance from the start after a time."""
        if time_s >= self.duration_s:
            return self.length
        if time_s <= 0.0:
            return 0.0
        phase = self._phases[bisect_right(self._times, time_s) - 1]
        elapsed = time_s - phase.start_s
        return phase.start + (phase.speed + 0.5 * phase.acceleration * elapsed) * elapsed


def _joint_speeds(stretches: Sequence[Stretch]) -> list[float]:
    """Speed at the start, between neighbours, and at the end."""
    speeds = [0.0] * (len(stretches) + 1)
    for i in range(1, len(stretches)):
        before, after = stretches[i - 1], stretches[i]
        if before.stops:
            continue
        reached = math.sqrt(speeds[i - 1] ** 2 + 2.0 * before.acceleration * before.length)
        speeds[i] = min(before.speed, after.speed, reached)
    for i in range(len(stretches) - 1, 0, -1):
        after = stretches[i]
        from_here = math.sqrt(speeds[i + 1] ** 2 + 2.0 * after.acceleration * after.length)
        speeds[i] = min(speeds[i], from_here)
    return speeds


def _phases(
    stretch: Stretch, entry: float, leave: float
) -> tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]:
    """Length, initial speed and acceleration of speeding up, holding and braking."""
    a = stretch.acceleration
    peak = min(
        stretch.speed,
        math.sqrt((2.0 * a * stretch.length + entry * entry + leave * leave) / 2.0),
    )
    up = max(0.0, (peak * peak - entry * entry) / (2.0 * a))
    down = max(0.0, (peak * peak - leave * leave) / (2.0 * a))
    hold = max(0.0, stretch.length - up - down)
    return (up, entry, a), (hold, peak, 0.0), (down, peak, -a)
