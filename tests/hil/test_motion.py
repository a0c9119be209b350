"""What moves, in the order in which it must: the latch, one index, a part built, silence.

Each asks the operator first. The build keeps its journal in a folder of its own, so the cell's own
journal does not know of it: count the parts afterwards.
"""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from cellctl.assembling.arm_process import RemoteArm
from cellctl.assembling.gripper_board import GripperBoard
from cellctl.assembling.latch_gripper import LatchGripper
from cellctl.assembly import Assembly
from cellctl.boards.constants import (
    PITCH_UNIT_M,
    SILENCE_S,
    BoardRole,
    Command,
    ErrorCode,
    ReplyKind,
)
from cellctl.boards.line import CommandLine, encode_command
from cellctl.cli.daemon_process import running_daemon, wait_idle
from cellctl.client import CellClient
from cellctl.clock import SystemClock
from cellctl.config import CellConfig
from cellctl.feeding.conveyor import Conveyor
from tests.hil.conftest import Operator
from tests.hil.test_boards import REPLY_S, raw

BUILD_PATIENCE_S = 180.0
QUIET_S = 5 * SILENCE_S
"""Much longer than a board waits: an emulated one on a busy computer may be behind the clock."""


@asynccontextmanager
async def gripper(config: CellConfig) -> AsyncIterator[tuple[LatchGripper, GripperBoard | None]]:
    """The latch behind the robot's lines, and its board where it has a port."""
    arm = RemoteArm(config)
    board = GripperBoard(config.gripper, lambda _: None) if config.gripper.port else None
    try:
        await arm.connect()
        yield LatchGripper(arm, config, board), board
    finally:
        if board is not None:
            await board.close()
        await arm.close()


def test_the_lines_move_the_latch_and_the_board_agrees(
    config: CellConfig, operator: Operator
) -> None:
    operator.allows(
        "The latch opens, closes and opens again; the arm stays where it is.",
        "Is the gripper empty, and no finger near it?",
    )

    async def scenario() -> None:
        async with gripper(config) as (latch, board):
            took_s = await latch.check_wiring()
            print(f"\nconfirmed after {took_s:.2f} s")  # noqa: T201 - for the operator
            await latch.latch()
            if board is not None:
                closed = await board.state()
                assert (closed.told_open, closed.confirmed) == (False, True)
            await latch.unlatch()
            if board is not None:
                opened = await board.state()
                assert (opened.told_open, opened.confirmed) == (True, False)
                assert opened.cycles == closed.cycles

    asyncio.run(scenario())


def test_an_index_brings_one_part_and_another_brings_no_second(
    config: CellConfig, operator: Operator
) -> None:
    operator.allows(
        "The belt brings one part to the pick station.",
        "Are there parts on it, none at the station, and no hand on it?",
    )

    async def scenario() -> None:
        conveyor = Conveyor(config.feeder, config.voxel.pitch_m, SystemClock(_rate(config)))
        try:
            before = await conveyor.state()
            await conveyor.present()
            after = await conveyor.state()
            assert after.part_present
            assert not after.moving
            assert after.indexes == before.indexes + 1
            await conveyor.present()
            assert (await conveyor.state()).indexes == after.indexes
        finally:
            await conveyor.close()

    asyncio.run(scenario())


@pytest.fixture
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="cellctl-hil-") as name:
        yield Path(name)


def test_a_part_is_picked_placed_and_left_standing(
    config: CellConfig, operator: Operator, folder: Path
) -> None:
    operator.allows(
        "The arm picks the part at the station, places it in the workspace and goes home.",
        "Is the workspace empty, a hand at the emergency stop, and nobody in the arm's reach?",
    )
    own = _with_own_daemon(config, folder)
    cube = Assembly.of([(0, 0, 0)], pitch_m=config.voxel.pitch_m)
    with running_daemon(own, folder) as daemon, CellClient.for_role(own) as cell:
        wait_idle(cell, daemon)
        cell.subscribe()
        cell.build("cube.json", cube.model_dump_json().encode())
        for _ in cell.messages(BUILD_PATIENCE_S):
            snapshot = cell.snapshot()
            assert snapshot.fault.entry is None, snapshot.fault
            if snapshot.job is not None and snapshot.job.outcome:
                break
        assert snapshot.job is not None
        assert snapshot.job.outcome == "built", snapshot.job
        assert snapshot.job.parts_placed == 1
    operator.does("Take the part out of the workspace, whole.")


def test_the_belt_stops_by_itself_when_its_host_falls_silent(
    config: CellConfig, operator: Operator
) -> None:
    operator.allows(
        "The belt starts and stops again after a moment, on the way to the next part.",
        "Is no part at the station, and no hand on the belt?",
    )
    pitch = round(config.voxel.pitch_m / PITCH_UNIT_M)

    async def scenario() -> None:
        async with raw(config, BoardRole.CONVEYOR) as board:
            began = await board.ask(Command.FORWARD, pitch)
            assert began.kind is ReplyKind.BUSY, began
            with pytest.raises(TimeoutError):  # and the board says nothing unasked
                async with asyncio.timeout(QUIET_S):
                    await board.link.receive()
            board.link.send(encode_command(CommandLine(began.sequence, Command.FORWARD, pitch)))
            async with asyncio.timeout(REPLY_S):
                ended = await board.link.receive()
            assert getattr(ended, "error", None) is ErrorCode.SILENCE, ended

    asyncio.run(scenario())


def _rate(config: CellConfig) -> float:
    return config.cell.clock_rate


def _with_own_daemon(config: CellConfig, folder: Path) -> CellConfig:
    """The same cell with a journal, a bus and a policy for this one build."""
    bus = {name: f"ipc://{folder}/{name}" for name in ("status", "visitor", "operator")}
    return config.model_copy(
        update={
            "journal": config.journal.model_copy(update={"path": str(folder / "journal.db")}),
            "bus": config.bus.model_copy(update=bus),
            "policy": config.policy.model_copy(update={"confirmation": "waived"}),
            "hearing": config.hearing.model_copy(update={"microphone": "none"}),
        }
    )
