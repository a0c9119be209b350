"""Settings, read-backs, kinematics and digital lines with the real clients."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest
from rtde_control import RTDEControlInterface

from tests.sim.ur.harness import Clients, Emulator, distance_m, wait_until

UPLOAD_SCRIPT = int(RTDEControlInterface.FLAG_UPLOAD_SCRIPT)
UPPER_RANGE_REGISTERS = int(RTDEControlInterface.FLAG_UPPER_RANGE_REGISTERS)
TCP = [0.0, 0.01, 0.15, 0.0, 0.1, 0.0]


@pytest.fixture(scope="module")
def emulator() -> Iterator[Emulator]:
    with Emulator() as running:
        yield running


@pytest.fixture(scope="module")
def robot(emulator: Emulator) -> Iterator[Clients]:
    with Clients(emulator.host) as clients:
        yield clients


def test_tcp_and_payload_are_read_back(robot: Clients) -> None:
    flange = robot.control.getActualToolFlangePose()
    assert robot.control.setTcp(TCP)
    assert robot.control.getTCPOffset() == pytest.approx(TCP)
    wait_until(lambda: distance_m(flange, robot.receive.getActualTCPPose()) > 0.1)
    assert robot.control.setPayload(1.5, [0.0, 0.0, 0.08])
    wait_until(lambda: robot.receive.getPayload() == 1.5)
    assert robot.receive.getPayloadCog() == [0.0, 0.0, 0.08]
    assert robot.control.setTcp([0.0] * 6)


def test_forward_and_inverse_kinematics_agree_with_the_arm(robot: Clients) -> None:
    joints = robot.receive.getActualQ()
    pose = robot.receive.getActualTCPPose()
    assert robot.control.getInverseKinematics(pose) == pytest.approx(joints, abs=1e-6)
    near = [joint + 0.1 for joint in joints]
    assert robot.control.getInverseKinematics(pose, near) == pytest.approx(joints, abs=1e-6)
    moved = robot.control.getForwardKinematics(joints, [0.0, 0.0, 0.1, 0.0, 0.0, 0.0])
    assert distance_m(moved, pose) == pytest.approx(0.1)
    assert robot.control.poseTrans(pose, [0.0, 0.0, 0.1, 0.0, 0.0, 0.0])[:3] == pytest.approx(
        moved[:3]
    )
    assert robot.control.getInverseKinematicsHasSolution(pose)
    assert not robot.control.getInverseKinematicsHasSolution([3.0, *pose[1:]])


def test_safety_limits_know_what_is_out_of_reach(robot: Clients) -> None:
    pose = robot.receive.getActualTCPPose()
    assert robot.control.isPoseWithinSafetyLimits(pose)
    assert not robot.control.isPoseWithinSafetyLimits([2.0, *pose[1:]])
    assert robot.control.isJointsWithinSafetyLimits(robot.receive.getActualQ())
    assert not robot.control.isJointsWithinSafetyLimits([6.5, -1.5, -1.5, -1.5, 1.5, 0.0])


def test_the_arm_is_steady_some_time_after_a_move(robot: Clients) -> None:
    joints = robot.receive.getActualQ()
    assert robot.control.moveJ([joints[0] + 0.05, *joints[1:]], 1.0, 4.0)
    assert not robot.control.isSteady()
    wait_until(robot.control.isSteady, 3.0)


def test_the_step_time_is_the_cycle_of_an_e_series(robot: Clients) -> None:
    # The client does not wait for this answer: the first call returns what was there before.
    wait_until(lambda: robot.control.getStepTime() == 0.002)


def test_the_target_of_a_move_can_be_asked_for(robot: Clients) -> None:
    target = robot.lifted(0.1)
    assert robot.control.moveL(target, 0.25, 1.0, True)
    assert robot.control.getTargetWaypoint() == pytest.approx(target)
    robot.control.stopL(2.0, True)
    robot.wait_rest()


@pytest.mark.parametrize(
    ("setter", "line", "bit"),
    [
        ("setStandardDigitalOut", 3, 3),
        ("setConfigurableDigitalOut", 2, 10),
        ("setToolDigitalOut", 1, 17),
    ],
)
def test_an_output_reaches_the_cell_and_is_shown(
    robot: Clients, emulator: Emulator, setter: str, line: int, bit: int
) -> None:
    switch = getattr(robot.io, setter)
    assert switch(line, True)
    wait_until(lambda: robot.receive.getDigitalOutState(bit))
    assert emulator.truth()["outputs_at_plant"] == 1 << bit
    assert switch(line, False)
    wait_until(lambda: not robot.receive.getDigitalOutState(bit))
    assert emulator.truth()["outputs_at_plant"] == 0


def test_an_input_is_seen(robot: Clients, emulator: Emulator) -> None:
    emulator.tell("input 5 1")
    wait_until(lambda: robot.receive.getDigitalInState(5))
    emulator.tell("input 5 0")
    wait_until(lambda: not robot.receive.getDigitalInState(5))


def test_a_stuck_input_keeps_its_level_until_it_is_mended(
    robot: Clients, emulator: Emulator
) -> None:
    emulator.inject("stuck_input", "line=2 high=true")
    wait_until(lambda: robot.receive.getDigitalInState(2))
    emulator.clear("stuck_input", "line=2")
    wait_until(lambda: not robot.receive.getDigitalInState(2))


def test_a_flipped_input_shows_the_opposite(robot: Clients, emulator: Emulator) -> None:
    emulator.inject("flipped_input", "line=1")
    wait_until(lambda: robot.receive.getDigitalInState(1))
    emulator.tell("input 1 1")
    wait_until(lambda: not robot.receive.getDigitalInState(1))
    emulator.clear("flipped_input", "line=1")
    emulator.tell("input 1 0")
    wait_until(lambda: not robot.receive.getDigitalInState(1))


def test_a_broken_output_is_not_noticed_by_the_controller(
    robot: Clients, emulator: Emulator
) -> None:
    emulator.inject("stuck_output", "line=4 high=false")
    assert robot.io.setStandardDigitalOut(4, True)
    wait_until(lambda: robot.receive.getDigitalOutState(4))
    assert emulator.truth()["outputs_at_plant"] == 0
    emulator.clear("stuck_output", "line=4")
    wait_until(lambda: emulator.truth()["outputs_at_plant"] == 1 << 4)
    emulator.inject("flipped_output", "line=4")
    wait_until(lambda: emulator.truth()["outputs_at_plant"] == 0)
    emulator.clear("flipped_output", "line=4")
    assert robot.io.setStandardDigitalOut(4, False)
    wait_until(lambda: emulator.truth()["outputs_at_plant"] == 0)


def test_a_script_of_ones_own_runs_and_the_control_program_comes_back(robot: Clients) -> None:
    assert robot.control.sendCustomScriptFunction("own", "textmsg(1)\n")
    wait_until(robot.control.isProgramRunning)
    assert robot.control.moveL(robot.lifted(0.01), 0.25, 1.2)


def test_the_upper_registers_serve_as_well() -> None:
    with Emulator() as other:
        control = RTDEControlInterface(other.host, 500.0, UPLOAD_SCRIPT | UPPER_RANGE_REGISTERS)
        assert control.setTcp(TCP)
        assert control.getTCPOffset() == pytest.approx(TCP)
        assert control.setWatchdog(10.0)
        wait_until(lambda: other.truth()["watchdog"]["trips"] == 1)
        control.disconnect()
        del control


def test_numbers_that_are_none_stop_the_arm_and_not_the_controller(
    robot: Clients, emulator: Emulator
) -> None:
    joints = robot.receive.getActualQ()
    robot.control.speedJ([math.nan, *([0.0] * 5)], 1.0)
    wait_until(robot.receive.isProtectiveStopped)
    assert robot.receive.getActualQ() == joints
    assert "not a number" in emulator.truth()["safety_popup"]


def test_unknown_faults_and_lines_are_refused_with_what_is_known(emulator: Emulator) -> None:
    assert "safeguard_stop" in emulator.tell("inject safegard_stop")["error"]
    assert "0 to 17" in emulator.tell("inject stuck_input line=99 high=true")["error"]
    assert "cannot be cleared" in emulator.tell("clear kill_program")["error"]
    assert "wrong arguments" in emulator.tell("inject stuck_input")["error"]
    assert "not understood" in emulator.tell("dance")["error"]
