"""Pose algebra: between ``[x, y, z, rx, ry, rz]`` with a rotation vector, as a UR controller and
the configuration write it, and 4x4 homogeneous matrices.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from cellctl.config import Pose

Matrix = npt.NDArray[np.float64]
"""4x4 homogeneous transform; ``a_from_b @ b_from_c == a_from_c``."""
Floats = npt.NDArray[np.float64]


def to_matrix(pose: Pose) -> Matrix:
    """4x4 matrix of a pose, by Rodrigues' formula."""
    px, py, pz, rx, ry, rz = pose
    angle = math.sqrt(rx * rx + ry * ry + rz * rz)
    # Written out, because every corner of every path that is tried comes by here.
    if angle > 0.0:
        x, y, z = rx / angle, ry / angle, rz / angle
    else:
        x, y, z = 0.0, 0.0, 0.0
    sine, versine = math.sin(angle), 1.0 - math.cos(angle)
    vx, vy, vz = versine * x, versine * y, versine * z
    sx, sy, sz = sine * x, sine * y, sine * z
    return np.array(
        [
            [1.0 - vy * y - vz * z, vx * y - sz, vx * z + sy, px],
            [vx * y + sz, 1.0 - vx * x - vz * z, vy * z - sx, py],
            [vx * z - sy, vy * z + sx, 1.0 - vx * x - vy * y, pz],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def to_pose(matrix: Matrix) -> Pose:
    """Pose of a 4x4 matrix; the rotation vector's length is at most pi.

    Goes through the quaternion with its largest component as pivot, which stays exact at half a
    turn, where a tool that points straight down always is.
    """
    r = matrix[:3, :3]
    # Four times the products of the quaternion (w, x, y, z) with its largest component.
    trace = float(r[0, 0] + r[1, 1] + r[2, 2])
    candidates = (trace, float(r[0, 0]), float(r[1, 1]), float(r[2, 2]))
    pivot = candidates.index(max(candidates))
    if pivot == 0:
        q = (1.0 + trace, r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1])
    elif pivot == 1:
        q = (r[2, 1] - r[1, 2], 1.0 + 2.0 * r[0, 0] - trace, r[0, 1] + r[1, 0], r[0, 2] + r[2, 0])
    elif pivot == 2:
        q = (r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], 1.0 + 2.0 * r[1, 1] - trace, r[1, 2] + r[2, 1])
    else:
        q = (r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1.0 + 2.0 * r[2, 2] - trace)
    w, x, y, z = (float(value) for value in q)
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2.0 * math.atan2(sine, w) / sine if sine > 0.0 else 0.0
    position = [float(value) for value in matrix[:3, 3]]
    return (position[0], position[1], position[2], x * scale, y * scale, z * scale)


def inverse(matrix: Matrix) -> Matrix:
    """Inverse of a rigid transform."""
    result = np.eye(4)
    result[:3, :3] = matrix[:3, :3].T
    result[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return result


def distance(a: Pose, b: Pose) -> tuple[float, float]:
    """How far apart two poses are: metres between the origins, radians between the axes."""
    between = to_pose(inverse(to_matrix(a)) @ to_matrix(b))
    return math.dist(a[:3], b[:3]), math.hypot(*between[3:])


def interpolate(a: Matrix, b: Matrix, fraction: float) -> Matrix:
    """Pose on the straight way from ``a`` (0) to ``b`` (1), turning about one axis at an even rate,
    which is how a controller's ``movel`` goes."""
    result = a.copy()
    result[:3, 3] = (1.0 - fraction) * a[:3, 3] + fraction * b[:3, 3]
    if not np.array_equal(a[:3, :3], b[:3, :3]):
        *_, rx, ry, rz = to_pose(inverse(a) @ b)
        turn = to_matrix((0.0, 0.0, 0.0, rx * fraction, ry * fraction, rz * fraction))
        result[:3, :3] = a[:3, :3] @ turn[:3, :3]
    return result
