"""The gripper's driver against its emulated board, through real pyserial on a pseudo-terminal."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from cellctl.assembling.gripper_board import RANGES, GripperBoard
from cellctl.boards.constants import (
    LATCH_PULSE_US,
    TRAVEL_MS,
    Command,
    Register,
    ResetCause,
    SelfTest,
)
from cellctl.boards.session import BoardLostError, BoardMismatchError
from cellctl.config import load_config
from cellctl.errors import RefusedError, UsageError
from cellctl.sim.gripper_board import SERIAL_NUMBER, GripperBoardEmulator
from cellctl.sim.latch import Latch
from cellctl.sim.world import World
from tests.leaks import REPOSITORY

DEADLINE_S = 20.0
TICK_S = 0.005


class Noticed:
    """The resets that the driver told of."""

    def __init__(self) -> None:
        self.causes: list[ResetCause | None] = []
        self._one = asyncio.Event()

    def take(self, cause: ResetCause | None) -> None:
        self.causes.append(cause)
        self._one.set()

    async def wait(self) -> None:
        async with asyncio.timeout(DEADLINE_S):
            await self._one.wait()


@dataclass
class Bench:
    """A driver, the emulated board behind a pty, and its latch."""

    board: GripperBoard
    emulator: GripperBoardEmulator
    latch: Latch
    noticed: Noticed

    def run_latch(self, duration_s: float) -> None:
        """Let the latch alone have time."""
        for _ in range(round(duration_s / TICK_S)):
            self.latch.advance(TICK_S)


@asynccontextmanager
async def bench(**gripper: object) -> AsyncIterator[Bench]:
    base = load_config(REPOSITORY / "config" / "sim.toml")
    with tempfile.TemporaryDirectory() as folder:
        port = str(Path(folder) / "gripper")
        section = base.gripper.model_copy(update={"port": port, "reply_timeout_s": 0.1, **gripper})
        config = base.model_copy(update={"gripper": section})
        latch = Latch(World(config))
        emulator = GripperBoardEmulator(latch, config)
        emulator.start()
        noticed = Noticed()
        board = GripperBoard(section, noticed.take)

        async def run() -> None:
            while True:
                await asyncio.sleep(0.001)
                emulator.advance(TICK_S)

        running = asyncio.create_task(run())
        try:
            yield Bench(board, emulator, latch, noticed)
        finally:
            await board.close()
            running.cancel()
            with suppress(asyncio.CancelledError):
                await running
            emulator.stop()


def test_it_tells_who_it_is_and_what_its_latch_does() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            assert (await cell.board.connect()).serial_number == SERIAL_NUMBER
            state = await cell.board.state()
            assert (state.told_open, state.confirmed, state.moving) == (False, False, False)
            cell.latch.command(high=True)
            state = await cell.board.state()
            assert (state.told_open, state.moving) == (True, True)
            cell.run_latch(0.4)
            cell.latch.command(high=False)
            cell.run_latch(0.4)
            state = await cell.board.state()
            assert (state.told_open, state.confirmed, state.cycles) == (False, True, 1)

    asyncio.run(scenario())


@pytest.mark.parametrize("setting", RANGES, ids=lambda setting: setting.name)
def test_a_calibration_is_taken_within_its_range_and_counts_at_the_next_travel(
    setting: Command,
) -> None:
    async def scenario() -> None:
        least, most, _ = RANGES[setting]
        register = Register[setting.name]
        async with bench() as cell:
            for value in (least, most):
                await cell.board.calibrate(setting, value)
                assert (await cell.board.registers())[register] == value
            for value in (least - 1, most + 1):
                with pytest.raises(UsageError, match=f"must be {least} to {most}"):
                    await cell.board.calibrate(setting, value)
            assert (await cell.board.registers())[register] == most

    asyncio.run(scenario())


def test_two_pulses_between_which_the_latch_would_not_turn_are_refused() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            await cell.board.calibrate(Command.LATCH_PULSE, 1800)
            await cell.board.calibrate(Command.UNLATCH_PULSE, 1600)
            with pytest.raises(UsageError, match=r"unlatch_pulse = 1601 us: .* is 1800 us"):
                await cell.board.calibrate(Command.UNLATCH_PULSE, 1601)
            with pytest.raises(UsageError, match="would not turn"):
                await cell.board.calibrate(Command.LATCH_PULSE, 1600)
            registers = await cell.board.registers()
            assert registers[Register.LATCH_PULSE] == 1800
            assert registers[Register.UNLATCH_PULSE] == 1600

    asyncio.run(scenario())


def test_no_line_moves_the_latch_and_none_calibrates_a_moving_one() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            for act in (cell.board.keep, cell.board.clear, cell.board.self_test):
                await act()
            await cell.board.calibrate(Command.UNLATCH_PULSE, 1200)
            assert cell.latch.closed
            cell.latch.command(high=True)
            with pytest.raises(RefusedError, match="latch moves"):
                await cell.board.calibrate(Command.TRAVEL, 400)
            with pytest.raises(RefusedError, match="latch moves"):
                await cell.board.keep()

    asyncio.run(scenario())


def test_what_is_kept_outlives_a_reset_and_a_damaged_record_is_told() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            await cell.board.calibrate(Command.TRAVEL, 500)
            cell.emulator.inject("reset", cause="brownout")
            registers = await cell.board.registers()
            assert registers[Register.TRAVEL] == TRAVEL_MS
            await cell.board.calibrate(Command.TRAVEL, 500)
            await cell.board.keep()
            cell.emulator.inject("reset", cause="brownout")
            registers = await cell.board.registers()
            assert registers[Register.TRAVEL] == 500
            assert registers[Register.BROWNOUT_RESETS] == 2
            cell.emulator.inject("store_damaged")
            assert await cell.board.self_test() == SelfTest.RECORD
            assert not (await cell.board.state()).default_calibration
            cell.emulator.inject("reset")
            assert (await cell.board.state()).default_calibration
            assert (await cell.board.registers())[Register.LATCH_PULSE] == LATCH_PULSE_US

    asyncio.run(scenario())


def test_a_reset_is_told_by_its_banner_at_once() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            await cell.board.state()
            cell.emulator.inject("reset", cause="watchdog")
            await cell.noticed.wait()
            assert cell.noticed.causes == [ResetCause.WATCHDOG]
            await cell.board.state()
            assert cell.board.resets == 1

    asyncio.run(scenario())


def test_a_reset_whose_banner_is_lost_is_noticed_at_the_next_line() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            await cell.board.state()
            cell.emulator.inject("lost_replies")
            cell.emulator.inject("reset")
            await cell.board.state()
            assert cell.noticed.causes == [None]

    asyncio.run(scenario())


@pytest.mark.parametrize("reset", [True, False])
def test_a_board_that_was_away_says_whether_it_was_reset_meanwhile(reset: bool) -> None:
    async def scenario() -> None:
        async with bench() as cell:
            await cell.board.state()
            cell.emulator.inject("unplugged" if reset else "silent")
            with pytest.raises(BoardLostError):
                await cell.board.state()
            cell.emulator.clear("unplugged" if reset else "silent")
            await cell.board.state()
            assert cell.noticed.causes == ([None] if reset else [])

    asyncio.run(scenario())


def test_the_conveyors_board_on_this_port_is_refused_with_what_to_do() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            cell.emulator.inject("wrong_role", role="conveyor")
            with pytest.raises(
                BoardMismatchError, match=r"gripper\.port and feeder\.port are swapped"
            ):
                await cell.board.state()

    asyncio.run(scenario())


def test_no_old_line_is_obeyed_in_noise() -> None:
    async def scenario() -> None:
        async with bench(reply_timeout_s=0.02) as cell:
            await cell.board.connect()
            cell.emulator.inject("noise", share=0.15, delay_s=0.05)
            for value in range(1500, 1550):
                with suppress(BoardLostError):
                    await cell.board.calibrate(Command.LATCH_PULSE, value)
                    told = cell.emulator.truth()["calibration"]["latch_pulse"]
                    assert told == value, "an old line was obeyed"
            cell.emulator.clear("noise")
            await cell.board.calibrate(Command.LATCH_PULSE, 1200)

    asyncio.run(scenario())
