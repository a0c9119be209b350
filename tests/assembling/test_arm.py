"""The arm process against the emulated controller: moving, stopping, lines, connecting."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from cellctl.assembling.arm_process import RemoteArm
from cellctl.assembling.route import RoutePlanner, Stance
from cellctl.assembly import Cell
from cellctl.config import CellConfig
from cellctl.errors import CellFault
from tests.assembling.conftest import cell
from tests.assembling.emulator import Emulator
from tests.assembling.paths import away_from

pytestmark = pytest.mark.wire


@asynccontextmanager
async def connected(config: CellConfig, speed_file: Path | None = None) -> AsyncIterator[RemoteArm]:
    """An arm that is connected, and let go of at the end."""
    arm = RemoteArm(config, speed_file)
    try:
        await arm.connect()
        yield arm
    finally:
        await arm.close()


def stance(arm: RemoteArm) -> Stance:
    state = arm.state()
    assert state is not None
    return Stance(state.tcp_pose, state.joints_rad)


async def until_moving(arm: RemoteArm, faster_than_m_s: float = 0.3) -> None:
    async with asyncio.timeout(5.0):
        while True:
            state = arm.state()
            if state is not None and state.tcp_speed_m_s >= faster_than_m_s:
                return
            await asyncio.sleep(0.005)


def test_connecting_sets_tcp_and_payload_and_says_who_answers(either_cell: CellConfig) -> None:
    async def scenario(config: CellConfig) -> None:
        async with connected(config) as arm:
            identity = await arm.connect()
            assert identity.model == config.robot.model
            assert identity.controller_version.startswith(
                "3.15" if config.robot.model == "ur10" else "5.12"
            )
            state = arm.state()
            assert state is not None
            assert state.program_running
            assert state.powered
            assert state.safety == "normal"
            assert not state.moving

    with Emulator(either_cell) as emulator:
        asyncio.run(scenario(emulator.config))
        truth = emulator.truth()
    assert truth["tcp_offset"] == pytest.approx(either_cell.tool.frame)
    assert truth["payload_kg"] == pytest.approx(either_cell.tool.payload_kg)
    assert truth["payload_cog_m"] == pytest.approx(either_cell.tool.payload_cog_m)
    assert truth["program"] == "STOPPED"
    assert truth["watchdog"]["trips"] == 0


def test_routes_end_where_and_when_they_were_planned(either_cell: CellConfig) -> None:
    """The planned duration agrees with the time under way within 10 %."""

    async def under_way_s(arm: RemoteArm, move: asyncio.Task[None]) -> float:
        times_s = []
        while not move.done():
            state = arm.state()
            if state is not None and state.moving:
                times_s.append(state.robot_time_s)
            await asyncio.sleep(0.002)
        await move
        return times_s[-1] - times_s[0]

    async def scenario(config: CellConfig) -> None:
        planner = RoutePlanner(config)
        async with connected(config) as arm:
            placed: list[Cell] = []
            for goal in (Cell(0, 0, 0), Cell(5, 4, 0)):
                for carrying in (False, True):
                    start = stance(arm)
                    route = (
                        planner.to_cell(goal, placed, start)
                        if carrying
                        else planner.to_pick(start, placed)
                    )
                    move = asyncio.create_task(arm.follow(route.path, route.duration_s))
                    took_s = await under_way_s(arm, move)
                    assert took_s == pytest.approx(route.duration_s, rel=0.10)
                    end = stance(arm)
                    assert math.dist(end.tcp_pose[:3], route.path[-1].pose[:3]) < 1e-3
                    assert end.joints_rad == pytest.approx(route.end.joints_rad, abs=1e-3)
                placed.append(goal)

    with Emulator(either_cell) as emulator:
        asyncio.run(scenario(emulator.config))
        truth = emulator.truth()
    assert truth["blend_overlaps"] == 0
    assert truth["counters"]["protective_stops"] == 0
    assert truth["watchdog"]["trips"] == 0


def test_stop_brakes_on_the_line_and_ends_the_movement(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            path = away_from(stance(arm).tcp_pose)
            move = asyncio.create_task(arm.follow(path, 3.0))
            await until_moving(arm)
            before = stance(arm).tcp_pose
            await arm.stop()
            with pytest.raises(asyncio.CancelledError):
                await move
            state = arm.state()
            assert state is not None
            assert not state.moving
            # v^2 / 2a from 0.8 m/s, and what was travelled until the order arrived.
            assert math.dist(before[:3], state.tcp_pose[:3]) < 0.8**2 / 6.0 + 0.06
            await arm.follow(path[-1:], 3.0)
            assert math.dist(stance(arm).tcp_pose[:3], path[-1].pose[:3]) < 1e-3

    asyncio.run(scenario())
    assert emulator.truth()["speed_slider"] == 1.0


def test_an_abandoned_movement_does_not_go_on(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            move = asyncio.create_task(arm.follow(away_from(stance(arm).tcp_pose), 3.0))
            await until_moving(arm)
            move.cancel()
            with pytest.raises(asyncio.CancelledError):
                await move
            assert not emulator.truth()["moving"]

    asyncio.run(scenario())


def test_a_prepared_path_moves_nothing_until_it_is_followed(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            before = stance(arm)
            path = away_from(before.tcp_pose)
            await arm.prepare(path)
            assert await arm.wait_input(0, True, 0.3) is False
            assert stance(arm).joints_rad == before.joints_rad
            uploads = emulator.truth()["counters"]["uploads"]
            await arm.follow(path, 3.0)
            assert math.dist(stance(arm).tcp_pose[:3], path[-1].pose[:3]) < 1e-3
            assert emulator.truth()["counters"]["uploads"] == uploads

    asyncio.run(scenario())
    assert emulator.truth()["watchdog"]["trips"] == 0


def test_what_was_prepared_is_dropped_by_whatever_else_is_ordered(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            before = stance(arm)
            path = away_from(before.tcp_pose)
            await arm.prepare(path)
            await arm.stop()
            assert emulator.truth()["speed_slider"] == 1.0
            assert await arm.wait_input(0, True, 0.3) is False
            assert stance(arm).joints_rad == before.joints_rad
            await arm.prepare(path)
            turned_rad = (*before.joints_rad[:5], before.joints_rad[5] - 0.2)
            await arm.move_joints(turned_rad, 0.8)
            assert stance(arm).joints_rad == pytest.approx(turned_rad, abs=2e-3)
            await arm.prepare(path)
            await arm.follow(path[:1], 3.0)
            assert math.dist(stance(arm).tcp_pose[:3], path[0].pose[:3]) < 1e-3

    asyncio.run(scenario())


def test_the_pendants_slider_does_not_set_a_prepared_path_going(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            before = stance(arm)
            path = away_from(before.tcp_pose)
            await arm.prepare(path)
            emulator.tell("inject speed_slider fraction=0.5")
            assert await arm.wait_input(0, True, 0.3) is False
            assert math.dist(stance(arm).tcp_pose[:3], before.tcp_pose[:3]) < 2e-3
            # Whoever moved it chose a speed.
            assert emulator.truth()["speed_slider"] == 0.5
            await arm.follow(path, 6.0)
            assert math.dist(stance(arm).tcp_pose[:3], path[-1].pose[:3]) < 1e-3
            assert emulator.truth()["speed_slider"] == 0.5

    asyncio.run(scenario())
    assert emulator.truth()["watchdog"]["trips"] == 0


def test_stopping_an_arm_at_rest_is_no_fault(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(quick_emulator.config) as arm:
            before = stance(arm)
            await arm.stop()
            assert stance(arm).joints_rad == pytest.approx(before.joints_rad, abs=1e-6)

    asyncio.run(scenario())


def test_homing_turns_the_joints(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(quick_emulator.config) as arm:
            home_rad = stance(arm).joints_rad
            target_rad = (*home_rad[:5], home_rad[5] - 0.5)
            await arm.move_joints(target_rad, 0.8)
            assert stance(arm).joints_rad == pytest.approx(target_rad, abs=2e-3)
            await arm.move_joints(home_rad, 0.8)
            assert stance(arm).joints_rad == pytest.approx(home_rad, abs=2e-3)

    asyncio.run(scenario())
    assert quick_emulator.truth()["counters"]["uploads"] == 1


def test_lines_are_switched_and_read(quick_emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(quick_emulator.config) as arm:
            await arm.set_output(3, high=True)
            state = arm.state()
            assert state is not None
            assert state.digital_outputs == 1 << 3
            assert quick_emulator.truth()["outputs_at_plant"] == 1 << 3
            await arm.set_output(3, high=False)
            assert quick_emulator.truth()["outputs_at_plant"] == 0

            assert not await arm.wait_input(2, high=True, timeout_s=0.3)
            assert await arm.wait_input(2, high=False, timeout_s=0.3)
            rise = asyncio.create_task(arm.wait_input(2, high=True, timeout_s=20.0))
            quick_emulator.tell("input 2 1")
            assert await rise

    asyncio.run(scenario())


def test_the_wrong_model_is_refused(quick_emulator: Emulator) -> None:
    robot = quick_emulator.config.robot.model_copy(
        update={"model": "ur10", "rtde_frequency_hz": 125}
    )
    wrong = quick_emulator.config.model_copy(update={"robot": robot})

    async def scenario() -> None:
        with pytest.raises(CellFault) as caught:
            await RemoteArm(wrong).connect()
        assert caught.value.code == "robot_mismatch"
        assert "says ur10; the controller says UR10 with software 5.12" in caught.value.detail

    asyncio.run(scenario())


def test_nobody_there_is_robot_lost() -> None:
    robot = cell("ur10e").robot.model_copy(update={"host": "127.0.0.39"})
    config = cell("ur10e").model_copy(update={"robot": robot})

    async def scenario() -> None:
        arm = RemoteArm(config)
        with pytest.raises(CellFault) as caught:
            await arm.connect()
        assert caught.value.code == "robot_lost"
        assert "127.0.0.39:29999" in caught.value.detail
        assert arm.state() is None
        with pytest.raises(CellFault, match="not connected"):
            await arm.set_output(0, high=True)

    asyncio.run(scenario())
