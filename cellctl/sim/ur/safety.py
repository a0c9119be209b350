"""Robot mode and safety mode: stops, their recoveries, and the bits in which RTDE shows them.

Source of the numbers: Universal Robots' RTDE guide.
"""

from __future__ import annotations

from enum import IntEnum

from cellctl.sim.ur.options import UrOptions
from cellctl.sim.ur.registers import Registers


class RobotMode(IntEnum):
    """RTDE's ``robot_mode``."""

    POWER_OFF = 3
    POWER_ON = 4
    IDLE = 5
    RUNNING = 7


class SafetyMode(IntEnum):
    """RTDE's ``safety_mode``."""

    NORMAL = 1
    REDUCED = 2
    PROTECTIVE_STOP = 3
    SAFEGUARD_STOP = 5
    ROBOT_EMERGENCY_STOP = 7


_BITS = {
    SafetyMode.NORMAL: 1 << 0,
    SafetyMode.REDUCED: 1 << 1,
    SafetyMode.PROTECTIVE_STOP: 1 << 2 | 1 << 10,
    SafetyMode.SAFEGUARD_STOP: 1 << 4 | 1 << 10,
    SafetyMode.ROBOT_EMERGENCY_STOP: 1 << 6 | 1 << 7 | 1 << 10,
}
_JOINT_POWER_OFF = 239
_JOINT_MODE = {RobotMode.RUNNING: 253, RobotMode.IDLE: 255}
"""RTDE's ``joint_mode``; powered off in every other robot mode."""


class Safety:
    """The stops that are active, and how far the arm has been powered."""

    def __init__(self, options: UrOptions) -> None:
        self._options = options
        self.robot_mode = RobotMode.RUNNING
        self.emergency = False
        self.safeguard = False
        self.protective = False
        self.reduced = False
        """Whether a safety input asks for the reduced limits, which are not emulated."""
        self.popup = ""
        """Text of the safety popup on the pendant, if one is open."""
        self._protective_for_s = 0.0
        self._steps: list[tuple[float, RobotMode]] = []

    @property
    def mode(self) -> SafetyMode:
        """The strongest stop that is active."""
        if self.emergency:
            return SafetyMode.ROBOT_EMERGENCY_STOP
        if self.protective:
            return SafetyMode.PROTECTIVE_STOP
        if self.safeguard:
            return SafetyMode.SAFEGUARD_STOP
        return SafetyMode.REDUCED if self.reduced else SafetyMode.NORMAL

    @property
    def may_move(self) -> bool:
        """Whether a program may run and move the arm."""
        stopped = self.emergency or self.protective or self.safeguard
        return not stopped and self.robot_mode is RobotMode.RUNNING

    def trip_protective(self, cause: str) -> None:
        """A protective stop; the five seconds before it can be unlocked start over."""
        self.protective = True
        self.popup = f"Protective stop: {cause}"
        self._protective_for_s = 0.0

    def press_emergency(self) -> None:
        """The emergency stop button goes in. Power is for the caller to take off, at rest."""
        self.emergency = True
        self.protective = False
        self.popup = "Emergency stop"
        self._steps = []

    def release_emergency(self) -> None:
        """The button comes out. Power stays off."""
        self.emergency = False

    def unlock(self) -> bool:
        """Leave a protective stop; False if it is too early for that."""
        if self.protective and self._protective_for_s < self._options.unlock_after_s:
            return False
        self.protective = False
        return True

    def power_on(self) -> bool:
        """Switch the arm on, brakes held; False while an emergency stop is pressed."""
        if self.emergency:
            return False
        if self.robot_mode is RobotMode.POWER_OFF:
            self.robot_mode = RobotMode.POWER_ON
            self._steps = [(self._options.power_on_s, RobotMode.IDLE)]
        return True

    def release_brakes(self) -> bool:
        """Release the brakes, switching on first if need be; False as for ``power_on``."""
        if not self.power_on():
            return False
        if self.robot_mode is not RobotMode.RUNNING and not any(
            mode is RobotMode.RUNNING for _, mode in self._steps
        ):
            self._steps.append((self._options.brake_release_s, RobotMode.RUNNING))
        return True

    def power_off(self) -> None:
        """Switch the arm off."""
        self._steps = []
        self.robot_mode = RobotMode.POWER_OFF

    def advance(self, duration_s: float) -> None:
        """Let time pass: powering on, and the wait after a protective stop."""
        self._protective_for_s += duration_s
        if not self._steps:
            return
        rest_s, mode = self._steps[0]
        if rest_s > duration_s:
            self._steps[0] = (rest_s - duration_s, mode)
        else:
            self._steps.pop(0)
            self.robot_mode = mode

    def show(self, registers: Registers) -> None:
        """Write modes and bits to where RTDE reads them."""
        mode = self.mode
        registers.robot_mode = self.robot_mode
        registers.safety_mode = registers.safety_status = mode
        registers.safety_status_bits = _BITS[mode]
        registers.joint_mode = (_JOINT_MODE.get(self.robot_mode, _JOINT_POWER_OFF),) * 6
