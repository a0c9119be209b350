"""The driver against the emulated board, through real pyserial on a real pseudo-terminal."""

from __future__ import annotations

import asyncio
import time
from pathlib import Path

import pytest

from cellctl.boards.constants import (
    COMMAND_LIMIT,
    PROTOCOL_VERSION,
    TRAVEL_LIMIT_PITCHES,
    Command,
)
from cellctl.boards.line import (
    CommandLine,
    encode_command,
)
from cellctl.boards.link import SerialLink
from cellctl.boards.session import SENDS
from cellctl.clock import SystemClock
from cellctl.errors import CellFault
from cellctl.feeding.conveyor import Conveyor
from cellctl.sim.conveyor import SERIAL_NUMBER
from tests.feeding.bench import PITCH_M, Bench, bench, cell_config

TRAVEL_TOLERANCE_M = 0.002


def test_connect_tells_who_answers_and_may_be_repeated() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            first = await cell.conveyor.connect()
            assert first.role == "conveyor"
            assert first.serial_number == SERIAL_NUMBER
            assert first.protocol_version == PROTOCOL_VERSION
            assert await cell.conveyor.connect() == first

    asyncio.run(scenario())


def test_parts_come_one_after_another() -> None:
    async def scenario() -> None:
        async with bench(parts=3) as cell:
            for number in range(1, 4):
                await cell.conveyor.present()
                state = await cell.conveyor.state()
                assert state.part_present
                assert not state.moving
                assert state.indexes == number
                assert cell.world.travel_m == pytest.approx(
                    number * PITCH_M, abs=TRAVEL_TOLERANCE_M
                )
                cell.world.take()
            assert not (await cell.conveyor.state()).part_present

    asyncio.run(scenario())


@pytest.mark.parametrize("pitch_m", [0.02, 0.25])
def test_room_is_made_for_parts_of_every_size(pitch_m: float) -> None:
    async def scenario() -> None:
        async with bench(parts=1, pitch_m=pitch_m) as cell:
            await cell.conveyor.present()
            await cell.conveyor.make_room()
            assert cell.world.ahead_m[0] >= pitch_m

    asyncio.run(scenario())


def test_a_part_that_lies_there_is_not_moved() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            await cell.conveyor.present()
            travel_m = cell.world.travel_m
            await cell.conveyor.present()
            assert cell.world.travel_m == travel_m
            assert cell.emulator.truth().motions == 1

    asyncio.run(scenario())


@pytest.mark.parametrize("count", [1, 2, 6])
@pytest.mark.parametrize("fault", ["lost_replies", "corrupted_replies"])
def test_a_lost_or_damaged_reply_never_advances_twice(fault: str, count: int) -> None:
    async def scenario() -> None:
        async with bench(parts=3) as cell:
            await cell.conveyor.connect()
            for number in range(1, 3):
                cell.emulator.inject(fault, count=count)
                await cell.conveyor.present()
                assert cell.emulator.truth().motions == number
                assert cell.world.travel_m == pytest.approx(
                    number * PITCH_M, abs=TRAVEL_TOLERANCE_M
                )
                cell.world.take()

    asyncio.run(scenario())


def test_the_reply_that_ends_an_index_may_get_lost() -> None:
    async def scenario() -> None:
        async with bench(parts=2) as cell:
            presenting = asyncio.create_task(cell.conveyor.present())
            await cell.indexing_at(0.08)
            cell.emulator.inject("lost_replies", count=6)
            await presenting
            truth = cell.emulator.truth()
            assert "lost_replies" not in truth.faults, "the fault did not strike"
            assert truth.motions == truth.indexes == 1
            assert cell.world.travel_m == pytest.approx(PITCH_M, abs=TRAVEL_TOLERANCE_M)

    asyncio.run(scenario())


def test_garbage_on_the_line_does_no_harm() -> None:
    async def scenario() -> None:
        async with bench(parts=2) as cell:
            cell.emulator.inject("garbage", count=100)
            for _ in range(2):
                await cell.conveyor.present()
                cell.world.take()
            assert cell.emulator.truth().motions == 2

    asyncio.run(scenario())


def test_nothing_came_is_told_after_the_whole_travel_and_can_be_tried_again() -> None:
    async def scenario() -> None:
        async with bench(parts=0) as cell:
            with pytest.raises(CellFault, match="no part came") as caught:
                await cell.conveyor.present()
            assert caught.value.code == "belt_empty"
            assert cell.world.travel_m == pytest.approx(
                TRAVEL_LIMIT_PITCHES * PITCH_M, abs=TRAVEL_TOLERANCE_M
            )
            cell.world.ahead_m.append(0.05)
            await cell.conveyor.present()
            assert cell.emulator.truth().error is None

    asyncio.run(scenario())


def test_one_missing_part_is_bridged() -> None:
    async def scenario() -> None:
        async with bench(parts=3) as cell:
            del cell.world.ahead_m[0]
            await cell.conveyor.present()
            assert cell.world.travel_m == pytest.approx(2 * PITCH_M, abs=TRAVEL_TOLERANCE_M)

    asyncio.run(scenario())


def test_a_stalled_motor_is_a_jam() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            cell.emulator.inject("stall")
            with pytest.raises(CellFault) as caught:
                await cell.conveyor.present()
            assert caught.value.code == "belt_jam"
            cell.emulator.clear("stall")
            await cell.conveyor.present()

    asyncio.run(scenario())


def test_an_index_that_takes_too_long_is_halted() -> None:
    async def scenario() -> None:
        async with bench(index_timeout_s=0.5) as cell:
            with pytest.raises(CellFault, match=r"0\.5 s") as caught:
                await cell.conveyor.present()
            assert caught.value.code == "belt_jam"
            assert not cell.emulator.truth().moving
            assert cell.world.travel_m < PITCH_M

    asyncio.run(scenario())


def test_a_silent_board_is_lost_in_bounded_time_and_found_again() -> None:
    async def scenario() -> None:
        async with bench(reply_timeout_s=0.1) as cell:
            await cell.conveyor.connect()
            cell.emulator.inject("silent")
            began_s = time.monotonic()
            with pytest.raises(CellFault, match="no answer to 3 lines") as caught:
                await cell.conveyor.state()
            assert caught.value.code == "belt_lost"
            assert SENDS * 0.1 <= time.monotonic() - began_s < 30.0
            cell.emulator.clear("silent")
            assert not (await cell.conveyor.state()).part_present

    asyncio.run(scenario())


def test_a_board_that_falls_silent_in_mid_index_is_lost_and_its_belt_stops() -> None:
    async def scenario() -> None:
        async with bench(reply_timeout_s=0.1) as cell:
            presenting = asyncio.create_task(cell.conveyor.present())
            await cell.indexing_at(0.03)
            cell.emulator.inject("silent")
            with pytest.raises(CellFault) as caught:
                await presenting
            assert caught.value.code == "belt_lost"
            await cell.at_rest()
            assert cell.world.travel_m < 0.06
            cell.emulator.clear("silent")
            await cell.conveyor.present()
            assert cell.world.travel_m == pytest.approx(PITCH_M, abs=TRAVEL_TOLERANCE_M)

    asyncio.run(scenario())


@pytest.mark.parametrize("banner_arrives", [True, False])
def test_a_reset_in_mid_index_is_noticed_and_the_part_still_comes(banner_arrives: bool) -> None:
    async def scenario() -> None:
        async with bench() as cell:
            await cell.conveyor.connect()
            cell.emulator.inject("reset", cause="watchdog", after_m=0.04)
            presenting = asyncio.create_task(cell.conveyor.present())
            if not banner_arrives:
                await cell.indexing_at(0.02)
                cell.emulator.inject("lost_replies", count=8)
            await presenting
            assert cell.conveyor.resets == cell.emulator.truth().resets == 1
            assert cell.world.travel_m == pytest.approx(PITCH_M, abs=TRAVEL_TOLERANCE_M)

    asyncio.run(scenario())


def test_another_serial_number_than_the_one_asked_for_is_refused() -> None:
    async def scenario() -> None:
        async with bench(serial_number="1E9522FF") as cell:
            with pytest.raises(
                CellFault, match=r"feeder\.serial_number asks for 1E9522FF"
            ) as caught:
                await cell.conveyor.connect()
            assert caught.value.code == "belt_mismatch"
        async with bench(serial_number=SERIAL_NUMBER) as cell:
            await cell.conveyor.connect()

    asyncio.run(scenario())


def test_a_reset_while_idle_is_noticed() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            await cell.conveyor.connect()
            cell.emulator.inject("reset")
            assert not (await cell.conveyor.state()).moving
            assert cell.conveyor.resets == 1

    asyncio.run(scenario())


@pytest.mark.parametrize(
    ("fault", "arguments", "said"),
    [
        ("wrong_role", {"role": "gripper"}, "feeder.port and gripper.port are swapped"),
        ("wrong_role", {"role": "kettle"}, "says it is a kettle.*correct feeder.port"),
        ("wrong_protocol", {"version": 9}, "speaks protocol version 9.*make flash-conveyor"),
        ("old_firmware", {"version": "1.9.9"}, "runs firmware 1.9.9.*make flash-conveyor"),
    ],
)
def test_another_board_on_the_port_is_refused(
    fault: str, arguments: dict[str, str | int], said: str
) -> None:
    async def scenario() -> None:
        async with bench() as cell:
            cell.emulator.inject(fault, **arguments)
            for act in (cell.conveyor.connect, cell.conveyor.present):
                with pytest.raises(CellFault, match=said) as caught:
                    await act()
                assert caught.value.code == "belt_mismatch"
            assert cell.emulator.truth().motions == 0
            cell.emulator.clear(fault)
            await cell.conveyor.present()

    asyncio.run(scenario())


def test_a_port_that_vanishes_is_lost_and_used_again_when_it_is_back() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            presenting = asyncio.create_task(cell.conveyor.present())
            await cell.indexing_at(0.03)
            cell.emulator.inject("unplugged")
            with pytest.raises(CellFault, match="has gone") as caught:
                await presenting
            assert caught.value.code == "belt_lost"
            with pytest.raises(CellFault, match="cannot be opened"):
                await cell.conveyor.state()
            cell.emulator.clear("unplugged")
            await cell.conveyor.present()
            assert cell.world.travel_m == pytest.approx(PITCH_M, abs=TRAVEL_TOLERANCE_M)

    asyncio.run(scenario())


def test_a_port_that_is_no_serial_port_or_does_not_exist_is_named(tmp_path: Path) -> None:
    file = tmp_path / "file"
    file.write_text("not a port")

    async def scenario(port: Path) -> None:
        conveyor = Conveyor(cell_config(port).feeder, PITCH_M, SystemClock())
        with pytest.raises(CellFault, match=port.name) as caught:
            await conveyor.connect()
        assert caught.value.code == "belt_lost"
        await conveyor.halt()  # nobody to tell
        await conveyor.close()

    for port in (file, tmp_path / "absent"):
        asyncio.run(scenario(port))


def test_a_port_that_another_process_uses_is_refused() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            await cell.conveyor.connect()
            other = Conveyor(cell.config.feeder, PITCH_M, cell.clock)
            with pytest.raises(CellFault, match="exclusively lock"):
                await other.connect()
            await other.close()

    asyncio.run(scenario())


async def _stopped_early(cell: Bench) -> None:
    await cell.at_rest()
    assert 0.02 < cell.world.travel_m < 0.08
    await cell.conveyor.present()
    assert cell.world.travel_m == pytest.approx(PITCH_M, abs=TRAVEL_TOLERANCE_M)


def test_cancelling_stops_the_belt_and_the_index_can_be_finished() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            presenting = asyncio.create_task(cell.conveyor.present())
            await cell.indexing_at(0.03)
            presenting.cancel()
            with pytest.raises(asyncio.CancelledError):
                await presenting
            await _stopped_early(cell)

    asyncio.run(scenario())


def test_halting_stops_the_belt_and_ends_the_index() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            presenting = asyncio.create_task(cell.conveyor.present())
            await cell.indexing_at(0.03)
            assert (await cell.conveyor.state()).moving
            await cell.conveyor.halt()
            assert presenting.cancelled()
            assert not cell.emulator.truth().moving
            await _stopped_early(cell)

    asyncio.run(scenario())


def test_closing_in_mid_index_stops_the_belt() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            presenting = asyncio.create_task(cell.conveyor.present())
            await cell.indexing_at(0.03)
            await cell.conveyor.close()
            assert presenting.cancelled()
            await _stopped_early(cell)

    asyncio.run(scenario())


def test_a_host_that_stalls_interrupts_the_index_and_then_finishes_it() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            presenting = asyncio.create_task(cell.conveyor.present())
            await cell.indexing_at(0.03)
            cell.emulator.advance(0.5)  # half a second in which the host gets no turn
            await presenting
            assert cell.emulator.truth().motions == 2
            assert cell.world.travel_m == pytest.approx(PITCH_M, abs=TRAVEL_TOLERANCE_M)

    asyncio.run(scenario())


def test_sending_never_blocks_even_when_nobody_reads() -> None:
    async def scenario() -> None:
        async with bench() as cell:
            link = await SerialLink.open(cell.config.feeder.port, cell.config.feeder.baud)
            frame = encode_command(CommandLine(0, Command.STATUS))
            assert len(frame) <= COMMAND_LIMIT
            began_s = time.monotonic()
            for _ in range(5_000):  # far more than a terminal's buffer, and no await between
                link.send(frame)
            assert time.monotonic() - began_s < 60.0
            link.close()

    asyncio.run(scenario())
