"""Movements without a planned end: braking, constant speed, and following a moving target."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from cellctl.sim.plant import Floats
from cellctl.sim.ur.kinematics import Kinematics, inverse_matrix, rotation_matrix
from cellctl.sim.ur.options import Six
from cellctl.sim.ur.trajectory import MotionError


class Motion(Protocol):
    """Something that moves the arm."""

    @property
    def scalable(self) -> bool:
        """Whether the speed slider and pauses slow it down; they do not slow down a stop."""
        ...

    @property
    def done(self) -> bool:
        """Whether it has nothing more to do."""
        ...

    def advance(self, duration_s: float, joints_rad: Six) -> Six:
        """The joints after a time, from where they are now.

        Raises:
            MotionError: the arm cannot do it.
        """
        ...


class JointBrake:
    """Deceleration of all joints in proportion, so that they come to rest together (``stopj``)."""

    scalable = False

    def __init__(self, velocity_rad_s: Six, deceleration_rad_s2: float) -> None:
        leading = max(abs(speed) for speed in velocity_rad_s)
        self._velocity = velocity_rad_s
        self._duration_s = leading / deceleration_rad_s2
        self._time_s = 0.0

    @property
    def done(self) -> bool:
        return self._time_s >= self._duration_s

    def advance(self, duration_s: float, joints_rad: Six) -> Six:
        before_s = self._time_s
        self._time_s = min(self._duration_s, before_s + duration_s)
        equivalent_s = _braked(self._time_s, self._duration_s) - _braked(before_s, self._duration_s)
        return _moved(joints_rad, self._velocity, equivalent_s)


class LineBrake:
    """Deceleration of the TCP along the line and about the axis on which it moves (``stopl``).

    Translation and rotation come to rest together; the one that takes longer sets the time, with
    the same number for its deceleration in m/s2 or rad/s2, as URScript's default has it.
    """

    scalable = False

    def __init__(
        self, twist: Six, deceleration: float, tcp: Floats, kinematics: Kinematics
    ) -> None:
        speed = max(math.hypot(*twist[:3]), math.hypot(*twist[3:]))
        self._twist = twist
        self._duration_s = speed / deceleration
        self._time_s = 0.0
        self._tcp = tcp
        self._kinematics = kinematics

    @property
    def done(self) -> bool:
        return self._time_s >= self._duration_s

    def advance(self, duration_s: float, joints_rad: Six) -> Six:
        before_s = self._time_s
        self._time_s = min(self._duration_s, before_s + duration_s)
        equivalent_s = _braked(self._time_s, self._duration_s) - _braked(before_s, self._duration_s)
        return _twisted(self._kinematics, self._tcp, joints_rad, self._twist, equivalent_s)


class JointSpeed:
    """``speedj``: constant joint speeds, reached with the acceleration of the leading joint."""

    scalable = True
    done = False

    def __init__(self, velocity_rad_s: Six) -> None:
        self._now = velocity_rad_s
        self.target_rad_s: Six = velocity_rad_s
        self.acceleration_rad_s2 = 1.0

    def advance(self, duration_s: float, joints_rad: Six) -> Six:
        change = self.acceleration_rad_s2 * duration_s
        self._now = _towards(self._now, self.target_rad_s, change)
        return _moved(joints_rad, self._now, duration_s)


class LineSpeed:
    """``speedl``: constant speed of the TCP, reached along a straight change of velocity."""

    scalable = True
    done = False

    def __init__(self, twist: Six, tcp: Floats, kinematics: Kinematics) -> None:
        self._now = twist
        self.target: Six = twist
        self.acceleration_m_s2 = 1.0
        self._tcp = tcp
        self._kinematics = kinematics

    def advance(self, duration_s: float, joints_rad: Six) -> Six:
        change = self.acceleration_m_s2 * duration_s
        self._now = _towards(self._now, self.target, change)
        return _twisted(self._kinematics, self._tcp, joints_rad, self._now, duration_s)


class JointServo:
    """``servoj``: follows a target that is moved all the time.

    The distance to the target shrinks with the look-ahead time as its time constant; gain is not
    emulated. Acceleration is bounded, so a far target is not jumped at.
    """

    scalable = False
    done = False

    def __init__(self, velocity_rad_s: Six, acceleration_rad_s2: float) -> None:
        self._now = velocity_rad_s
        self._acceleration_rad_s2 = acceleration_rad_s2
        self.target_rad: Six | None = None
        self.lookahead_s = 0.1

    def advance(self, duration_s: float, joints_rad: Six) -> Six:
        if self.target_rad is None:
            return joints_rad
        wanted = tuple(
            (target - q) / self.lookahead_s
            for target, q in zip(self.target_rad, joints_rad, strict=True)
        )
        change = self._acceleration_rad_s2 * duration_s
        self._now = _towards(self._now, wanted, change)
        return _moved(joints_rad, self._now, duration_s)


def _braked(time_s: float, duration_s: float) -> float:
    """How long at full speed covers the same distance as braking evenly for ``time_s``."""
    return time_s - time_s * time_s / (2.0 * duration_s) if duration_s > 0.0 else 0.0


def _moved(joints_rad: Six, velocity_rad_s: Six, duration_s: float) -> Six:
    q0, q1, q2, q3, q4, q5 = (
        q + speed * duration_s for q, speed in zip(joints_rad, velocity_rad_s, strict=True)
    )
    return (q0, q1, q2, q3, q4, q5)


def _twisted(
    kinematics: Kinematics, tcp: Floats, joints_rad: Six, twist: Six, duration_s: float
) -> Six:
    """The joints after the TCP has moved with a velocity (m/s, rad/s in the base frame)."""
    if duration_s == 0.0:
        return joints_rad
    pose = kinematics.flange(joints_rad) @ tcp
    moved = np.eye(4)
    moved[:3, 3] = pose[:3, 3] + np.array(twist[:3]) * duration_s
    moved[:3, :3] = rotation_matrix([w * duration_s for w in twist[3:]]) @ pose[:3, :3]
    result = kinematics.joints(moved @ inverse_matrix(tcp), joints_rad)
    if result is None:
        raise MotionError("the TCP is led out of reach")
    return result


def _towards(now: Six, target: tuple[float, ...], most: float) -> Six:
    """Move six values towards others, the leading one by ``most`` and all in proportion."""
    gaps = [b - a for a, b in zip(now, target, strict=True)]
    leading = max(abs(gap) for gap in gaps)
    share = 1.0 if leading <= most else most / leading
    v0, v1, v2, v3, v4, v5 = (a + gap * share for a, gap in zip(now, gaps, strict=True))
    return (v0, v1, v2, v3, v4, v5)
