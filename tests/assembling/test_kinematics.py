"""Poses and kinematics: round trips, turns, singular places, reach."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.assembling.kinematics import JOINT_LIMIT_RAD, Kinematics, same_configuration
from cellctl.assembling.poses import distance, interpolate, inverse, to_matrix, to_pose
from cellctl.config import Joints, Pose

MODELS = [Kinematics("ur10e"), Kinematics("ur10")]
# Denavit-Hartenberg parameters as Universal Robots publishes them: a and d in metres.
PUBLISHED = {
    "ur10e": ((0, -0.6127, -0.57155, 0, 0, 0), (0.1807, 0, 0, 0.17415, 0.11985, 0.11655)),
    "ur10": ((0, -0.612, -0.5723, 0, 0, 0), (0.1273, 0, 0, 0.163941, 0.1157, 0.0922)),
}
ALPHA = (math.pi / 2, 0, 0, math.pi / 2, -math.pi / 2, 0)

angle = st.floats(-math.pi, math.pi)
full_turn = st.floats(-JOINT_LIMIT_RAD, JOINT_LIMIT_RAD)
joints = st.tuples(*[full_turn] * 6)
length = st.floats(-2.0, 2.0)
pose = st.tuples(length, length, length, angle, angle, angle).filter(
    lambda p: math.hypot(*p[3:]) < math.pi - 1e-6
)


def published_flange(model: str, joints_rad: Joints) -> np.ndarray:
    """Product of the link transforms, written out from the published parameters."""
    flange = np.eye(4)
    for q, a, d, alpha in zip(joints_rad, *PUBLISHED[model], ALPHA, strict=True):
        cq, sq, ca, sa = math.cos(q), math.sin(q), math.cos(alpha), math.sin(alpha)
        flange = flange @ np.array(
            [
                [cq, -sq * ca, sq * sa, a * cq],
                [sq, cq * ca, -cq * sa, a * sq],
                [0, sa, ca, d],
                [0, 0, 0, 1],
            ]
        )
    return flange


@settings(deadline=None)  # a shared machine has no deadlines
@given(pose)
def test_pose_survives_the_way_through_a_matrix(value: Pose) -> None:
    assert to_pose(to_matrix(value)) == pytest.approx(value, abs=1e-7)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, -1), (0.6, 0.8, 0)])
def test_half_a_turn_keeps_its_axis(axis: tuple[float, float, float]) -> None:
    half_turn = to_matrix((0.0, 0.0, 0.0, *(math.pi * value for value in axis)))  # type: ignore[arg-type]
    back = to_matrix(to_pose(half_turn))
    assert back == pytest.approx(half_turn, abs=1e-12)


@settings(deadline=None)
@given(pose, pose)
def test_interpolation_meets_both_ends_and_turns_evenly(a: Pose, b: Pose) -> None:
    start, end = to_matrix(a), to_matrix(b)
    assert interpolate(start, end, 1.0) == pytest.approx(end, abs=1e-6)
    middle = to_pose(interpolate(start, end, 0.5))
    first, second = distance(a, middle), distance(middle, b)
    assert first == pytest.approx(second, abs=1e-5)
    assert inverse(start) @ start == pytest.approx(np.eye(4), abs=1e-12)


@pytest.mark.parametrize("kinematics", MODELS, ids=lambda k: k.model)
@settings(deadline=None)
@given(values=joints)
def test_forward_agrees_with_the_published_parameters(
    kinematics: Kinematics, values: Joints
) -> None:
    expected = published_flange(kinematics.model, values)
    assert kinematics.forward(values) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("kinematics", MODELS, ids=lambda k: k.model)
@settings(max_examples=300, deadline=None)
@given(values=joints)
def test_inverse_near_a_position_is_that_position(kinematics: Kinematics, values: Joints) -> None:
    flange = kinematics.forward(values)
    found = kinematics.inverse(flange, values)
    assert found is not None
    assert kinematics.forward(found) == pytest.approx(flange, abs=1e-5)
    away_from_singular = min(abs(math.sin(values[2])), abs(math.sin(values[4]))) > 0.05
    if away_from_singular and max(map(abs, values)) < JOINT_LIMIT_RAD - 0.01:
        wrist = flange @ np.array([0, 0, -PUBLISHED[kinematics.model][1][5], 1])
        if math.hypot(wrist[0], wrist[1]) > PUBLISHED[kinematics.model][1][3] + 0.01:
            assert found == pytest.approx(values, abs=1e-4)


@pytest.mark.parametrize("kinematics", MODELS, ids=lambda k: k.model)
def test_inverse_stays_on_the_turn_where_the_joint_is(kinematics: Kinematics) -> None:
    near: Joints = (2.7, -1.5, -1.8, -1.4, 1.6, 5.0)
    found = kinematics.inverse(kinematics.forward(near), near)
    assert found == pytest.approx(near, abs=1e-9)


@pytest.mark.parametrize("kinematics", MODELS, ids=lambda k: k.model)
def test_straight_elbow_where_the_closed_form_is_silent(kinematics: Kinematics) -> None:
    straight: Joints = (0.0, -math.pi / 2, 0.0, -math.pi / 2, 0.0, 0.0)
    flange = kinematics.forward(straight)
    found = kinematics.inverse(flange, (0.01, -1.58, 0.02, -1.56, 0.01, 0.0))
    assert found is not None
    assert kinematics.forward(found) == pytest.approx(flange, abs=1e-5)


@pytest.mark.parametrize("kinematics", MODELS, ids=lambda k: k.model)
def test_out_of_reach_has_no_solution(kinematics: Kinematics) -> None:
    far = to_matrix((1.6, 0.0, 0.3, math.pi, 0.0, 0.0))
    assert kinematics.inverse(far, (0.0, -1.5, -1.5, -1.5, 1.5, 0.0)) is None


def test_elbow_and_wrist_sides_are_told_apart() -> None:
    up: Joints = (0.0, -1.5, -1.5, -1.5, 1.5, 0.0)
    assert same_configuration(up, (1.0, -1.0, -0.5, 0.0, 0.5, 3.0))
    assert not same_configuration(up, (0.0, -1.5, 1.5, -1.5, 1.5, 0.0))
    assert not same_configuration(up, (0.0, -1.5, -1.5, -1.5, -1.5, 0.0))
    assert same_configuration(up, (0.0, -1.5, 0.0, -1.5, 1.5, 0.0))
