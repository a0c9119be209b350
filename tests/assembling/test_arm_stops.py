"""Stops of the robot's own in mid-move, what they are called, and the way out of each."""

from __future__ import annotations

import asyncio
import math
import os
import signal
from pathlib import Path

import pytest

from cellctl.assembling.arm_process import RemoteArm
from cellctl.errors import CellFault
from tests.assembling.emulator import Emulator
from tests.assembling.paths import away_from
from tests.assembling.test_arm import connected, stance, until_moving

pytestmark = pytest.mark.wire


async def interrupted(arm: RemoteArm, emulator: Emulator, command: str) -> CellFault:
    """The fault that ends a movement when the emulator is told something in mid-move."""
    move = asyncio.create_task(arm.follow(away_from(stance(arm).tcp_pose), 3.0))
    await until_moving(arm)
    emulator.tell(command)
    with pytest.raises(CellFault) as caught:
        await asyncio.wait_for(move, 10.0)
    return caught.value


async def goes_on(arm: RemoteArm) -> None:
    """The arm stands where it stood, and moves again."""
    target = away_from(stance(arm).tcp_pose)[0]
    await arm.follow((target,), 3.0)
    assert math.dist(stance(arm).tcp_pose[:3], target.pose[:3]) < 2e-3


async def recovered_in_place(arm: RemoteArm, emulator: Emulator) -> None:
    before = emulator.wait_until(lambda truth: not truth["moving"])["joints_rad"]
    await arm.recover()
    assert emulator.truth()["joints_rad"] == pytest.approx(before, abs=1e-6)
    await goes_on(arm)


def test_a_protective_stop_is_unlocked_after_its_five_seconds(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(quick_emulator.config) as arm:
            fault = await interrupted(arm, quick_emulator, "inject protective_stop")
            assert fault.code == "protective_stop"
            with pytest.raises(CellFault) as caught:
                await arm.follow(away_from(stance(arm).tcp_pose), 3.0)
            assert caught.value.code == "protective_stop"
            await recovered_in_place(arm, quick_emulator)

    asyncio.run(scenario())


def test_a_protective_stop_between_upload_and_start_is_no_deadlock(emulator: Emulator) -> None:
    """The library's path call waits for a program that a stop has paused, without a time limit."""

    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            move = asyncio.create_task(arm.follow(away_from(stance(arm).tcp_pose), 3.0))
            await asyncio.to_thread(emulator.wait_until, lambda truth: truth["speed_slider"] == 0.0)
            emulator.tell("inject protective_stop")
            with pytest.raises(CellFault) as caught:
                await asyncio.wait_for(move, 15.0)
            assert caught.value.code == "protective_stop"
            await arm.recover()

    asyncio.run(scenario())


def test_an_emergency_stop_needs_release_power_and_brakes(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(quick_emulator.config) as arm:
            fault = await interrupted(arm, quick_emulator, "inject emergency_stop")
            assert fault.code == "emergency_stop"
            with pytest.raises(CellFault) as caught:
                await arm.recover()
            assert caught.value.code == "emergency_stop"
            quick_emulator.tell("clear emergency_stop")
            await recovered_in_place(arm, quick_emulator)
            state = arm.state()
            assert state is not None
            assert state.powered

    asyncio.run(scenario())


def test_a_safeguard_stop_waits_until_the_space_is_empty(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(quick_emulator.config) as arm:
            fault = await interrupted(arm, quick_emulator, "inject safeguard_stop")
            assert fault.code == "safeguard_stop"
            with pytest.raises(CellFault) as caught:
                await arm.recover()
            assert caught.value.code == "safeguard_stop"
            quick_emulator.tell("clear safeguard_stop")
            await recovered_in_place(arm, quick_emulator)

    asyncio.run(scenario())


def test_local_control_takes_the_arm_away(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(quick_emulator.config) as arm:
            fault = await interrupted(arm, quick_emulator, "inject local_control")
            assert fault.code == "local_control"
            with pytest.raises(CellFault) as caught:
                await arm.recover()
            assert caught.value.code == "local_control"
            quick_emulator.tell("clear local_control")
            await recovered_in_place(arm, quick_emulator)

    asyncio.run(scenario())


def test_a_killed_program_is_told_from_the_rest(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(quick_emulator.config) as arm:
            fault = await interrupted(arm, quick_emulator, "inject kill_program")
            assert fault.code == "program_stopped"
            await arm.connect()
            await goes_on(arm)

    asyncio.run(scenario())


@pytest.mark.parametrize("how", ["drop_connections", "drop_connections reset=true", "freeze"])
def test_a_lost_controller_is_noticed_and_found_again(emulator: Emulator, how: str) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            fault = await interrupted(arm, emulator, f"inject {how}")
            if how == "freeze":
                # A controller that is silent for long enough to be lost is not there to be asked.
                assert fault.code == "robot_lost"
                emulator.tell("clear freeze")
            assert fault.code in ("robot_lost", "program_stopped")
            await arm.recover()
            await goes_on(arm)

    asyncio.run(scenario())
    assert emulator.truth()["counters"]["protective_stops"] == 0


def test_a_choice_of_speed_outlives_a_death_behind_the_gate(
    quick_emulator: Emulator, tmp_path: Path
) -> None:
    file = tmp_path / "journal.speed"

    async def scenario() -> None:
        async with connected(quick_emulator.config, file) as arm:
            quick_emulator.tell("inject speed_slider fraction=0.3")
            await goes_on(arm)
            await arm.prepare(away_from(stance(arm).tcp_pose))
            assert arm.process_id is not None
            os.kill(arm.process_id, signal.SIGKILL)
            assert quick_emulator.truth()["speed_slider"] == 0.0
            # As a daemon does that was started anew: nothing but the file is left.
            async with connected(quick_emulator.config, file):
                assert quick_emulator.truth()["speed_slider"] == 0.3

    asyncio.run(scenario())


def test_a_controller_that_refuses_the_connection(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        arm = RemoteArm(quick_emulator.config)
        quick_emulator.tell("inject refuse_connections")
        with pytest.raises(CellFault) as caught:
            await arm.connect()
        assert caught.value.code == "robot_lost"
        quick_emulator.tell("clear refuse_connections")
        await arm.connect()
        await goes_on(arm)
        await arm.close()

    asyncio.run(scenario())


def test_a_frozen_controller_does_not_hold_the_daemon_up(quick_emulator: Emulator) -> None:
    robot = quick_emulator.config.robot.model_copy(update={"connect_timeout_s": 3.0})
    config = quick_emulator.config.model_copy(update={"robot": robot})

    async def scenario() -> None:
        arm = RemoteArm(config)
        quick_emulator.tell("inject freeze")
        with pytest.raises(CellFault) as caught:
            await asyncio.wait_for(arm.connect(), 10.0)
        assert caught.value.code == "robot_lost"
        quick_emulator.tell("clear freeze")
        await arm.connect()
        await arm.close()

    asyncio.run(scenario())


def test_a_movement_that_takes_far_too_long_is_stopped(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(quick_emulator.config) as arm:
            far = away_from(stance(arm).tcp_pose)[1]
            crawl = far.model_copy(update={"speed_m_s": 0.02})
            with pytest.raises(CellFault) as caught:
                await arm.follow((crawl,), 0.5)
            assert caught.value.code == "motion_timeout"
            await arm.stop()
            assert not quick_emulator.truth()["moving"]

    asyncio.run(scenario())
