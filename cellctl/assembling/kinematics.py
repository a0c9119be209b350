"""Forward and inverse kinematics of the UR10 and UR10e, with nominal link lengths.

A real arm is calibrated at the factory and differs from the nominal one by 1 to 2 mm at the tool;
its controller knows its own calibration and solves every Cartesian movement itself. What is
computed here decides reach, arm configuration and joint speed, for which that is near enough.

The closed-form solver (``ur_analytic_ik``) answers within (-pi, pi] only, and not at all where the
elbow is straight. So solutions are unwrapped to the turn nearest to where the arm is, and a damped
least-squares search takes over where the closed form is silent.
"""

from __future__ import annotations

import math
from types import ModuleType
from typing import Literal

import numpy as np
import ur_analytic_ik

from cellctl.assembling.poses import Floats, Matrix, inverse, to_pose
from cellctl.config import Joints

JOINT_LIMIT_RAD = 2.0 * math.pi
"""Every joint of a UR10 and UR10e turns this far each way."""
JOINT_SPEEDS_RAD_S: Joints = (
    *(math.radians(120.0),) * 2,
    *(math.radians(180.0),) * 4,
)
"""Greatest joint speeds, base to wrist 3: 120 deg/s for base and shoulder, else 180 deg/s."""

_SEARCH_STEPS = 60
_SEARCH_DAMPING = 1e-3
_POSITION_TOLERANCE_M = 1e-6
_ROTATION_TOLERANCE_RAD = 1e-6


class Kinematics:
    """Kinematics of one arm model, of its flange in its base frame.

    Args:
        model: which arm.
    """

    def __init__(self, model: Literal["ur10", "ur10e"]) -> None:
        solvers: dict[str, ModuleType] = {
            "ur10": ur_analytic_ik.ur10,
            "ur10e": ur_analytic_ik.ur10e,
        }
        self.model = model
        self._solver = solvers[model]

    def forward(self, joints_rad: Joints) -> Matrix:
        """4x4 pose of the flange in the base frame."""
        return np.asarray(self._solver.forward_kinematics(*joints_rad), dtype=np.float64)

    def inverse(self, flange: Matrix, near_rad: Joints) -> Joints | None:
        """The solution nearest to a joint position, within the joint limits.

        Near means the smallest largest joint difference. Every joint may be on any of its turns.

        Args:
            flange: 4x4 pose of the flange in the base frame.
            near_rad: where the arm is, or was at the pose before this one.

        Returns:
            None where the arm cannot reach.
        """
        target = np.ascontiguousarray(flange, dtype=np.float64)
        near = np.array(near_rad)
        if solutions := self._solver.inverse_kinematics(target):
            unwrapped = _nearest_turn(np.array(solutions), near)
            differences = np.max(np.abs(unwrapped - near), axis=1)
            return _joints(unwrapped[int(np.argmin(differences))])
        found = self._search(target, near)
        return None if found is None else _joints(found)

    def jacobian(self, joints_rad: Joints, step_rad: float = 1e-6) -> Floats:
        """6x6 geometric Jacobian of the flange in the base frame: rows are m/rad, then rad/rad."""
        here = self.forward(joints_rad)
        columns = []
        for joint in range(6):
            moved = list(joints_rad)
            moved[joint] += step_rad
            columns.append(_twist(here, self.forward(_joints(np.array(moved)))) / step_rad)
        return np.array(columns).T

    def _search(self, target: Matrix, start: Floats) -> Floats | None:
        """Damped least squares from ``start``; None unless it converges within the limits."""
        joints = start.copy()
        for _ in range(_SEARCH_STEPS):
            error = _twist(self.forward(_joints(joints)), target)
            position_m = float(np.linalg.norm(error[:3]))
            rotation_rad = float(np.linalg.norm(error[3:]))
            if position_m < _POSITION_TOLERANCE_M and rotation_rad < _ROTATION_TOLERANCE_RAD:
                return joints if np.all(np.abs(joints) <= JOINT_LIMIT_RAD) else None
            jacobian = self.jacobian(_joints(joints))
            # The damping fades with the error, so that the last steps are plain Newton steps.
            damping = _SEARCH_DAMPING * min(1.0, position_m + rotation_rad)
            normal = jacobian @ jacobian.T + damping * np.eye(6)
            joints = joints + jacobian.T @ np.linalg.solve(normal, error)
        return None


def same_configuration(a: Joints, b: Joints) -> bool:
    """Whether two joint positions have the same shoulder, elbow and wrist side.

    A straight elbow or wrist belongs to both of its sides. The shoulder's side is left out: along a
    straight path it can only change where the wrist crosses the base axis, and there the joints
    jump, which a check of neighbouring poses sees.
    """
    straight = 1e-3
    for joint in (2, 4):
        side_a, side_b = math.sin(a[joint]), math.sin(b[joint])
        if side_a * side_b < 0.0 and min(abs(side_a), abs(side_b)) > straight:
            return False
    return True


def _nearest_turn(joints: Floats, near: Floats) -> Floats:
    turn = 2.0 * math.pi
    unwrapped: Floats = joints + turn * np.round((near - joints) / turn)
    # Beyond a limit, the turn before it is the nearest one that the joint can take.
    unwrapped = np.where(unwrapped > JOINT_LIMIT_RAD, unwrapped - turn, unwrapped)
    return np.where(unwrapped < -JOINT_LIMIT_RAD, unwrapped + turn, unwrapped)


def _twist(start: Matrix, end: Matrix) -> Floats:
    """Translation and rotation vector, both in the base frame, that carry ``start`` to ``end``."""
    rotation = np.array(to_pose(inverse(start) @ end)[3:])
    return np.concatenate([end[:3, 3] - start[:3, 3], start[:3, :3] @ rotation])


def _joints(values: Floats) -> Joints:
    a, b, c, d, e, f = (float(value) for value in values)
    return (a, b, c, d, e, f)
