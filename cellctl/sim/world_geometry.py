"""Poses and boxes: the geometry with which the world judges."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from cellctl.sim.plant import Floats

Triple = tuple[float, float, float]


def rotation(vector_rad: Floats) -> Floats:
    """3x3 rotation about ``vector_rad`` by its length (Rodrigues' formula)."""
    angle_rad = float(np.linalg.norm(vector_rad))
    if angle_rad < 1e-12:
        return np.eye(3)
    x, y, z = vector_rad / angle_rad
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(
        np.eye(3) + math.sin(angle_rad) * cross + (1.0 - math.cos(angle_rad)) * (cross @ cross)
    )


def rotation_vector(matrix: Floats) -> Floats:
    """The rotation vector of a 3x3 rotation; its length is at most pi."""
    cosine = max(-1.0, min(1.0, (float(np.trace(matrix)) - 1.0) / 2.0))
    angle_rad = math.acos(cosine)
    axis = np.array(
        [
            matrix[2, 1] - matrix[1, 2],
            matrix[0, 2] - matrix[2, 0],
            matrix[1, 0] - matrix[0, 1],
        ]
    )
    length = float(np.linalg.norm(axis))
    if length > 1e-9:
        return np.asarray(axis / length * angle_rad)
    if cosine > 0.0:
        return np.zeros(3)
    # Half a turn: the axis is the column of (R + I) with the largest diagonal element.
    symmetric = matrix + np.eye(3)
    column = symmetric[:, int(np.argmax(np.diag(symmetric)))]
    return np.asarray(column / np.linalg.norm(column) * math.pi)


def farthest_corner_m(shift_m: Floats, turn_rad: Floats, half_m: float) -> float:
    """How far the corner of a cube moves that moves farthest.

    Args:
        shift_m: of its centre (3,).
        turn_rad: rotation vector (3,).
        half_m: half of the cube's edge.
    """
    corners = np.array(list(product((-half_m, half_m), repeat=3)))
    moved = corners @ rotation(turn_rad).T + shift_m - corners
    return float(np.linalg.norm(moved, axis=1).max())


def pose_matrix(pose: tuple[float, ...]) -> Floats:
    """4x4 matrix of ``x, y, z`` in metres and a rotation vector in radians."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation(np.array(pose[3:6]))
    matrix[:3, 3] = pose[:3]
    return matrix


def inverse(matrix: Floats) -> Floats:
    """Inverse of a 4x4 rigid transform."""
    result = np.eye(4)
    result[:3, :3] = matrix[:3, :3].T
    result[:3, 3] = -matrix[:3, :3].T @ matrix[:3, 3]
    return result


def between(start: Floats, end: Floats, step_m: float, arm_m: float) -> Iterator[Floats]:
    """Poses from ``start`` (left out) to ``end`` along a straight line with an even rotation.

    Args:
        step_m: no point within ``arm_m`` of the pose's origin moves further from pose to pose.
    """
    turn = rotation_vector(start[:3, :3].T @ end[:3, :3])
    shift = end[:3, 3] - start[:3, 3]
    way_m = float(np.linalg.norm(shift)) + float(np.linalg.norm(turn)) * arm_m
    steps = max(1, math.ceil(way_m / step_m))
    for index in range(1, steps):
        share = index / steps
        pose = np.eye(4)
        pose[:3, :3] = start[:3, :3] @ rotation(turn * share)
        pose[:3, 3] = start[:3, 3] + shift * share
        yield pose
    yield end


@dataclass(frozen=True)
class Box:
    """A box anywhere: its pose at its centre, and half of each edge."""

    pose: Floats
    half_m: Triple

    def bounds(self) -> tuple[Triple, Triple]:
        """Smallest and largest corner of the axis-parallel box around it."""
        (xx, xy, xz, x), (yx, yy, yz, y), (zx, zy, zz, z), _ = self.pose.tolist()
        a, b, c = self.half_m
        ex = abs(xx) * a + abs(xy) * b + abs(xz) * c
        ey = abs(yx) * a + abs(yy) * b + abs(yz) * c
        ez = abs(zx) * a + abs(zy) * b + abs(zz) * c
        return (x - ex, y - ey, z - ez), (x + ex, y + ey, z + ez)

    def overlaps(self, other: Box) -> bool:
        """Whether the two share more than their surface (separating-axis test, 15 axes)."""
        relative = self.pose[:3, :3].T @ other.pose[:3, :3]
        offset = self.pose[:3, :3].T @ (other.pose[:3, 3] - self.pose[:3, 3])
        magnitude = np.abs(relative)
        half, other_half = np.array(self.half_m), np.array(other.half_m)
        if np.any(np.abs(offset) >= half + magnitude @ other_half):
            return False
        if np.any(np.abs(offset @ relative) >= half @ magnitude + other_half):
            return False
        for i in range(3):
            i1, i2 = (i + 1) % 3, (i + 2) % 3
            for j in range(3):
                j1, j2 = (j + 1) % 3, (j + 2) % 3
                reach_m = (
                    half[i1] * magnitude[i2, j]
                    + half[i2] * magnitude[i1, j]
                    + other_half[j1] * magnitude[i, j2]
                    + other_half[j2] * magnitude[i, j1]
                )
                distance_m = abs(offset[i2] * relative[i1, j] - offset[i1] * relative[i2, j])
                # Parallel edges make an axis of length zero, which separates nothing.
                if distance_m > reach_m + 1e-12:
                    return False
        return True


def apart(low: Triple, high: Triple, other_low: Triple, other_high: Triple) -> bool:
    """Whether two axis-parallel boxes have no volume in common."""
    return (
        low[0] >= other_high[0]
        or other_low[0] >= high[0]
        or low[1] >= other_high[1]
        or other_low[1] >= high[1]
        or low[2] >= other_high[2]
        or other_low[2] >= high[2]
    )
