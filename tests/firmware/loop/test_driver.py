"""The host's driver with either kind of board, through real pyserial on a real pseudo-terminal."""

from __future__ import annotations

import asyncio

import pytest

from cellctl.errors import CellFault
from tests.feeding.bench import PITCH_M, bench

pytestmark = pytest.mark.wire
KINDS = pytest.mark.parametrize("kind", ["plain", "elf"])
TOLERANCE_M = 0.002


@KINDS
@pytest.mark.parametrize("fault", ["lost_replies", "corrupted_replies"])
def test_lost_and_damaged_replies_never_advance_twice(kind: str, fault: str) -> None:
    async def scenario() -> None:
        async with bench(parts=3, kind=kind) as cell:
            await cell.conveyor.connect()
            for number in (1, 2):
                cell.emulator.inject(fault, count=2)
                await cell.conveyor.present()
                assert (await cell.conveyor.state()).indexes == number
                assert cell.world.travel_m == pytest.approx(number * PITCH_M, abs=TOLERANCE_M)
                await cell.take()
            assert cell.emulator.truth().motions == 2

    asyncio.run(scenario())


@KINDS
def test_nothing_came_is_told_and_can_be_tried_again(kind: str) -> None:
    async def scenario() -> None:
        async with bench(parts=0, kind=kind) as cell:
            with pytest.raises(CellFault) as caught:
                await cell.conveyor.present()
            assert caught.value.code == "belt_empty"
            cell.world.ahead_m = [PITCH_M]
            await cell.conveyor.present()
            assert cell.world.part_at_pick()

    asyncio.run(scenario())


@KINDS
def test_a_reset_in_mid_index_is_made_good(kind: str) -> None:
    async def scenario() -> None:
        async with bench(kind=kind) as cell:
            await cell.conveyor.connect()
            cell.emulator.inject("reset", cause="brownout", after_m=0.04)
            await cell.conveyor.present()
            assert cell.world.part_at_pick()
            assert cell.world.travel_m == pytest.approx(PITCH_M, abs=TOLERANCE_M)
            assert cell.emulator.truth().resets == 1

    asyncio.run(scenario())


@KINDS
def test_a_port_that_vanishes_is_used_again_when_it_is_back(kind: str) -> None:
    async def scenario() -> None:
        async with bench(kind=kind) as cell:
            await cell.conveyor.connect()
            cell.emulator.inject("unplugged")
            with pytest.raises(CellFault):
                await cell.conveyor.present()
            cell.emulator.clear("unplugged")
            await cell.conveyor.present()
            assert cell.world.part_at_pick()

    asyncio.run(scenario())
