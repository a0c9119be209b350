"""Planned movements, without a network: geometry of blends, limits, times."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.sim.ur.arm import Arm
from cellctl.sim.ur.kinematics import Kinematics, matrix_pose, pose_matrix
from cellctl.sim.ur.options import Six, UrOptions
from cellctl.sim.ur.profile import SpeedProfile, Stretch
from cellctl.sim.ur.trajectory import MotionError, Trajectory, Waypoint

STEP_S = 0.002
HOME: Six = (0.0, -1.5708, -1.5708, -1.5708, 1.5708, 0.0)
TURN = 2.0 * math.pi


def line(
    arm: Arm, dx_m: float, dy_m: float, dz_m: float, *, blend_m: float = 0.0, speed: float = 0.5
) -> Waypoint:
    x, y, z, rx, ry, rz = arm.tcp_pose
    return Waypoint("line", (x + dx_m, y + dy_m, z + dz_m, rx, ry, rz), speed, 2.0, blend_m)


def follow(arm: Arm, waypoints: list[Waypoint]) -> tuple[list[Six], list[float]]:
    """TCP poses and speeds of every step until the arm is at rest."""
    poses, speeds = [arm.tcp_pose], [0.0]
    trajectory = arm.planner.plan(arm.joints_rad, arm.tcp, waypoints)
    arm.start(trajectory)
    while arm.follows(trajectory):
        arm.advance(STEP_S)
        poses.append(arm.tcp_pose)
        speeds.append(arm.tcp_speed_m_s)
    return poses, speeds


def finish(arm: Arm, trajectory: Trajectory) -> None:
    arm.start(trajectory)
    while arm.follows(trajectory):
        arm.advance(STEP_S)


def nearest_m(poses: list[Six], point: Six) -> float:
    return min(math.dist(pose[:3], point[:3]) for pose in poses)


def test_a_right_angle_is_rounded_by_an_arc_at_unchanged_speed() -> None:
    arm = Arm(UrOptions())
    corner = line(arm, 0.0, 0.0, 0.2, blend_m=0.05)
    end = line(arm, 0.0, 0.2, 0.2)
    poses, speeds = follow(arm, [corner, end])
    # The arc has the blend radius itself for its own here: (sqrt(2) - 1) r from the corner.
    assert nearest_m(poses, corner.target) == pytest.approx((math.sqrt(2) - 1) * 0.05, abs=2e-4)
    assert nearest_m(poses, end.target) < 1e-9
    full = [speed for speed in speeds if speed > 0.499]
    first, last = speeds.index(full[0]), len(speeds) - speeds[::-1].index(full[-1])
    assert min(speeds[first:last]) > 0.499
    assert max(speeds) < 0.5 + 1e-6
    # Speed changes by no more than the acceleration, the speeds of a step being averages.
    assert max(abs(b - a) for a, b in pairwise(speeds)) < 2.0 * STEP_S * 1.01


def test_a_tight_corner_is_taken_as_slowly_as_its_arc_allows() -> None:
    options = UrOptions(blend_acceleration_m_s2=2.0)
    arm = Arm(options)
    waypoints = [line(arm, 0, 0, 0.2, blend_m=0.02), line(arm, 0, 0.2, 0.2)]
    poses, speeds = follow(arm, waypoints)
    in_arc = [
        speed
        for pose, speed in zip(poses, speeds, strict=True)
        if math.dist(pose[:3], waypoints[0].target[:3]) < 0.012
    ]
    assert max(in_arc) == pytest.approx(math.sqrt(2.0 * 0.02), rel=0.01)


def test_without_a_blend_the_arm_rests_in_the_corner() -> None:
    arm = Arm(UrOptions())
    corner = line(arm, 0, 0, 0.1)
    poses, speeds = follow(arm, [corner, line(arm, 0, 0.1, 0.1)])
    assert nearest_m(poses, corner.target) < 1e-6
    assert min(speeds[50:-50]) < 0.01


@pytest.mark.parametrize(("option", "misses"), [("skip", True), ("stop", False)])
def test_overlapping_blends_cost_the_waypoint_or_the_blend(option: str, misses: bool) -> None:
    arm = Arm(UrOptions(overlapping_blends=option))  # type: ignore[arg-type]
    corner = line(arm, 0, 0, 0.1, blend_m=0.09)
    poses, _ = follow(arm, [corner, line(arm, 0, 0.05, 0.1)])
    assert (nearest_m(poses, corner.target) > 0.01) is misses
    assert arm.planner.overlaps == 1


def test_a_turn_on_the_spot_and_a_turn_on_the_way_keep_their_speed_limit() -> None:
    arm = Arm(UrOptions())
    start = pose_matrix(arm.tcp_pose)
    turned = start @ pose_matrix((0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    spot = Waypoint("line", matrix_pose(turned), 0.5, 2.0)
    turned_and_moved = turned.copy()
    turned_and_moved[2, 3] += 0.1
    back = turned_and_moved @ pose_matrix((0.0, 0.0, 0.0, 0.0, 0.0, -1.0))
    trajectory = arm.planner.plan(
        arm.joints_rad, arm.tcp, [spot, Waypoint("line", matrix_pose(back), 0.5, 2.0)]
    )
    arm.start(trajectory)
    fastest_rad_s = 0.0
    while arm.follows(trajectory):
        arm.advance(STEP_S)
        fastest_rad_s = max(fastest_rad_s, math.hypot(*arm.tcp_twist[3:]))
    # 0.5 m/s at 0.5 m a radian.
    assert fastest_rad_s == pytest.approx(1.0, abs=0.01)
    assert math.dist(arm.tcp_pose[:3], back[:3, 3]) < 1e-9


def test_joint_paths_blend_where_the_tcp_comes_near_the_corner() -> None:
    arm = Arm(UrOptions())
    corner: Six = (0.5, -1.5708, -1.5708, -1.5708, 1.5708, 0.0)
    end: Six = (0.5, -1.2, -1.5708, -1.5708, 1.5708, 0.0)
    kinematics = Kinematics("ur10e", (TURN,) * 6)
    at_corner = matrix_pose(kinematics.flange(corner))
    poses, speeds = follow(
        arm, [Waypoint("joint", corner, 1.0, 3.0, 0.05), Waypoint("joint", end, 1.0, 3.0)]
    )
    assert 0.005 < nearest_m(poses, at_corner) < 0.05
    assert arm.joints_rad == end
    assert min(speeds[100:-100]) > 0.1


def test_a_target_beyond_a_joints_limit_is_refused_when_it_is_planned() -> None:
    arm = Arm(UrOptions())
    with pytest.raises(MotionError, match="position limit"):
        arm.planner.plan(HOME, arm.tcp, [Waypoint("joint", (7.0, *HOME[1:]), 1.0, 1.0)])
    with pytest.raises(MotionError, match="not a number"):
        arm.planner.plan(HOME, arm.tcp, [Waypoint("joint", (math.nan, *HOME[1:]), 1.0, 1.0)])


def limited(**limits: object) -> str:
    """What the arm says when a line at 0.5 m/s meets its limits."""
    arm = Arm(UrOptions(**limits))  # type: ignore[arg-type]
    trajectory = arm.planner.plan(arm.joints_rad, arm.tcp, [line(arm, 0.0, 0.4, 0.3)])
    with pytest.raises(MotionError) as caught:
        finish(arm, trajectory)
    return str(caught.value)


def test_limits_of_joints_and_tcp_stop_a_line() -> None:
    assert "exceeds its speed limit" in limited(joint_speed_limit_rad_s=(0.2,) * 6)
    assert "TCP exceeds" in limited(tcp_speed_limit_m_s=0.3)
    assert "leaves the space" in limited(tcp_box_m=((-2.0, -2.0, -2.0), (2.0, 0.0, 2.0)))
    assert "joint's limit" in limited(joint_position_limit_rad=(0.2, TURN, TURN, TURN, TURN, TURN))


def test_a_line_out_of_reach_is_noticed_where_it_leaves_it() -> None:
    arm = Arm(UrOptions())
    trajectory = arm.planner.plan(arm.joints_rad, arm.tcp, [line(arm, 1.5, 0.0, 0.0)])
    with pytest.raises(MotionError, match=r"reach|in the way|speed"):
        finish(arm, trajectory)
    assert math.dist(arm.tcp_pose[:3], (0.0, 0.0, 0.18)) < 1.5


stretches = st.lists(
    st.builds(
        Stretch,
        length=st.floats(0.0, 2.0),
        speed=st.floats(0.05, 2.0),
        acceleration=st.floats(0.1, 5.0),
        stops=st.booleans(),
    ),
    min_size=1,
    max_size=6,
)


_NO_LENGTH = 1e-8
"""Stretches that are together as short as this count as none."""


@settings(deadline=None)
@given(stretches)
def test_a_profile_keeps_every_limit(parts: list[Stretch]) -> None:
    profile = SpeedProfile(parts)
    total = sum(part.length for part in parts)
    assert profile.at(0.0) == 0.0
    assert profile.at(profile.duration_s) == pytest.approx(total, abs=_NO_LENGTH)
    steps = 400
    dt_s = max(profile.duration_s, 1e-6) / steps
    distances = [profile.at(i * dt_s) for i in range(steps + 1)]
    speeds = [(b - a) / dt_s for a, b in pairwise(distances)]
    fastest = max(part.speed for part in parts)
    hardest = max(part.acceleration for part in parts)
    assert min(speeds) >= -1e-9
    assert max(speeds) <= fastest * (1 + 1e-6) + 1e-9
    changes = [abs(b - a) / dt_s for a, b in pairwise(speeds)]
    if profile.duration_s > 1e-3:
        assert max(changes) <= hardest * (1 + 1e-3) + 1e-3


@settings(deadline=None)
@given(
    st.sampled_from(["ur10", "ur10e"]),
    st.tuples(*[st.floats(-6.2, 6.2)] * 6),
)
def test_inverse_kinematics_finds_joints_for_every_pose_that_the_arm_can_have(
    model: str, joints_rad: Six
) -> None:
    kinematics = Kinematics(model, (TURN,) * 6)  # type: ignore[arg-type]
    pose = kinematics.flange(joints_rad)
    found = kinematics.joints(pose, joints_rad)
    assert found is not None
    assert np.allclose(kinematics.flange(found), pose, atol=1e-5)
    assert kinematics.within_limits(found)
