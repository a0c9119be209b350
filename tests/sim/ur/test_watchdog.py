"""The watchdog: a client that dies or stalls stops the arm, a busy machine does not."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from typing import Any

import pytest

from cellctl.sim.ur.watchdog import Watchdog
from tests.sim.ur.harness import Clients, Emulator, wait_until

WINDOW_S = 0.1
BRAKES_WITHIN_S = 0.15


def kill_client_while_moving(emulator: Emulator) -> dict[str, Any]:
    """What the controller says after its client was killed in the middle of a path."""
    command = [sys.executable, "-m", "tests.sim.ur.moving_client", emulator.host]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as client:
        assert client.stdout is not None
        assert client.stdout.readline() == "moving\n"
        assert emulator.truth()["watchdog"]["armed"]
        client.send_signal(signal.SIGKILL)
    wait_until(lambda: not emulator.truth()["moving"])
    return emulator.truth()


def test_a_killed_client_makes_the_arm_brake_in_time_and_within_its_distance() -> None:
    with Emulator() as emulator:
        truth = kill_client_while_moving(emulator)
    assert truth["watchdog"]["trips"] == 1
    assert WINDOW_S <= truth["watchdog"]["last_trip_wall_s"] <= BRAKES_WITHIN_S
    assert truth["braking"]["cause"] == "watchdog"
    assert truth["braking"]["at_rest"]
    # The leading joint brakes with 5 rad/s2, and turns with at most 0.5 m/s / 0.6 m here.
    speed_m_s = truth["braking"]["speed_m_s"]
    assert speed_m_s == pytest.approx(0.5, rel=0.05)
    assert 0.01 < truth["braking"]["distance_m"] < speed_m_s * 0.83 / 5.0 / 2.0 * 1.1
    assert truth["program"] == "STOPPED"


def test_a_speed_up_leaves_the_window_its_wall_time() -> None:
    with Emulator(clock_rate=5.0) as emulator:
        truth = kill_client_while_moving(emulator)
    assert truth["watchdog"]["trips"] == 1
    assert WINDOW_S <= truth["watchdog"]["last_trip_wall_s"] <= BRAKES_WITHIN_S


def test_kicks_keep_the_program_and_silence_ends_it_with_a_client_that_lives() -> None:
    with Emulator() as emulator, Clients(emulator.host) as robot:
        assert robot.control.setWatchdog(10.0)
        deadline_s = time.monotonic() + 5 * WINDOW_S
        wait_until(lambda: robot.control.kickWatchdog() and time.monotonic() > deadline_s)
        assert emulator.truth()["watchdog"]["trips"] == 0
        # A blocking move writes nothing while it waits, so the watchdog ends it.
        assert not robot.control.moveL(robot.lifted(0.2), 0.25, 1.2)
        assert emulator.truth()["watchdog"]["trips"] == 1

        assert robot.control.reuploadScript()
        wait_until(robot.control.isProgramRunning)
        assert robot.control.setWatchdog(10.0)
        # A path move uploads the program anew, and a new program has no watchdog.
        path = [[*robot.lifted(0.1), 0.25, 1.2, 0.0], [*robot.lifted(0.05), 0.25, 1.2, 0.0]]
        assert robot.control.moveL(path)
        truth = emulator.truth()
        assert not truth["watchdog"]["armed"]
        assert truth["watchdog"]["trips"] == 1


class HandClock:
    """A clock that is set by hand."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


def test_a_stall_counts_as_one_short_tick() -> None:
    clock = HandClock()
    watchdog = Watchdog(0.02, clock)
    watchdog.arm(10.0)
    assert not watchdog.due(0.002)
    # Four stalls of a second are not the window; a fifth and the window's rest are.
    for _ in range(4):
        assert not watchdog.due(1.0)
    assert watchdog.silence_s == pytest.approx(0.08)
    assert watchdog.due(1.0)


def test_a_write_starts_the_window_over() -> None:
    clock = HandClock()
    watchdog = Watchdog(0.02, clock)
    watchdog.arm(10.0)
    for _ in range(40):
        assert not watchdog.due(0.002)
    watchdog.written()
    clock.now_s = 0.1
    assert [watchdog.due(0.002) for _ in range(51)] == [False] * 50 + [True]
    watchdog.trip()
    assert watchdog.trips == 1
    assert watchdog.last_trip_wall_s == pytest.approx(0.1)
    assert not watchdog.due(10.0)
