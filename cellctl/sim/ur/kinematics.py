"""Forward and inverse kinematics of UR10 and UR10e with their nominal Denavit-Hartenberg lengths.

Closed form: shoulder, wrist and elbow leave two choices each, which makes up to eight solutions. A
straight elbow (the home pose that a UR leaves the factory with) is solved too.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from operator import le, sub
from typing import Literal

import numpy as np

from cellctl.sim.plant import Floats
from cellctl.sim.ur.options import Six

# Universal Robots, "DH Parameters for calculations of kinematics and dynamics" (metres).
_A_M = {"ur10": (-0.612, -0.5723), "ur10e": (-0.6127, -0.57155)}
"""a2 and a3; the others are 0."""
_D_M = {
    "ur10": (0.1273, 0.163941, 0.1157, 0.0922),
    "ur10e": (0.1807, 0.17415, 0.11985, 0.11655),
}
"""d1, d4, d5 and d6; d2 and d3 are 0."""

_NEAR_RAD = 0.03
"""No joint moves further in one step; a solution this close is taken without a look at others."""
_REACH_TOLERANCE_M = 1e-6
_COSINE_TOLERANCE = 1e-5
"""A cosine of the elbow so far beyond 1 is a stretched arm: 3 micrometres of reach."""
_SINGULAR_SINE = 1e-7
"""With a wrist this straight only the sum of the first and last axes' turns matters."""

_Choice = tuple[int, int, int]
_CHOICES: tuple[_Choice, ...] = tuple(
    (shoulder, wrist, elbow) for shoulder in (0, 1) for wrist in (1, -1) for elbow in (1, -1)
)


class Kinematics:
    """Where the flange is for given joints, and which joints put it somewhere.

    Args:
        model: the robot.
        position_limit_rad: largest magnitude of each joint's position.
    """

    def __init__(self, model: Literal["ur10", "ur10e"], position_limit_rad: Six) -> None:
        self._a2, self._a3 = _A_M[model]
        self._d1, self._d4, self._d5, self._d6 = _D_M[model]
        self._limit_rad = position_limit_rad
        self._last_choice = _CHOICES[0]

    def flange(self, joints_rad: Sequence[float]) -> Floats:
        """4x4 pose of the flange in the base frame."""
        q1, q2, q3, q4, q5, q6 = joints_rad
        c1, s1, c5, s5 = math.cos(q1), math.sin(q1), math.cos(q5), math.sin(q5)
        c6, s6 = math.cos(q6), math.sin(q6)
        c234, s234 = math.cos(q2 + q3 + q4), math.sin(q2 + q3 + q4)
        # Axes 2, 3 and 4 are parallel to (s1, -c1, 0): the arm's plane is spanned by (c1, s1, 0)
        # and the vertical. Axis 5 lies in that plane, axis 6 is the flange's z.
        reach = self._a2 * math.cos(q2) + self._a3 * math.cos(q2 + q3) + self._d5 * s234
        height = self._a2 * math.sin(q2) + self._a3 * math.sin(q2 + q3) - self._d5 * c234
        zx = -s5 * c234 * c1 + c5 * s1
        zy = -s5 * c234 * s1 - c5 * c1
        zz = -s5 * s234
        # x5 and y5, the wrist before the last joint has turned it.
        ux, uy, uz = c5 * c234 * c1 + s5 * s1, c5 * c234 * s1 - s5 * c1, c5 * s234
        vx, vy, vz = -s234 * c1, -s234 * s1, c234
        d4, d6 = self._d4, self._d6
        return np.array(
            [
                [ux * c6 + vx * s6, vx * c6 - ux * s6, zx, reach * c1 + d4 * s1 + d6 * zx],
                [uy * c6 + vy * s6, vy * c6 - uy * s6, zy, reach * s1 - d4 * c1 + d6 * zy],
                [uz * c6 + vz * s6, vz * c6 - uz * s6, zz, self._d1 + height + d6 * zz],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )

    def joints(self, flange: Floats, near_rad: Six) -> Six | None:
        """The joint positions nearest to ``near_rad`` that put the flange at a pose.

        Returns:
            None when the pose is out of reach or only reachable beyond a joint's limit.
        """
        rows = flange.tolist()
        same = self._solve(rows, near_rad, self._last_choice)
        if same is not None and joint_distance(same, near_rad) < _NEAR_RAD:
            return same
        best: Six | None = None
        for choice, candidate in self._solutions(rows, near_rad):
            if best is None or joint_distance(candidate, near_rad) < joint_distance(best, near_rad):
                best = candidate
                self._last_choice = choice
        return best

    def within_limits(self, joints_rad: Six) -> bool:
        """Whether every joint is within its position limit."""
        return all(map(le, map(abs, joints_rad), self._limit_rad))

    def _solutions(self, rows: list[list[float]], near_rad: Six) -> Iterator[tuple[_Choice, Six]]:
        for choice in _CHOICES:
            solution = self._solve(rows, near_rad, choice)
            if solution is not None:
                yield choice, solution

    def _solve(self, rows: list[list[float]], near_rad: Six, choice: _Choice) -> Six | None:
        """One of the eight solutions, each joint turned to be nearest to ``near_rad``."""
        (xx, yx, zx, px), (xy, yy, zy, py), (xz, yz, zz, pz) = rows[:3]
        shoulder, wrist, elbow = choice
        # The wrist's centre keeps the distance d4 from the plane through axis 1.
        wx, wy, wz = px - self._d6 * zx, py - self._d6 * zy, pz - self._d6 * zz
        away = math.hypot(wx, wy)
        if not away >= self._d4 - _REACH_TOLERANCE_M:
            return None
        lean = math.asin(min(1.0, self._d4 / away))
        q1 = math.atan2(wy, wx) + (math.pi - lean if shoulder else lean)
        c1, s1 = math.cos(q1), math.sin(q1)
        q5 = wrist * math.acos(max(-1.0, min(1.0, zx * s1 - zy * c1)))
        s5 = math.sin(q5)
        q6 = near_rad[5]
        if abs(s5) > _SINGULAR_SINE:
            q6 = math.atan2((yy * c1 - yx * s1) / s5, (xx * s1 - xy * c1) / s5)
        c6, s6 = math.cos(q6), math.sin(q6)
        # Direction of axis 5, in and out of the base's horizontal.
        along = -((xx * s6 + yx * c6) * c1 + (xy * s6 + yy * c6) * s1)
        up = -(xz * s6 + yz * c6)
        q234 = math.atan2(along, -up)
        reach = wx * c1 + wy * s1 - self._d5 * along
        height = wz - self._d5 * up - self._d1
        a2, a3 = self._a2, self._a3
        cosine = (reach * reach + height * height - a2 * a2 - a3 * a3) / (2.0 * a2 * a3)
        if not abs(cosine) <= 1.0 + _COSINE_TOLERANCE:
            return None
        q3 = elbow * math.acos(max(-1.0, min(1.0, cosine)))
        q2 = math.atan2(height, reach) - math.atan2(a3 * math.sin(q3), a2 + a3 * math.cos(q3))
        return _unwrap((q1, q2, q3, q234 - q2 - q3, q5, q6), near_rad, self._limit_rad)


def joint_distance(one: Six, other: Six) -> float:
    """Largest difference of any joint, in radians."""
    return float(max(map(abs, map(sub, one, other))))


def _unwrap(joints: Six, near_rad: Six, limit_rad: Six) -> Six | None:
    """Add whole turns so that each joint is nearest to ``near_rad`` within its limit."""
    unwrapped = []
    for value, near, limit in zip(joints, near_rad, limit_rad, strict=True):
        nearest = value + math.tau * round((near - value) / math.tau)
        if abs(nearest) > limit:
            nearest -= math.copysign(math.tau, nearest)
            if abs(nearest) > limit:
                return None
        unwrapped.append(nearest)
    q1, q2, q3, q4, q5, q6 = unwrapped
    return (q1, q2, q3, q4, q5, q6)


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
