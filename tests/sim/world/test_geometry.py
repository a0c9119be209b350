"""Poses and boxes against independent arithmetic."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from cellctl.sim.plant import Floats
from cellctl.sim.world_geometry import (
    Box,
    between,
    inverse,
    pose_matrix,
    rotation,
    rotation_vector,
)

number = st.floats(-1.0, 1.0)
vector = st.tuples(*[st.floats(-1.7, 1.7)] * 3)
pose = st.tuples(number, number, number, *[st.floats(-1.7, 1.7)] * 3)


@given(vector)
def test_rotations_agree_with_scipy_and_back(rotvec: tuple[float, float, float]) -> None:
    matrix = rotation(np.array(rotvec))
    assert np.allclose(matrix, Rotation.from_rotvec(rotvec).as_matrix(), atol=1e-9)
    assert np.allclose(rotation_vector(matrix), rotvec, atol=1e-6)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (-1, 2, 3)])
def test_half_turns_have_a_rotation_vector(axis: tuple[int, int, int]) -> None:
    vector_rad = np.array(axis) / np.linalg.norm(axis) * math.pi
    matrix = rotation(vector_rad)
    assert np.allclose(rotation(rotation_vector(matrix)), matrix, atol=1e-9)


@given(pose)
def test_the_inverse_undoes_a_pose(values: tuple[float, ...]) -> None:
    matrix = pose_matrix(values)
    assert np.allclose(inverse(matrix) @ matrix, np.eye(4), atol=1e-12)


@given(pose, pose)
def test_a_sweep_ends_where_it_should_and_no_step_is_longer_than_asked(
    first: tuple[float, ...], last: tuple[float, ...]
) -> None:
    arm_m, step_m = 0.2, 0.05
    start, end = pose_matrix(first), pose_matrix(last)
    way = [start, *between(start, end, step_m, arm_m)]
    assert np.allclose(way[-1], end)
    for point in itertools.product((-1.0, 1.0), repeat=3):
        corner = np.array([*(np.array(point) / math.sqrt(3) * arm_m), 1.0])
        places = [(matrix @ corner)[:3] for matrix in way]
        steps = [np.linalg.norm(b - a) for a, b in itertools.pairwise(places)]
        assert max(steps) <= step_m + 1e-9


def corners(box: Box) -> Floats:
    signs = np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    return np.asarray(signs * np.array(box.half_m) @ box.pose[:3, :3].T + box.pose[:3, 3])


@given(pose, pose)
def test_boxes_overlap_unless_a_plane_parts_them(
    first: tuple[float, ...], second: tuple[float, ...]
) -> None:
    one = Box(pose_matrix(first), (0.3, 0.2, 0.4))
    other = Box(pose_matrix(second), (0.5, 0.1, 0.3))
    axes = [*one.pose[:3, :3].T, *other.pose[:3, :3].T]
    axes += [np.cross(a, b) for a in one.pose[:3, :3].T for b in other.pose[:3, :3].T]
    gaps = []
    for axis in axes:
        length = float(np.linalg.norm(axis))
        if length > 1e-6:
            a, b = corners(one) @ axis / length, corners(other) @ axis / length
            gaps.append(max(float(a.min() - b.max()), float(b.min() - a.max())))
    widest_gap_m = max(gaps)
    if abs(widest_gap_m) > 1e-9:
        assert one.overlaps(other) is (widest_gap_m < 0.0)
        assert other.overlaps(one) is one.overlaps(other)


def test_touching_boxes_do_not_overlap() -> None:
    one = Box(np.eye(4), (0.5, 0.5, 0.5))
    other = Box(pose_matrix((1.0, 0.0, 0.0, 0.0, 0.0, 0.0)), (0.5, 0.5, 0.5))
    assert not one.overlaps(other)


@given(pose)
def test_bounds_hold_every_corner_tightly(values: tuple[float, ...]) -> None:
    box = Box(pose_matrix(values), (0.3, 0.2, 0.4))
    low, high = box.bounds()
    assert np.allclose(corners(box).min(axis=0), low)
    assert np.allclose(corners(box).max(axis=0), high)
