"""Everything the controller shows and takes by RTDE: one memory, named as RTDE names it."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

from cellctl.sim.ur.options import Six, Vector

_ZERO: Six = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
REGISTERS = 48


@dataclass
class Registers:
    """The controller's memory. Fields are RTDE variables in their SI units; vectors are tuples."""

    # RTDE writes TCP in capitals, and a getter for each variable follows from the field's name.
    timestamp: float = 0.0
    target_q: Six = _ZERO
    target_qd: Six = _ZERO
    target_qdd: Six = _ZERO
    target_current: Six = _ZERO
    target_moment: Six = _ZERO
    actual_q: Six = _ZERO
    actual_qd: Six = _ZERO
    actual_current: Six = _ZERO
    joint_control_output: Six = _ZERO
    actual_TCP_pose: Six = _ZERO  # noqa: N815
    actual_TCP_speed: Six = _ZERO  # noqa: N815
    actual_TCP_force: Six = _ZERO  # noqa: N815
    target_TCP_pose: Six = _ZERO  # noqa: N815
    target_TCP_speed: Six = _ZERO  # noqa: N815
    actual_digital_input_bits: int = 0
    joint_temperatures: Six = (30.0, 30.0, 30.0, 31.0, 31.0, 32.0)
    actual_execution_time: float = 0.0002
    robot_mode: int = 7
    joint_mode: tuple[int, ...] = (253,) * 6
    safety_mode: int = 1
    safety_status: int = 1
    actual_tool_accelerometer: Vector = (0.0, 0.0, 9.81)
    speed_scaling: float = 1.0
    target_speed_fraction: float = 1.0
    actual_momentum: float = 0.0
    actual_main_voltage: float = 48.0
    actual_robot_voltage: float = 48.0
    actual_robot_current: float = 0.6
    actual_joint_voltage: Six = (48.0, 48.0, 48.0, 48.0, 48.0, 48.0)
    actual_digital_output_bits: int = 0
    runtime_state: int = 1
    elbow_position: Vector = (0.0, 0.0, 0.0)
    robot_status_bits: int = 1
    safety_status_bits: int = 1
    analog_io_types: int = 0
    standard_analog_input0: float = 0.0
    standard_analog_input1: float = 0.0
    standard_analog_output0: float = 0.004
    standard_analog_output1: float = 0.004
    io_current: float = 0.0
    tool_mode: int = 253
    tool_output_voltage: int = 0
    tool_output_current: float = 0.0
    tool_temperature: float = 32.0
    tcp_force_scalar: float = 0.0
    script_control_line: int = 0
    payload: float = 0.0
    payload_cog: Vector = (0.0, 0.0, 0.0)
    payload_inertia: Six = _ZERO
    ft_raw_wrench: Six = _ZERO
    tcp_offset: Six = _ZERO

    output_int: list[int] = field(default_factory=lambda: [0] * REGISTERS)
    output_double: list[float] = field(default_factory=lambda: [0.0] * REGISTERS)
    input_int: list[int] = field(default_factory=lambda: [0] * REGISTERS)
    input_double: list[float] = field(default_factory=lambda: [0.0] * REGISTERS)


_TYPES: dict[str, tuple[str, ...]] = {
    "DOUBLE": (
        *("timestamp", "actual_execution_time", "speed_scaling", "target_speed_fraction"),
        *("actual_momentum", "actual_main_voltage", "actual_robot_voltage"),
        *("actual_robot_current", "standard_analog_input0", "standard_analog_input1"),
        *("standard_analog_output0", "standard_analog_output1", "io_current"),
        *("tool_output_current", "tool_temperature", "tcp_force_scalar", "payload"),
    ),
    "VECTOR6D": (
        *("target_q", "target_qd", "target_qdd", "target_current", "target_moment"),
        *("actual_q", "actual_qd", "actual_current", "joint_control_output"),
        *("actual_TCP_pose", "actual_TCP_speed", "actual_TCP_force"),
        *("target_TCP_pose", "target_TCP_speed", "joint_temperatures", "actual_joint_voltage"),
        *("payload_inertia", "ft_raw_wrench", "tcp_offset"),
    ),
    "VECTOR3D": ("actual_tool_accelerometer", "elbow_position", "payload_cog"),
    "VECTOR6INT32": ("joint_mode",),
    "INT32": ("robot_mode", "safety_mode", "safety_status", "tool_output_voltage"),
    "UINT32": (
        *("runtime_state", "robot_status_bits", "safety_status_bits", "analog_io_types"),
        *("tool_mode", "script_control_line"),
    ),
    "UINT64": ("actual_digital_input_bits", "actual_digital_output_bits"),
}
OUTPUT_TYPE = {name: kind for kind, names in _TYPES.items() for name in names}

_SINCE = {"ft_raw_wrench": (5, 9), "tcp_offset": (5, 12)}
"""First software version (major, minor) that has a variable; the others are in both."""

_REGISTER = re.compile(r"(input|output)_(int|double)_register_(\d+)")
_BITS = re.compile(r"(input|output)_bit_registers(0_to_31|32_to_63)")

_INPUT_TYPE = {
    "speed_slider_mask": "UINT32",
    "speed_slider_fraction": "DOUBLE",
    "standard_digital_output_mask": "UINT8",
    "standard_digital_output": "UINT8",
    "configurable_digital_output_mask": "UINT8",
    "configurable_digital_output": "UINT8",
    "tool_digital_output_mask": "UINT8",
    "tool_digital_output": "UINT8",
    "standard_analog_output_mask": "UINT8",
    "standard_analog_output_type": "UINT8",
    "standard_analog_output_0": "DOUBLE",
    "standard_analog_output_1": "DOUBLE",
    "external_force_torque": "VECTOR6D",
}

Getter = Callable[[Registers], Any]


def output_variable(name: str, version: tuple[int, ...]) -> tuple[str, Getter] | None:
    """RTDE type of an output variable and how to read it; None if this version has none such."""
    if version[:2] < _SINCE.get(name, (0, 0)):
        return None
    if kind := OUTPUT_TYPE.get(name):
        return kind, attrgetter(name)
    if _BITS.fullmatch(name):
        return "UINT32", lambda _registers: 0
    match = _REGISTER.fullmatch(name)
    if match is None or int(match[3]) >= REGISTERS:
        return None
    read = attrgetter(f"{match[1]}_{match[2]}")
    index = int(match[3])
    return ("INT32" if match[2] == "int" else "DOUBLE"), lambda registers: read(registers)[index]


def input_type(name: str) -> str | None:
    """RTDE type of an input variable; None if there is none such."""
    if kind := _INPUT_TYPE.get(name):
        return kind
    match = _REGISTER.fullmatch(name)
    if match is None or match[1] != "input" or int(match[3]) >= REGISTERS:
        return None
    return "INT32" if match[2] == "int" else "DOUBLE"


def input_register(name: str) -> tuple[str, int] | None:
    """("int" or "double", index) when an input variable is a general purpose register."""
    match = _REGISTER.fullmatch(name)
    return (match[2], int(match[3])) if match else None
