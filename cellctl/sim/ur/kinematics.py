"""Forward and inverse kinematics of UR10 and UR10e with their nominal Denavit-Hartenberg lengths.

The closed-form solver of ``ur_analytic_ik`` does the work. It finds nothing where the elbow is
straight (the arm's home pose is one such place), so a damped least-squares search stands behind it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from operator import le, sub
from typing import Literal

import numpy as np
import ur_analytic_ik

from cellctl.sim.plant import Floats
from cellctl.sim.ur.options import Six

# Universal Robots, "DH Parameters for calculations of kinematics and dynamics" (metres).
_A_M: dict[str, Six] = {
    "ur10": (0.0, -0.612, -0.5723, 0.0, 0.0, 0.0),
    "ur10e": (0.0, -0.6127, -0.57155, 0.0, 0.0, 0.0),
}
_D_M: dict[str, Six] = {
    "ur10": (0.1273, 0.0, 0.0, 0.163941, 0.1157, 0.0922),
    "ur10e": (0.1807, 0.0, 0.0, 0.17415, 0.11985, 0.11655),
}
_ALPHA_RAD = (math.pi / 2, 0.0, 0.0, math.pi / 2, -math.pi / 2, 0.0)

NEAR_RAD = 0.2
"""A solution this close to the previous joints is of the same branch, and none nearer exists."""
_SEARCH_STEPS = 60
_SEARCH_DAMPING = 1e-4
_POSITION_TOLERANCE_M = 1e-6
_ROTATION_TOLERANCE_RAD = 1e-6


class Kinematics:
    """Where the flange is for given joints, and which joints put it somewhere.

    Args:
        model: the robot.
        position_limit_rad: largest magnitude of each joint's position.
    """

    def __init__(self, model: Literal["ur10", "ur10e"], position_limit_rad: Six) -> None:
        self._solver = getattr(ur_analytic_ik, model)
        self._a_m = _A_M[model]
        self._d_m = _D_M[model]
        self._limit_rad = position_limit_rad

    def flange(self, joints_rad: Sequence[float]) -> Floats:
        """4x4 pose of the flange in the base frame."""
        pose: Floats = self._solver.forward_kinematics(*joints_rad)
        return pose

    def joints(self, flange: Floats, near_rad: Six) -> Six | None:
        """The joint positions nearest to ``near_rad`` that put the flange at a pose.

        Returns:
            None when the pose is out of reach or only reachable beyond a joint's limit.
        """
        for solution in self._solver.inverse_kinematics_closest(flange, *near_rad):
            q0, q1, q2, q3, q4, q5 = solution.tolist()
            same = (q0, q1, q2, q3, q4, q5)
            if joint_distance(same, near_rad) < NEAR_RAD and self.within_limits(same):
                return same
        best: Six | None = None
        for solution in self._solver.inverse_kinematics(flange):
            candidate = _unwrap(solution.tolist(), near_rad, self._limit_rad)
            if candidate is not None and (
                best is None or joint_distance(candidate, near_rad) < joint_distance(best, near_rad)
            ):
                best = candidate
        return best if best is not None else self._search(flange, near_rad)

    def within_limits(self, joints_rad: Six) -> bool:
        """Whether every joint is within its position limit."""
        return all(map(le, map(abs, joints_rad), self._limit_rad))

    def _search(self, target: Floats, start_rad: Six) -> Six | None:
        """Damped least squares: slow, for the poses that have no closed-form solution."""
        q = np.array(start_rad)
        for _ in range(_SEARCH_STEPS):
            frames = self._frames(q)
            reached = frames[-1]
            offset = target[:3, 3] - reached[:3, 3]
            turn = np.array(rotation_vector(target[:3, :3] @ reached[:3, :3].T))
            if (
                np.linalg.norm(offset) < _POSITION_TOLERANCE_M
                and np.linalg.norm(turn) < _ROTATION_TOLERANCE_RAD
            ):
                return _unwrap(q.tolist(), start_rad, self._limit_rad)
            jacobian = np.empty((6, 6))
            for i, frame in enumerate(frames[:-1]):
                axis = frame[:3, 2]
                jacobian[:3, i] = np.cross(axis, reached[:3, 3] - frame[:3, 3])
                jacobian[3:, i] = axis
            error = np.concatenate((offset, turn))
            damping = _SEARCH_DAMPING * max(1e-3, float(error @ error))
            square = jacobian @ jacobian.T + damping * np.eye(6)
            step = jacobian.T @ np.linalg.solve(square, error)
            q = q + step * min(1.0, 0.5 / max(float(np.abs(step).max()), 1e-12))
        return None

    def _frames(self, q: Floats) -> list[Floats]:
        """Base frame and the frame after each joint."""
        frames: list[Floats] = [np.eye(4)]
        for theta, a, d, alpha in zip(q, self._a_m, self._d_m, _ALPHA_RAD, strict=True):
            ct, st, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
            link = np.array(
                [
                    [ct, -st * ca, st * sa, a * ct],
                    [st, ct * ca, -ct * sa, a * st],
                    [0.0, sa, ca, d],
                    [0.0, 0.0, 0.0, 1.0],
                ]
            )
            frames.append(frames[-1] @ link)
        return frames


def joint_distance(one: Six, other: Six) -> float:
    """Largest difference of any joint, in radians."""
    return float(max(map(abs, map(sub, one, other))))


def _unwrap(joints: Sequence[float], near_rad: Six, limit_rad: Six) -> Six | None:
    """Add whole turns so that each joint is nearest to ``near_rad`` within its limit."""
    turn = 2.0 * math.pi
    unwrapped = []
    for value, near, limit in zip(joints, near_rad, limit_rad, strict=True):
        nearest = value + turn * round((near - value) / turn)
        for candidate in (nearest, nearest - turn, nearest + turn):
            if abs(candidate) <= limit:
                unwrapped.append(candidate)
                break
        else:
            return None
    return (*unwrapped,)  # type: ignore[return-value]


def rotation_matrix(vector: Sequence[float]) -> Floats:
    """3x3 matrix of a rotation vector (axis times angle, radians)."""
    x, y, z = vector
    angle = math.sqrt(x * x + y * y + z * z)
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = x / angle, y / angle, z / angle
    c, s = math.cos(angle), math.sin(angle)
    k = 1.0 - c
    return np.array(
        [
            [c + x * x * k, x * y * k - z * s, x * z * k + y * s],
            [y * x * k + z * s, c + y * y * k, y * z * k - x * s],
            [z * x * k - y * s, z * y * k + x * s, c + z * z * k],
        ]
    )


def rotation_vector(matrix: Floats) -> tuple[float, float, float]:
    """Rotation vector of a 3x3 matrix; its length is at most pi."""
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    x, y, z = h - f, c - g, d - b
    sine2 = math.sqrt(x * x + y * y + z * z)
    cosine2 = a + e + i - 1.0
    angle = math.atan2(sine2, cosine2)
    if angle < 1e-9:
        return (x / 2.0, y / 2.0, z / 2.0)
    if sine2 > 1e-6:
        scale = angle / sine2
        return (x * scale, y * scale, z * scale)
    # Half a turn about n: the matrix is 2 n n^T - I, so a column of R + I is along n.
    symmetric = (matrix + matrix.T) / 2.0 + np.eye(3)
    largest = int(np.argmax(np.diagonal(symmetric)))
    axis = symmetric[:, largest]
    axis = axis * (angle / float(np.linalg.norm(axis)))
    return (float(axis[0]), float(axis[1]), float(axis[2]))


def pose_matrix(pose: Sequence[float]) -> Floats:
    """4x4 matrix of a pose ``[x, y, z, rx, ry, rz]``."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_matrix(pose[3:6])
    matrix[:3, 3] = pose[:3]
    return matrix


def matrix_pose(matrix: Floats) -> Six:
    """Pose ``(x, y, z, rx, ry, rz)`` of a 4x4 matrix."""
    rx, ry, rz = rotation_vector(matrix[:3, :3])
    return (float(matrix[0, 3]), float(matrix[1, 3]), float(matrix[2, 3]), rx, ry, rz)


def inverse_matrix(matrix: Floats) -> Floats:
    """Inverse of a rigid 4x4 transform."""
    inverse = np.eye(4)
    inverse[:3, :3] = matrix[:3, :3].T
    inverse[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return inverse
