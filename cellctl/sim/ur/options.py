"""What the emulated controller is, and what is assumed where no real one could be asked.

Every field has a default; ``docs/emulated-controller.md`` says where each comes from.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Literal

from cellctl.errors import ConfigError

Vector = tuple[float, float, float]
Six = tuple[float, float, float, float, float, float]
"""Joint values (rad, rad/s ...), or a pose: metres, then a rotation vector in radians."""

TOOL_VOLTAGES_V = (0, 12, 24)
FORCE_NOISE_N = {"ur10e": 1.0, "ur10": 4.0}
"""Assumed standard deviation of each component of the force at the TCP: an e-Series has a sensor, a
CB3 reckons from the joints' currents."""
GIVING_M_N = {"ur10e": 0.0, "ur10": 5e-5}
"""Assumed: how far an arm is pushed off its controller's target for each newton at the TCP. That of
an e-Series is not asked for, and taken for stiff."""
FOLLOWING_S = {"ur10e": 0.0, "ur10": 0.008}
"""Assumed: so far behind its target an arm is that moves, as a time at its speed."""
PLACE_NOISE_M = {"ur10e": 0.0, "ur10": 2e-5}
"""Assumed standard deviation of where the TCP is, by its joints' encoders."""
_TURN = 2.0 * math.pi
_SLOW_RAD_S = math.radians(120.0)
_FAST_RAD_S = math.radians(180.0)


@dataclass(frozen=True, kw_only=True)
class UrOptions:
    """Settings of one emulated controller. Durations and rates are in cell time.

    Raises:
        ConfigError: a value is out of range; the message names the field.
    """

    model: Literal["ur10", "ur10e"] = "ur10e"
    host: str = "127.0.0.1"
    """Address to listen on; clients expect the fixed ports 30004, 30003 and 29999 there."""
    controller_version: Literal["3.15", "5.12"] = "5.12"
    """3.15 is a CB3 with a cycle of 8 ms, 5.12 an e-Series with a cycle of 2 ms."""
    clock_rate: float = 1.0
    """Cell seconds per wall second; the watchdog's window keeps its length in wall time."""
    initial_joints_rad: Six = (0.0, -1.5708, -1.5708, -1.5708, 1.5708, 0.0)
    serial_number: str = "20225500001"
    tool_voltage_v: int = 0
    """Supply of the tool's connector, as the installation has it: 0, 12 or 24 V."""

    joint_position_limit_rad: Six = (_TURN, _TURN, _TURN, _TURN, _TURN, _TURN)
    """Largest magnitude of each joint's position."""
    joint_speed_limit_rad_s: Six = (
        _SLOW_RAD_S,
        _SLOW_RAD_S,
        _FAST_RAD_S,
        _FAST_RAD_S,
        _FAST_RAD_S,
        _FAST_RAD_S,
    )
    tcp_speed_limit_m_s: float = 1.5
    tcp_box_m: tuple[Vector, Vector] | None = None
    """Minimum and maximum corner, in the base frame, that the TCP may not leave."""
    speed_tolerance: float = 1.05
    """A speed limit trips when it is exceeded by this factor."""

    program_stop_rad_s2: float = 5.0
    """Deceleration of the leading joint when a program ends, by the watchdog too."""
    protective_stop_rad_s2: float = 10.0
    safeguard_stop_rad_s2: float = 5.0
    emergency_stop_rad_s2: float = 10.0
    tcp_force_limit_n: float = 150.0
    """A force on the tool that grows beyond this makes a protective stop: a safety limit that real
    robots have under *Robot Limits* (its value there is the integrator's)."""
    pause_rad_s2: float = 2.0
    """For pausing and resuming on the dashboard."""
    speed_slider_rad_s2: float = 2.0
    """Acceleration of the leading joint with which the arm follows the speed slider."""
    blend_acceleration_m_s2: float = 10.0
    """Largest centripetal acceleration in a blend; it bounds the speed there."""
    blend_acceleration_rad_s2: float = 10.0
    """The same for blends of joint movements."""
    rotation_weight_m_per_rad: float = 0.5
    """A radian of rotation takes as long as this many metres of a linear movement."""
    overlapping_blends: Literal["skip", "stop"] = "skip"
    """``skip`` leaves the waypoint out, ``stop`` drops its blend and stops there."""
    steady_after_s: float = 0.5
    """How long the arm must be at rest before ``isSteady`` is true."""

    unlock_after_s: float = 5.0
    """A protective stop cannot be unlocked sooner."""
    power_on_s: float = 2.0
    brake_release_s: float = 1.0
    stop_reply: Literal["stopped", "failed"] = "stopped"
    """What the dashboard answers to ``stop`` when no program runs."""
    protective_stop_program: Literal["pause", "stop"] = "pause"
    """What becomes of the program in a protective stop."""
    paused_upload: Literal["start", "stop"] = "stop"
    """A script sent while a program is paused starts, or only stops the paused one."""
    safeguard_release: Literal["stay_paused", "resume"] = "stay_paused"
    local_control_stops_program: bool = True
    watchdog_stall_s: float = 0.02
    """A stall of the emulator counts as at most this much of a watchdog's window (wall time)."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name.endswith(("_s", "_s2", "_rad", "_m_per_rad")) or field.name in (
                "clock_rate",
                "speed_tolerance",
            ):
                self._check_numbers(field.name, value)
        if self.tcp_box_m is not None and not all(
            low < high for low, high in zip(*self.tcp_box_m, strict=True)
        ):
            raise ConfigError("tcp_box_m: each minimum must be less than its maximum.")
        if self.tool_voltage_v not in TOOL_VOLTAGES_V:
            raise ConfigError(f"tool_voltage_v = {self.tool_voltage_v}: must be 0, 12 or 24.")
        if not self.serial_number.isdigit():
            raise ConfigError("serial_number: only digits, the clients parse it as a number.")

    def _check_numbers(self, name: str, value: float | Six) -> None:
        numbers = value if isinstance(value, tuple) else (value,)
        if name != "initial_joints_rad" and not all(0.0 < number < math.inf for number in numbers):
            raise ConfigError(f"{name} = {value}: must be greater than 0.")
        if isinstance(value, tuple) and (
            len(numbers) != 6 or not all(math.isfinite(number) for number in numbers)
        ):
            raise ConfigError(f"{name} = {value}: must be six numbers.")

    @property
    def cycle_s(self) -> float:
        """The controller's own time step."""
        return 0.008 if self.controller_version == "3.15" else 0.002

    @property
    def version(self) -> tuple[int, int, int, int]:
        """Major, minor, bugfix and build number of the controller software."""
        return (3, 15, 8, 106339) if self.controller_version == "3.15" else (5, 12, 6, 1102099)
