"""Moves with the real control client: where the arm goes, how long it takes, what is reported."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator

import pytest
from rtde_control import Path, PathEntry

from tests.sim.ur.harness import Clients, Emulator, distance_m, wait_until

SPEED_M_S = 0.25
ACCELERATION_M_S2 = 1.2


@pytest.fixture(scope="module")
def emulator() -> Iterator[Emulator]:
    with Emulator() as running:
        yield running


@pytest.fixture(scope="module")
def robot(emulator: Emulator) -> Iterator[Clients]:
    with Clients(emulator.host) as clients:
        yield clients


@pytest.fixture(autouse=True)
def at_home(robot: Clients) -> None:
    home = [0.0, -1.5708, -1.5708, -1.5708, 1.5708, 0.0]
    if not robot.control.isProgramRunning():
        robot.control.reuploadScript()
        wait_until(robot.control.isProgramRunning)
    assert robot.control.moveJ(home, 2.0, 20.0)


def square(robot: Clients, blend_m: float) -> list[list[float]]:
    corners = [robot.lifted(0.0, dx, dy) for dx, dy in ((0.1, 0), (0.1, 0.1), (0, 0.1), (0, 0))]
    return [[*corner, SPEED_M_S, ACCELERATION_M_S2, blend_m] for corner in corners]


def test_a_line_ends_at_its_target_after_the_time_of_its_trapezoid(robot: Clients) -> None:
    target = robot.lifted(0.2)
    started_s = robot.receive.getTimestamp()
    assert robot.control.moveL(target, SPEED_M_S, ACCELERATION_M_S2)
    took_s = robot.receive.getTimestamp() - started_s
    assert distance_m(target, robot.receive.getActualTCPPose()) < 1e-6
    assert took_s == pytest.approx(0.2 / 0.25 + 0.25 / 1.2, abs=0.1)


def test_joints_move_together_and_reach_their_target(robot: Clients) -> None:
    target = [0.4, -1.3, -1.8, -1.2, 1.2, 0.6]
    assert robot.control.moveJ(target, 1.5, 4.0)
    wait_until(lambda: robot.receive.getActualQ() == pytest.approx(target, abs=1e-9))


def test_a_pose_is_reached_by_a_joint_move_and_joints_by_a_line(robot: Clients) -> None:
    target = robot.lifted(0.1, 0.05)
    assert robot.control.moveJ_IK(target, 1.5, 4.0)
    wait_until(lambda: distance_m(target, robot.receive.getActualTCPPose()) < 1e-6)
    joints = [0.1, -1.5, -1.6, -1.5, 1.5, 0.1]
    assert robot.control.moveL_FK(joints, 0.5, 2.0)
    wait_until(lambda: robot.receive.getActualQ() == pytest.approx(joints, abs=1e-6))


def test_an_asynchronous_line_reports_running_and_then_finished(robot: Clients) -> None:
    before = robot.control.getAsyncOperationProgressEx().operationId()
    assert robot.control.moveL(robot.lifted(0.1), SPEED_M_S, ACCELERATION_M_S2, True)
    wait_until(lambda: robot.control.getAsyncOperationProgressEx().operationId() != before)
    assert robot.control.getAsyncOperationProgressEx().isAsyncOperationRunning()
    robot.wait_moving()
    wait_until(lambda: not robot.control.getAsyncOperationProgressEx().isAsyncOperationRunning())
    assert robot.control.getAsyncOperationProgress() < 0


def test_a_blended_path_counts_its_waypoints_and_keeps_its_speed(robot: Clients) -> None:
    path = square(robot, 0.02)
    assert robot.control.moveL(path, True)
    progress: list[int] = []
    slowest_m_s = math.inf
    deadline_s = time.monotonic() + 10.0
    while True:
        status = robot.control.getAsyncOperationProgressEx()
        if not status.isAsyncOperationRunning() and progress:
            break
        if status.isAsyncOperationRunning() and status.progress() not in progress:
            progress.append(status.progress())
        if status.progress() in (1, 2):
            slowest_m_s = min(slowest_m_s, robot.tcp_speed_m_s())
        assert time.monotonic() < deadline_s
    assert progress == [0, 1, 2, 3]
    # An arc's chords are a little shorter than the arc.
    assert slowest_m_s == pytest.approx(SPEED_M_S, rel=0.01)


def test_a_path_without_blends_stops_at_each_corner(robot: Clients) -> None:
    started_s = robot.receive.getTimestamp()
    assert robot.control.moveL(square(robot, 0.0))
    stopping_s = robot.receive.getTimestamp() - started_s
    started_s = robot.receive.getTimestamp()
    assert robot.control.moveL(square(robot, 0.02))
    blending_s = robot.receive.getTimestamp() - started_s
    assert stopping_s == pytest.approx(4 * (0.1 / 0.25 + 0.25 / 1.2), abs=0.2)
    assert blending_s < stopping_s - 0.5


def test_a_path_of_joint_positions_and_a_mixed_path(robot: Clients) -> None:
    first, second = [0.2, -1.5, -1.6, -1.5, 1.5, 0.0], [0.4, -1.4, -1.7, -1.5, 1.5, 0.2]
    assert robot.control.moveJ([[*first, 1.5, 4.0, 0.02], [*second, 1.5, 4.0, 0.0]])
    wait_until(lambda: robot.receive.getActualQ() == pytest.approx(second, abs=1e-6))

    path = Path()
    target = robot.lifted(0.05)
    path.addEntry(PathEntry(PathEntry.MoveJ, PathEntry.PositionJoints, [*first, 1.5, 4.0, 0.0]))
    path.addEntry(PathEntry(PathEntry.MoveL, PathEntry.PositionTcpPose, [*target, 0.5, 2.0, 0.0]))
    assert robot.control.movePath(path, False)
    wait_until(lambda: distance_m(target, robot.receive.getActualTCPPose()) < 1e-5)


def test_a_speed_is_kept_until_it_is_stopped(robot: Clients) -> None:
    assert robot.control.speedL([0.0, 0.0, 0.1, 0.0, 0.0, 0.0], 0.5, 0.1)
    wait_until(lambda: robot.tcp_speed_m_s() == pytest.approx(0.1, rel=0.01))
    # The control program repeats the command, so the time that it was given for bounds nothing.
    height_m = robot.receive.getActualTCPPose()[2]
    wait_until(lambda: robot.receive.getActualTCPPose()[2] > height_m + 0.03)
    assert robot.control.speedStop(1.0)
    robot.wait_rest()

    assert robot.control.speedJ([0.2, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0)
    wait_until(lambda: robot.receive.getActualQd()[0] == pytest.approx(0.2))
    assert robot.control.speedStop(2.0)
    robot.wait_rest()


def test_a_move_while_a_speed_is_set_ends_the_program(robot: Clients, emulator: Emulator) -> None:
    assert robot.control.speedL([0.0, 0.0, 0.05, 0.0, 0.0, 0.0], 0.5, 0.1)
    robot.wait_moving()
    assert not robot.control.moveL(robot.lifted(0.1), SPEED_M_S, ACCELERATION_M_S2)
    wait_until(lambda: not robot.control.isProgramRunning())
    assert "another thread" in emulator.truth()["counters"]["last_error"]
    robot.wait_rest()


def test_servo_commands_lead_the_arm_to_their_target(robot: Clients) -> None:
    start = robot.receive.getActualQ()
    target = [start[0] + 0.05, *start[1:]]
    for step in range(1, 51):
        period = robot.control.initPeriod()
        goal = [start[0] + 0.001 * step, *start[1:]]
        assert robot.control.servoJ(goal, 0.5, 0.5, 0.002, 0.05, 300)
        robot.control.waitPeriod(period)
    wait_until(lambda: robot.receive.getActualQ() == pytest.approx(target, abs=1e-3))
    assert robot.control.servoStop(10.0)
    robot.wait_rest()


def braking_distance_m(robot: Clients, stop: str) -> float:
    """How far the TCP goes on after one of the two forms of ``stopL`` at 0.25 m/s, 0.5 m/s2."""
    # A path uploads the program anew, which forgets any stop before.
    path = [[*robot.lifted(0.6), SPEED_M_S, ACCELERATION_M_S2, 0.0]]
    assert robot.control.moveL(path, True)
    wait_until(lambda: robot.tcp_speed_m_s() == pytest.approx(SPEED_M_S, rel=1e-3))
    before = robot.receive.getActualTCPPose()
    robot.control.stopL(0.5, stop == "asynchronous")
    robot.wait_rest()
    return distance_m(before, robot.receive.getActualTCPPose())


def test_an_asynchronous_stop_brakes_on_the_line(robot: Clients) -> None:
    assert braking_distance_m(robot, "asynchronous") == pytest.approx(0.0625, abs=0.02)


def test_the_first_synchronous_stop_of_a_program_brakes_the_joints(robot: Clients) -> None:
    # 0.5 rad/s2 of the leading joint, not 0.5 m/s2 of the TCP.
    assert braking_distance_m(robot, "synchronous") > 0.0825


def test_an_unreachable_target_ends_in_a_failed_command(robot: Clients, emulator: Emulator) -> None:
    assert not robot.control.moveJ_IK([3.0, 0.0, 0.3, 0.0, 3.14, 0.0], 1.0, 1.0)
    assert "no solution" in emulator.truth()["counters"]["last_error"]
    wait_until(lambda: not robot.control.isProgramRunning())
