"""SIGKILL of the arm process, of the daemon, or of both: the arm never goes on by itself.

At the speed of a real cell. The emulated controller tells when its watchdog made the arm brake;
what it cannot tell from outside is the moment of the kill, so its clock is read just before.
"""

from __future__ import annotations

import asyncio
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from cellctl.assembling.arm_link import STOP_DECELERATION_M_S2
from cellctl.config import CellConfig
from cellctl.errors import CellFault
from tests.assembling.conftest import cell
from tests.assembling.emulator import Emulator
from tests.assembling.paths import SPEED_M_S, away_from
from tests.assembling.test_arm import connected, stance, until_moving

pytestmark = pytest.mark.wire

BRAKES_WITHIN_S = 0.15
READING_S = 0.02
"""Between reading the emulator's clock and the kill."""
STOPPING_M = 0.16
"""Greatest distance of the emulated watchdog's stop from 0.8 m/s, along the path."""
OWN_STOP_M = SPEED_M_S**2 / (2.0 * STOP_DECELERATION_M_S2)
"""Distance of the arm process's own stop from that speed."""
FIRST_100_MS = (0, 40, 50, 60, 100)
EVERY_3_MS = range(0, 130, 3)


@contextmanager
def driven(emulator: Emulator) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """A daemon in small, ready to move, and the process id of its arm process."""
    command = [sys.executable, "-m", "tests.assembling.driver"]
    with subprocess.Popen(
        [*command, emulator.config.model_dump_json()],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as driver:
        try:
            assert driver.stdout is not None
            yield driver, int(driver.stdout.readline())
        finally:
            driver.kill()


def start(driver: subprocess.Popen[str]) -> None:
    assert driver.stdin is not None
    driver.stdin.write("go\n")
    driver.stdin.flush()


def settled(emulator: Emulator, after_s: float) -> dict[str, Any]:
    """The truth once the arm has been at rest for a while, at the earliest a second later."""
    return emulator.wait_until(
        lambda truth: truth["time_s"] > after_s + 1.0 and not truth["moving"]
    )


def braked_after_s(before: dict[str, Any], after: dict[str, Any]) -> float:
    """How long after ``before`` the arm began to brake; 0 when it never moved.

    However long that took, it must have stopped within its distance from there. The controller
    tells when it braked by itself; when the arm process stopped it, the distance tells.
    """
    travelled_m = math.dist(before["tcp_pose"][:3], after["tcp_pose"][:3])
    if travelled_m <= 1e-4:
        return 0.0
    if after["braking"] is None:
        return max(0.0, travelled_m - OWN_STOP_M) / SPEED_M_S
    delay_s: float = after["braking"]["started_s"] - before["time_s"]
    assert after["braking"]["distance_m"] <= STOPPING_M
    assert travelled_m <= SPEED_M_S * delay_s + STOPPING_M
    return delay_s


def in_time(config: CellConfig, trial: Callable[[Emulator], float]) -> None:
    """The best of six trials brakes in time: a busy machine may hold up any one of them."""
    delays_s = []
    for _ in range(6):
        with Emulator(config) as emulator:
            delays_s.append(trial(emulator))
        if delays_s[-1] <= BRAKES_WITHIN_S + READING_S:
            return
    pytest.fail(f"the arm began to brake {delays_s} s after the kill")


@pytest.mark.parametrize("killed", ["arm process", "daemon", "both"])
def test_a_kill_in_mid_move(config: CellConfig, killed: str) -> None:
    def trial(emulator: Emulator) -> float:
        with driven(emulator) as (driver, arm_pid):
            start(driver)
            before = emulator.wait_until(lambda truth: truth["tcp_speed_m_s"] > 0.75)
            if killed != "arm process":
                driver.kill()
            if killed != "daemon":
                os.kill(arm_pid, signal.SIGKILL)
            # An arm process that outlives its daemon ends the program once the arm rests, which on
            # a busy machine comes well after that.
            after = emulator.wait_until(
                lambda truth: not truth["moving"] and truth["program"] == "STOPPED"
            )
            later = settled(emulator, after["time_s"])
        if killed != "daemon":
            assert after["watchdog"]["trips"] == 1
            assert after["braking"]["cause"] == "watchdog"
        assert later["tcp_pose"] == after["tcp_pose"]
        return braked_after_s(before, after)

    in_time(config, trial)


@pytest.mark.parametrize(
    "delay_ms",
    [*FIRST_100_MS, *(pytest.param(delay, marks=pytest.mark.soak) for delay in EVERY_3_MS)],
)
def test_a_kill_of_both_in_the_first_100_ms(config: CellConfig, delay_ms: int) -> None:
    """Among these moments are those between the upload, which drops the watchdog, and its arming:
    the program then runs unwatched, behind the closed gate."""

    def trial(emulator: Emulator) -> float:
        with driven(emulator) as (driver, arm_pid):
            start(driver)
            time.sleep(delay_ms / 1e3)  # the delay is what is tested
            before = emulator.truth()
            driver.kill()
            os.kill(arm_pid, signal.SIGKILL)
            after = settled(emulator, before["time_s"])
        assert after["program"] == "STOPPED" or after["speed_slider"] == 0.0
        return braked_after_s(before, after)

    in_time(config, trial)


def test_a_killed_arm_process_is_a_fault_and_replaced(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            move = asyncio.create_task(arm.follow(away_from(stance(arm).tcp_pose), 3.0))
            await until_moving(arm)
            first = arm.process_id
            assert first is not None
            os.kill(first, signal.SIGKILL)
            with pytest.raises(CellFault) as caught:
                await move
            assert caught.value.code == "program_stopped"
            assert arm.state() is None
            await arm.connect()
            assert arm.process_id not in (None, first)
            await arm.follow(away_from(stance(arm).tcp_pose)[:1], 3.0)

    asyncio.run(scenario())


def test_a_gate_that_a_kill_left_closed_is_opened_again(emulator: Emulator) -> None:
    with driven(emulator) as (driver, arm_pid):
        start(driver)
        emulator.wait_until(lambda truth: truth["speed_slider"] == 0.0)
        driver.kill()
        os.kill(arm_pid, signal.SIGKILL)

    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            await arm.follow(away_from(stance(arm).tcp_pose)[:1], 3.0)

    asyncio.run(scenario())
    assert emulator.truth()["speed_slider"] == 1.0


def test_a_hanging_arm_process_is_replaced(config: CellConfig) -> None:
    async def scenario(emulator: Emulator) -> float:
        async with connected(emulator.config) as arm:
            move = asyncio.create_task(arm.follow(away_from(stance(arm).tcp_pose), 3.0))
            await until_moving(arm)
            hanging = arm.process_id
            assert hanging is not None
            before = emulator.truth()
            os.kill(hanging, signal.SIGSTOP)
            after = settled(emulator, before["time_s"])
            assert after["watchdog"]["trips"] == 1
            with pytest.raises(CellFault) as caught:
                await asyncio.wait_for(move, 15.0)
            assert caught.value.code == "program_stopped"
            await arm.connect()
            return braked_after_s(before, after)

    in_time(config, lambda emulator: asyncio.run(scenario(emulator)))


def test_a_silent_daemon_is_no_daemon() -> None:
    config = cell("ur10e")
    robot = config.robot.model_copy(update={"host_silence_s": 0.3})
    with (
        Emulator(config.model_copy(update={"robot": robot})) as emulator,
        driven(emulator) as (driver, _),
    ):
        start(driver)
        before = emulator.wait_until(lambda truth: truth["tcp_speed_m_s"] > 0.5)
        os.kill(driver.pid, signal.SIGSTOP)
        after = settled(emulator, before["time_s"])
        os.kill(driver.pid, signal.SIGCONT)
        travelled_m = math.dist(before["tcp_pose"][:3], after["tcp_pose"][:3])
        assert travelled_m < SPEED_M_S * 0.45 + STOPPING_M
        assert after["watchdog"]["trips"] == 0
        assert after["program"] == "PLAYING"
