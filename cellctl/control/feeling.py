"""What an arm tells of what it touches: by a force sensor, or by staying behind where it is told.

An e-Series has a sensor at its flange. A CB3 reckons forces from its joints' currents, with an
offset that drifts; where something is in the way, though, its arm stops following the controller's
target, and how far it is off that tells more.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Protocol

from cellctl.assembling.poses import to_matrix

if TYPE_CHECKING:
    from cellctl.assembling.arm import ArmState
    from cellctl.config import CellConfig
    from cellctl.config.machines import RobotSection
    from cellctl.config.section import Vector

_FAST_M_S = 0.3
"""An arm that is slower shows little of how far it is behind."""
_SPARE = 1.25
"""So many times what it showed may it be behind elsewhere on the same movement."""


class Feeling(Protocol):
    """One way to feel. What is read is along the vertical of the cell: more than 0 pushes up."""

    resting: int
    """How many states are averaged while the arm rests."""
    moving: int
    """The same while it moves, where waiting costs way."""
    touches: float
    """What counts as touching."""
    early: float
    """What is more than setting a part down asks for."""

    def upward(self, state: ArmState) -> float:
        """What one state says."""
        ...

    def begin(self) -> None:
        """A movement begins: what an earlier one showed counts no longer."""
        ...

    def watch(self, state: ArmState) -> None:
        """The arm moves where it can meet nothing: see what it says of itself there."""
        ...

    def slack(self, state: ArmState) -> float:
        """What an arm that moves says of itself at most, though it meets nothing."""
        ...

    def told(self, value: float) -> str:
        """A value for people, after "the part is"."""
        ...

    def amount(self, value: float) -> str:
        """The same without which way."""
        ...


class ByForce:
    """With a force sensor; values are in N.

    Args:
        robot: what counts.
        upward: the vertical of the cell, in the base frame.
    """

    resting = 3
    moving = 1

    def __init__(self, robot: RobotSection, upward: Vector) -> None:
        self._upward = upward
        self.touches = robot.touch_force_n
        self.early = robot.early_force_n

    def upward(self, state: ArmState) -> float:
        return _along(self._upward, state.tcp_force_n)

    def begin(self) -> None:
        """A sensor says nothing of itself."""

    def watch(self, state: ArmState) -> None:
        """A sensor says nothing of itself."""

    def slack(self, state: ArmState) -> float:  # noqa: ARG002 - the same form as the other
        return 0.0

    def told(self, value: float) -> str:
        return f"{'pressed up' if value >= 0.0 else 'pulled down'} with {self.amount(value)}"

    def amount(self, value: float) -> str:
        return f"{abs(value):.1f} N"


class ByMotion:
    """By how far the arm is from where its controller wants it; values are in metres.

    An arm that moves is a little behind its target though it meets nothing, the more the faster it
    is; that much does not count. How much it is, each movement shows on its way across; what is
    configured is the most that is believed.

    Args:
        robot, upward: as for ``ByForce``.
    """

    resting = 4
    moving = 2

    def __init__(self, robot: RobotSection, upward: Vector) -> None:
        self._upward = upward
        self._most_s = self._following_s = robot.following_s
        self._seen_s = 0.0
        self.touches = robot.touch_lag_m
        self.early = robot.early_lag_m

    def upward(self, state: ArmState) -> float:
        return _along(self._upward, state.tcp_lag_m)

    def begin(self) -> None:
        self._seen_s = 0.0
        self._following_s = self._most_s

    def watch(self, state: ArmState) -> None:
        if state.tcp_speed_m_s < _FAST_M_S:
            return
        behind_s = math.hypot(*state.tcp_lag_m) / state.tcp_speed_m_s
        self._seen_s = max(self._seen_s, behind_s)
        self._following_s = min(self._most_s, _SPARE * self._seen_s)

    def slack(self, state: ArmState) -> float:
        return state.tcp_speed_m_s * self._following_s

    def told(self, value: float) -> str:
        where = "above" if value >= 0.0 else "below"
        return f"held {self.amount(value)} {where} where the arm is told to be"

    def amount(self, value: float) -> str:
        return f"{abs(value) * 1000:.2f} mm"


def feeling_of(config: CellConfig) -> Feeling:
    """How the configured robot feels."""
    x, y, z = (float(one) for one in to_matrix(config.base.frame)[2, :3])
    by = ByForce if config.robot.model == "ur10e" else ByMotion
    return by(config.robot, (x, y, z))


def _along(axis: Vector, vector: Vector) -> float:
    return sum(a * b for a, b in zip(axis, vector, strict=True))
