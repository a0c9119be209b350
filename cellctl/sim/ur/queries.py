"""Commands that answer at once: settings, kinematics, and what the arm is doing.

The numbers are those of ``ur_rtde`` 1.6.5. Commands that need a hand or a force on the arm (force
mode, freedrive, teach mode, contact detection) are accepted and do nothing; no contact
is ever seen.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from cellctl.sim.plant import Floats
from cellctl.sim.ur.kinematics import inverse_matrix, matrix_pose, pose_matrix
from cellctl.sim.ur.machine import Machine, ProgramError, Window
from cellctl.sim.ur.options import Six


def solve(machine: Machine, pose: Six, near_rad: Six | None = None) -> Six:
    """Joints that put the TCP at a pose, nearest to ``near_rad`` or to where the arm is.

    Raises:
        ProgramError: there are none, at which the robot's program ends.
    """
    if not all(map(math.isfinite, pose)):
        raise ProgramError("get_inverse_kin: the pose is not a number")
    arm = machine.arm
    target = pose_matrix(pose) @ inverse_matrix(arm.tcp)
    joints_rad = arm.kinematics.joints(target, near_rad or arm.joints_rad)
    if joints_rad is None:
        raise ProgramError("get_inverse_kin: no solution")
    return joints_rad


def solvable(machine: Machine, pose: Six) -> bool:
    """Whether any joints put the TCP at a pose."""
    try:
        solve(machine, pose)
    except ProgramError:
        return False
    return True


def _set_payload(machine: Machine, window: Window) -> None:
    mass_kg, x, y, z = (window.number(i) for i in range(4))
    # The control program leaves the centre of gravity alone when it is given as the origin.
    cog_m = (x, y, z) if (x, y, z) != (0.0, 0.0, 0.0) else machine.registers.payload_cog
    machine.set_payload(mass_kg, cog_m)


def _set_target_payload(machine: Machine, window: Window) -> None:
    mass_kg, x, y, z = (window.number(i) for i in range(4))
    cog_m = (x, y, z) if (x, y, z) != (0.0, 0.0, 0.0) else machine.registers.payload_cog
    machine.set_payload(mass_kg, cog_m, window.six(4))


def _step_time(machine: Machine, window: Window) -> None:
    window.put_numbers([machine.options.cycle_s])


def _joint_history(machine: Machine, window: Window) -> None:
    steps = window.integer(1)
    if not 0 <= steps < len(machine.joint_history):
        raise ProgramError("get_actual_joint_positions_history: no such step")
    window.put_numbers(machine.joint_history[-1 - steps])


def _target_waypoint(machine: Machine, window: Window) -> None:
    window.put_numbers(machine.arm.target_pose())


def _set_tcp(machine: Machine, window: Window) -> None:
    offset = window.six(0)
    if not all(map(math.isfinite, offset)):
        raise ProgramError("set_tcp: the pose is not a number")
    machine.arm.set_tcp(offset)


def _inverse_near(machine: Machine, window: Window) -> None:
    window.put_numbers(solve(machine, window.six(0), window.six(6)))


def _inverse(machine: Machine, window: Window) -> None:
    window.put_numbers(solve(machine, window.six(0)))


def _has_inverse(machine: Machine, window: Window) -> None:
    window.put_integer(1, int(solvable(machine, window.six(0))))


def _protective_stop(machine: Machine, _window: Window) -> None:
    machine.trip_protective("asked for by the program")


def _set_watchdog(machine: Machine, window: Window) -> None:
    machine.watchdog.arm(window.number(0))


def _pose_is_safe(machine: Machine, window: Window) -> None:
    pose = window.six(0)
    window.put_integer(1, int(_in_box(machine, pose[:3]) and solvable(machine, pose)))


def _joints_are_safe(machine: Machine, window: Window) -> None:
    joints_rad = window.six(0)
    tcp = _forward(machine, joints_rad, machine.arm.tcp)
    safe = machine.arm.kinematics.within_limits(joints_rad)
    window.put_integer(1, int(safe and _in_box(machine, matrix_pose(tcp)[:3])))


def _joint_torques(machine: Machine, window: Window) -> None:
    window.put_numbers(machine.registers.target_moment)


def _transform(_machine: Machine, window: Window) -> None:
    product = pose_matrix(window.six(0)) @ pose_matrix(window.six(6))
    window.put_numbers(matrix_pose(product))


def _tcp_offset(machine: Machine, window: Window) -> None:
    window.put_numbers(machine.arm.tcp_offset)


def _forward_now(machine: Machine, window: Window) -> None:
    window.put_numbers(machine.arm.tcp_pose)


def _forward_given(machine: Machine, window: Window) -> None:
    tcp = pose_matrix(window.six(6))
    window.put_numbers(matrix_pose(_forward(machine, window.six(0), tcp)))


def _is_steady(machine: Machine, window: Window) -> None:
    window.put_integer(1, int(machine.arm.rest_s >= machine.options.steady_after_s))


def _no_contact(_machine: Machine, window: Window) -> None:
    window.put_integer(1, 0)


def _flange_pose(machine: Machine, window: Window) -> None:
    window.put_numbers(matrix_pose(machine.arm.flange))


def _nothing(_machine: Machine, _window: Window) -> None:
    """Accepted without effect: a setting of something that is not emulated."""


def _forward(machine: Machine, joints_rad: Six, tcp: Floats) -> Floats:
    pose: Floats = machine.arm.kinematics.flange(joints_rad) @ tcp
    return pose


def _in_box(machine: Machine, point_m: tuple[float, ...]) -> bool:
    box = machine.options.tcp_box_m
    return box is None or all(
        low <= value <= high for low, value, high in zip(box[0], point_m, box[1], strict=True)
    )


QUERIES: dict[int, Callable[[Machine, Window], None]] = {
    6: _nothing,
    7: _nothing,
    8: _nothing,
    17: _set_payload,
    18: _nothing,
    19: _nothing,
    20: _nothing,
    21: _nothing,
    25: _no_contact,
    26: _step_time,
    27: _joint_history,
    28: _target_waypoint,
    29: _set_tcp,
    30: _inverse_near,
    31: _protective_stop,
    35: _set_watchdog,
    36: _pose_is_safe,
    37: _joints_are_safe,
    38: _joint_torques,
    39: _transform,
    40: _tcp_offset,
    43: _forward_now,
    44: _forward_given,
    46: _inverse,
    47: _is_steady,
    52: _nothing,
    53: _nothing,
    54: _no_contact,
    56: _nothing,
    57: _nothing,
    58: _flange_pose,
    59: _nothing,
    60: _has_inverse,
    61: _has_inverse,
    62: _nothing,
    63: _no_contact,
    64: _no_contact,
    65: _set_target_payload,
}
"""What each command number does. Numbers that are not here move the arm, or do nothing."""
