"""Forward and inverse kinematics of the UR10 and UR10e, with nominal link lengths.

A real arm is calibrated at the factory and differs from the nominal one by 1 to 2 mm at the tool;
its controller knows its own calibration and solves every Cartesian movement itself. What is
computed here decides reach, arm configuration and joint speed, for which that is near enough.

A UR arm reaches a pose in up to eight ways: the shoulder left or right of the wrist, the elbow up
or down, the wrist turned over or not. Such a choice is a ``Branch``; a job keeps to the branch of
its home position, so that no joint ever flips. ``Kinematics.follow`` solves a whole path for one
branch in closed form. For an arm that somebody left anywhere there is ``Kinematics.inverse``, with
all branches, all turns, and a damped least-squares search where the closed form is silent because
the elbow is straight.
"""

from __future__ import annotations

import math
from types import ModuleType
from typing import Literal, NamedTuple

import numpy as np
import ur_analytic_ik

from cellctl.arm_form import LINK_LENGTHS
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


class Branch(NamedTuple):
    """One of the eight ways to reach a pose; each is 1 or -1."""

    shoulder: int
    """1: the wrist is before the base's axis, on the side to which the arm looks."""
    elbow: int
    """Sign of the elbow's sine."""
    wrist: int
    """Sign of the sine of the fifth joint."""


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
        self.lengths = LINK_LENGTHS[model]
        self._solver = solvers[model]

    def forward(self, joints_rad: Joints) -> Matrix:
        """4x4 pose of the flange in the base frame."""
        return np.asarray(self._solver.forward_kinematics(*joints_rad), dtype=np.float64)

    def forward_many(self, joints_rad: Floats) -> tuple[Floats, Floats]:
        """Poses of the flange for n x 6 joints: n x 3 x 3 rotations and n x 3 positions."""
        d1, upper_arm, forearm, d4, d5, d6 = self.lengths
        # Turn, lift, bend, roll, and the last two joints: links one after another add up.
        angles = joints_rad.T.copy()
        angles[2] += angles[1]
        angles[3] += angles[2]
        c1, cos_lift, cos_bend, cr, c5, c6 = np.cos(angles)
        s1, sin_lift, sin_bend, sr, s5, s6 = np.sin(angles)
        # In the arm's own plane: x and y axis, z axis and place of the flange, each ahead of the
        # base's axis, up, and aside of the plane.
        ahead = (
            c5 * cr * c6 - sr * s6,
            -sr * c6 - c5 * cr * s6,
            -s5 * cr,
            d5 * sr - d6 * s5 * cr - (upper_arm * cos_lift + forearm * cos_bend),
        )
        up = (
            c5 * sr * c6 + cr * s6,
            cr * c6 - c5 * sr * s6,
            -s5 * sr,
            (d1 - upper_arm * sin_lift - forearm * sin_bend) - d5 * cr - d6 * s5 * sr,
        )
        aside = (s5 * c6, -s5 * s6, c5, d6 * c5 + d4)
        world = np.empty((len(joints_rad), 3, 4))
        for column, (along, above, across) in enumerate(zip(ahead, up, aside, strict=True)):
            world[:, 0, column] = along * c1 + across * s1
            world[:, 1, column] = along * s1 - across * c1
            world[:, 2, column] = above
        return world[:, :, :3], world[:, :, 3]

    def branch(self, joints_rad: Joints) -> Branch:
        """The branch of a joint position."""
        flange = self.forward(joints_rad)
        wrist = flange[:3, 3] - self.lengths.d6 * flange[:3, 2]
        ahead = wrist[0] * math.cos(joints_rad[0]) + wrist[1] * math.sin(joints_rad[0])
        return Branch(
            _sign(float(ahead)), _sign(math.sin(joints_rad[2])), _sign(math.sin(joints_rad[4]))
        )

    def follow(
        self, rotations: Floats, positions: Floats, branch: Branch, near_rad: Joints
    ) -> Floats:
        """Joint positions along a path of the flange, all of one branch.

        Args:
            rotations: n x 3 x 3, in the base frame.
            positions: n x 3, in metres.
            branch: which of the eight ways.
            near_rad: where the path begins: the first position is on the turns nearest to this,
                every other one nearest to the one before.

        Returns:
            n x 6 radians; a row of NaN where the arm does not reach. A joint may be beyond its
            limit: that is for the caller to see.
        """
        _, upper_arm, forearm, d4, d5, d6 = self.lengths
        axis = rotations[:, :, 2]
        wrist = positions - d6 * axis
        away = np.hypot(wrist[:, 0], wrist[:, 1])
        with np.errstate(invalid="ignore", divide="ignore"):
            lean = np.arcsin(d4 / away)
            # The wrist's centre keeps the distance d4 from the vertical plane of the arm.
            q1 = np.arctan2(wrist[:, 1], wrist[:, 0])
            q1 = q1 + (lean if branch.shoulder > 0 else np.pi - lean)
            c1, s1 = np.cos(q1), np.sin(q1)
            q5 = branch.wrist * np.arccos(np.clip(axis[:, 0] * s1 - axis[:, 1] * c1, -1.0, 1.0))
            s5 = np.sin(q5)
            # What is left of the tool's x and y axes along the arm's sideways direction turns
            # about the last axis.
            x_aside = rotations[:, 0, 0] * s1 - rotations[:, 1, 0] * c1
            y_aside = rotations[:, 0, 1] * s1 - rotations[:, 1, 1] * c1
            q6 = np.arctan2(-y_aside / s5, x_aside / s5)
            c6, s6 = np.cos(q6), np.sin(q6)
            fifth = -(rotations[:, :, 0] * s6[:, None] + rotations[:, :, 1] * c6[:, None])
            fifth_ahead = fifth[:, 0] * c1 + fifth[:, 1] * s1
            fifth_up = fifth[:, 2]
            q234 = np.arctan2(fifth_ahead, -fifth_up)
            ahead = wrist[:, 0] * c1 + wrist[:, 1] * s1 - d5 * fifth_ahead
            up = wrist[:, 2] - self.lengths.d1 - d5 * fifth_up
            cosine = (ahead**2 + up**2 - upper_arm**2 - forearm**2) / (2.0 * upper_arm * forearm)
            q3 = branch.elbow * np.arccos(cosine)
            # Both links point backwards at angle 0: their lengths are negative in the DH table.
            q2 = np.arctan2(-up, -ahead) - np.arctan2(
                forearm * np.sin(q3), upper_arm + forearm * np.cos(q3)
            )
        found = np.stack([q1, q2, q3, q234 - q2 - q3, q5, q6], axis=1)
        return _unwrapped(found, np.array(near_rad))

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
            return as_joints(unwrapped[int(np.argmin(differences))])
        found = self._search(target, near)
        return None if found is None else as_joints(found)

    def jacobian(self, joints_rad: Joints, step_rad: float = 1e-6) -> Floats:
        """6x6 geometric Jacobian of the flange in the base frame: rows are m/rad, then rad/rad."""
        here = self.forward(joints_rad)
        columns = []
        for joint in range(6):
            moved = list(joints_rad)
            moved[joint] += step_rad
            columns.append(_twist(here, self.forward(as_joints(np.array(moved)))) / step_rad)
        return np.array(columns).T

    def _search(self, target: Matrix, start: Floats) -> Floats | None:
        """Damped least squares from ``start``; None unless it converges within the limits."""
        joints = start.copy()
        for _ in range(_SEARCH_STEPS):
            error = _twist(self.forward(as_joints(joints)), target)
            position_m = float(np.linalg.norm(error[:3]))
            rotation_rad = float(np.linalg.norm(error[3:]))
            if position_m < _POSITION_TOLERANCE_M and rotation_rad < _ROTATION_TOLERANCE_RAD:
                return joints if np.all(np.abs(joints) <= JOINT_LIMIT_RAD) else None
            jacobian = self.jacobian(as_joints(joints))
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


def as_joints(values: Floats) -> Joints:
    """Six numbers as the plain tuple that values have."""
    a, b, c, d, e, f = (float(value) for value in values)
    return (a, b, c, d, e, f)


def _sign(value: float) -> int:
    return 1 if value >= 0.0 else -1


def _unwrapped(joints: Floats, near: Floats) -> Floats:
    """The same rows, each on the turns nearest to the one before; the first nearest to ``near``."""
    turn = 2.0 * math.pi
    steps = np.diff(joints, axis=0, prepend=near[None, :])
    steps -= turn * np.round(steps / turn)
    unwrapped: Floats = near + np.cumsum(steps, axis=0)
    return unwrapped


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
