"""Protective, safeguard and emergency stops, local control, and the ways out of each."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.sim.ur.harness import Clients, Emulator, distance_m, wait_until

UNLOCK_AFTER_S = 0.5
EMERGENCY_BIT = 1 << 7


@pytest.fixture(scope="module")
def emulator() -> Iterator[Emulator]:
    with Emulator(unlock_after_s=UNLOCK_AFTER_S, power_on_s=0.2, brake_release_s=0.2) as running:
        yield running


@pytest.fixture(scope="module")
def robot(emulator: Emulator) -> Iterator[Clients]:
    with Clients(emulator.host) as clients:
        yield clients


@pytest.fixture(autouse=True)
def ready(robot: Clients) -> None:
    if robot.receive.isProtectiveStopped():
        unlock(robot)
    if not robot.control.isProgramRunning():
        robot.dashboard.stop()
        assert robot.control.reuploadScript()
        wait_until(robot.control.isProgramRunning)
    assert robot.control.moveJ([0.0, -1.5708, -1.5708, -1.5708, 1.5708, 0.0], 2.0, 10.0)


def start_moving(robot: Clients) -> None:
    assert robot.control.moveL(robot.lifted(0.3), 0.25, 1.2, True)
    robot.wait_moving()


def restart(robot: Clients) -> None:
    """Start the control program again and show that it moves the arm."""
    assert robot.control.reuploadScript()
    wait_until(robot.control.isProgramRunning)
    assert robot.control.moveL(robot.lifted(0.05), 0.25, 1.2)


def unlock(robot: Clients) -> None:
    robot.dashboard.closeSafetyPopup()

    def unlocked() -> bool:
        try:
            robot.dashboard.unlockProtectiveStop()
        except RuntimeError as error:
            assert "until 5s after" in str(error)  # noqa: PT017 - the client raises on the reply
            return False
        return True

    wait_until(unlocked)
    wait_until(lambda: not robot.receive.isProtectiveStopped())


def test_a_protective_stop_fails_the_move_and_is_unlocked_after_its_time(
    robot: Clients, emulator: Emulator
) -> None:
    start_moving(robot)
    emulator.inject("protective_stop")
    wait_until(robot.receive.isProtectiveStopped)
    robot.wait_rest()
    wait_until(lambda: not robot.control.isProgramRunning())
    assert not robot.control.moveL(robot.lifted(0.1), 0.25, 1.2)
    assert robot.receive.getRuntimeState() == 4  # paused
    with pytest.raises(RuntimeError, match="Cannot unlock"):
        robot.dashboard.unlockProtectiveStop()
    unlock(robot)
    assert robot.dashboard.programState().startswith("PAUSED")
    robot.dashboard.stop()
    restart(robot)


def test_a_blocking_move_returns_false_in_a_protective_stop(robot: Clients) -> None:
    # The path is exact, but leads the base joint beyond what it may turn.
    joints = robot.receive.getActualQ()
    assert not robot.control.moveJ([6.4, *joints[1:]], 1.0, 1.0)
    wait_until(robot.receive.isProtectiveStopped)
    unlock(robot)
    robot.dashboard.stop()
    restart(robot)


def test_an_upload_into_a_paused_program_only_stops_it(robot: Clients, emulator: Emulator) -> None:
    start_moving(robot)
    emulator.inject("protective_stop")
    wait_until(robot.receive.isProtectiveStopped)
    unlock(robot)
    assert robot.control.reuploadScript()
    wait_until(lambda: robot.receive.getRuntimeState() == 1)
    wait_until(lambda: not robot.control.isProgramRunning())
    restart(robot)


def test_a_paused_program_goes_on_where_it_was(robot: Clients) -> None:
    target = robot.lifted(0.15)
    assert robot.control.moveL(target, 0.25, 1.2, True)
    robot.wait_moving()
    robot.dashboard.pause()
    robot.wait_rest()
    assert distance_m(robot.receive.getActualTCPPose(), target) > 0.01
    wait_until(lambda: robot.receive.getRuntimeState() == 4)
    robot.dashboard.play()
    wait_until(lambda: distance_m(robot.receive.getActualTCPPose(), target) < 1e-6)


def test_a_safeguard_holds_the_arm_until_it_is_closed_and_the_program_played(
    robot: Clients, emulator: Emulator
) -> None:
    target = robot.lifted(0.15)
    assert robot.control.moveL(target, 0.25, 1.2, True)
    robot.wait_moving()
    emulator.inject("safeguard_stop")
    wait_until(lambda: robot.receive.getSafetyMode() == 5)
    assert robot.receive.getSafetyStatusBits() & 1 << 4
    robot.wait_rest()
    assert "SAFEGUARD_STOP" in robot.dashboard.safetystatus()
    with pytest.raises(RuntimeError, match="Failed to execute: play"):
        robot.dashboard.play()
    emulator.clear("safeguard_stop")
    wait_until(lambda: robot.receive.getSafetyMode() == 1)
    assert not any(robot.receive.getActualQd())
    robot.dashboard.play()
    wait_until(lambda: distance_m(robot.receive.getActualTCPPose(), target) < 1e-6)


def test_after_an_emergency_stop_the_arm_needs_power_and_brakes(
    robot: Clients, emulator: Emulator
) -> None:
    start_moving(robot)
    emulator.inject("emergency_stop")
    wait_until(robot.receive.isEmergencyStopped)
    wait_until(lambda: robot.receive.getRobotMode() == 3)
    assert robot.receive.getSafetyMode() == 7
    assert robot.receive.getRuntimeState() == 1
    assert not any(robot.receive.getActualQd())
    # The button is in: power cannot be switched on.
    robot.dashboard.powerOn()
    assert "POWER_OFF" in robot.dashboard.robotmode()
    emulator.clear("emergency_stop")
    robot.dashboard.closeSafetyPopup()
    wait_until(lambda: robot.receive.getSafetyMode() == 1)
    assert not robot.receive.getSafetyStatusBits() & EMERGENCY_BIT
    robot.dashboard.powerOn()
    wait_until(lambda: robot.receive.getRobotMode() == 5)
    # Brakes held: a program does not start.
    assert robot.control.reuploadScript()
    assert emulator.truth()["program"] == "STOPPED"
    robot.dashboard.brakeRelease()
    wait_until(lambda: robot.receive.getRobotMode() == 7)
    restart(robot)


def test_in_local_control_the_network_is_not_obeyed(robot: Clients, emulator: Emulator) -> None:
    emulator.inject("local_control")
    wait_until(lambda: not robot.control.isProgramRunning())
    assert not robot.dashboard.isInRemoteControl()
    with pytest.raises(RuntimeError, match="Failed to execute"):
        robot.dashboard.stop()
    refused = emulator.truth()["counters"]["uploads_refused"]
    assert robot.control.reuploadScript()
    wait_until(lambda: emulator.truth()["counters"]["uploads_refused"] > refused)
    assert emulator.truth()["program"] == "STOPPED"
    emulator.clear("local_control")
    assert robot.dashboard.isInRemoteControl()
    restart(robot)


def test_a_killed_program_brakes_the_arm(robot: Clients, emulator: Emulator) -> None:
    start_moving(robot)
    emulator.inject("kill_program")
    wait_until(lambda: emulator.truth()["program"] == "STOPPED")
    robot.wait_rest()
    wait_until(lambda: emulator.truth()["braking"]["at_rest"])
    truth = emulator.truth()
    assert truth["braking"]["cause"] == "killed"
    assert 0.0 < truth["braking"]["distance_m"] < 0.02
    restart(robot)


def test_the_speed_slider_holds_the_arm_without_ending_the_program(robot: Clients) -> None:
    target = robot.lifted(0.15)
    assert robot.control.moveL(target, 0.25, 1.2, True)
    robot.wait_moving()
    assert robot.io.setSpeedSlider(0.0)
    robot.wait_rest()
    assert robot.control.isProgramRunning()
    assert robot.receive.getTargetSpeedFraction() == 0.0
    assert robot.receive.getSpeedScaling() == 0.0
    assert robot.control.getAsyncOperationProgressEx().isAsyncOperationRunning()
    assert distance_m(robot.receive.getActualTCPPose(), target) > 0.01
    assert robot.io.setSpeedSlider(0.5)
    wait_until(lambda: robot.tcp_speed_m_s() > 0.05)
    assert robot.tcp_speed_m_s() < 0.126
    assert robot.io.setSpeedSlider(1.0)
    wait_until(lambda: distance_m(robot.receive.getActualTCPPose(), target) < 1e-6)
    wait_until(lambda: robot.receive.getSpeedScaling() == 1.0)
