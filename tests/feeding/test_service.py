"""The belt service over the real driver and the emulated board."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from typing import Any

import pytest

from cellctl.boards.constants import FIRMWARE_VERSION, BoardRole
from cellctl.errors import CellFault
from cellctl.feeding.inventory import Counts, Move
from cellctl.feeding.service import BeltActivity, BeltService
from cellctl.messages import ConveyorData
from tests.feeding.bench import PITCH_M, Bench, bench


@dataclass
class Served:
    """A service on the bench, and all that it published."""

    bench: Bench
    service: BeltService
    counts: Counts
    views: list[ConveyorData]

    def activities(self) -> list[str]:
        """What was published, without repetitions of the activity."""
        found: list[str] = []
        for view in self.views:
            if not found or found[-1] != view.activity:
                found.append(view.activity)
        return found


@asynccontextmanager
async def served(
    parts: int = 3, retries: int = 1, reconnect_timeout_s: float = 0.0, **feeder: Any
) -> AsyncIterator[Served]:
    async with bench(parts=parts, **feeder) as cell:
        views: list[ConveyorData] = []
        service = BeltService(
            cell.conveyor,
            retries,
            lambda: own.counts.belt,
            views.append,
            reconnect_timeout_s=reconnect_timeout_s,
        )
        own = Served(cell, service, Counts(belt=parts), views)
        try:
            yield own
        finally:
            await service.close()
        names = {task.get_name() for task in asyncio.all_tasks()}
        assert not [name for name in names if name.startswith("belt")]


def test_a_part_is_requested_awaited_and_shown() -> None:
    async def scenario() -> None:
        async with served() as cell:
            await cell.service.connect()
            cell.service.request_part()
            near: list[str] = []
            await cell.service.part_ready(lambda: near.append(cell.service.view().activity))
            assert cell.service.ready
            assert len(near) == 1
            assert cell.activities() == [
                BeltActivity.IDLE,
                BeltActivity.INDEXING,
                BeltActivity.PRESENTING,
                BeltActivity.READY,
            ]
            assert cell.service.view().connected
            assert cell.service.view().part_present

    asyncio.run(scenario())


def test_the_next_part_comes_while_nobody_waits() -> None:
    async def scenario() -> None:
        async with served() as cell:
            cell.service.request_part()
            await cell.service.part_ready()
            assert (await cell.service.state()).part_present
            assert cell.service.view().activity == BeltActivity.READY
            cell.bench.world.take()
            cell.counts = cell.counts.after(Move.PICK)
            assert not (await cell.service.state()).part_present
            assert not cell.service.ready
            cell.service.request_part()
            await cell.bench.until(lambda: cell.service.ready)
            await cell.service.part_ready()
            assert cell.bench.world.travel_m == pytest.approx(2 * PITCH_M, abs=0.002)

    asyncio.run(scenario())


def test_who_stops_waiting_does_not_stop_the_belt() -> None:
    async def scenario() -> None:
        async with served() as cell:
            cell.service.request_part()
            waiting = asyncio.create_task(cell.service.part_ready())
            await cell.bench.indexing_at(0.03)
            waiting.cancel()
            with pytest.raises(asyncio.CancelledError):
                await waiting
            cell.service.request_part()  # the request under way stands
            await cell.service.part_ready()
            assert cell.bench.emulator.truth().motions == 1

    asyncio.run(scenario())


@pytest.mark.parametrize(("counted", "code"), [(0, "belt_empty"), (3, "belt_jam")])
def test_the_inventory_tells_empty_from_jammed(counted: int, code: str) -> None:
    async def scenario() -> None:
        async with served(parts=0) as cell:
            cell.counts = Counts(belt=counted)
            cell.service.request_part()
            with pytest.raises(CellFault) as caught:
                await cell.service.part_ready()
            assert caught.value.code == code
            assert cell.service.view().activity == BeltActivity.FAULT
            # An empty belt is not tried again; a jam is, once.
            assert cell.bench.emulator.truth().motions == (1 if code == "belt_empty" else 2)

    asyncio.run(scenario())


def test_a_jam_that_frees_itself_is_no_fault() -> None:
    async def scenario() -> None:
        async with served() as cell:
            cell.bench.emulator.inject("jam")
            cell.service.request_part()
            await cell.bench.until(lambda: cell.bench.emulator.truth().travel_m > 0.1)
            cell.bench.emulator.clear("jam")
            await cell.service.part_ready()
            assert BeltActivity.FAULT not in cell.activities()

    asyncio.run(scenario())


def test_a_fault_that_nobody_waits_for_is_shown_and_the_next_request_tries_anew() -> None:
    async def scenario() -> None:
        async with served(retries=0) as cell:
            cell.bench.emulator.inject("stall")
            cell.service.request_part()
            await cell.bench.until(lambda: cell.service.view().activity == BeltActivity.FAULT)
            with pytest.raises(CellFault) as caught:
                await cell.service.part_ready()
            assert caught.value.code == "belt_jam"
            cell.bench.emulator.clear("stall")
            cell.service.request_part()
            await cell.service.part_ready()

    asyncio.run(scenario())


def test_a_lost_board_is_shown_and_recovered_once_it_answers() -> None:
    async def scenario() -> None:
        async with served(reply_timeout_s=0.1) as cell:
            await cell.service.connect()
            cell.bench.emulator.inject("unplugged")
            cell.service.request_part()
            with pytest.raises(CellFault) as caught:
                await cell.service.part_ready()
            assert caught.value.code == "belt_lost"
            assert not cell.service.view().connected
            with pytest.raises(CellFault):
                await cell.service.recover()
            cell.bench.emulator.clear("unplugged")
            await cell.service.recover()
            view = cell.service.view()
            assert (view.connected, view.activity) == (True, BeltActivity.IDLE)
            assert view.board is not None
            assert view.board.firmware_version == FIRMWARE_VERSION[BoardRole.CONVEYOR]
            cell.service.request_part()
            await cell.service.part_ready()

    asyncio.run(scenario())


def test_a_link_that_is_lost_for_a_moment_is_no_fault() -> None:
    async def scenario() -> None:
        async with served(retries=5, reply_timeout_s=0.1) as cell:
            cell.service.request_part()
            await cell.bench.indexing_at(0.03)
            cell.bench.emulator.inject("silent")
            await cell.bench.at_rest()
            cell.bench.emulator.clear("silent")
            await cell.service.part_ready()
            assert cell.bench.world.travel_m == pytest.approx(PITCH_M, abs=0.002)

    asyncio.run(scenario())


def test_halt_ends_the_request_and_the_belt_stands() -> None:
    async def scenario() -> None:
        async with served() as cell:
            cell.service.request_part()
            waiting = asyncio.create_task(cell.service.part_ready())
            await cell.bench.indexing_at(0.03)
            await cell.service.halt()
            assert not cell.bench.emulator.truth().moving
            assert cell.bench.world.travel_m < 0.09
            await asyncio.wait({waiting})
            assert waiting.cancelled()
            assert cell.service.view().activity == BeltActivity.IDLE
            cell.service.request_part()
            await cell.service.part_ready()
            assert cell.bench.world.travel_m == pytest.approx(PITCH_M, abs=0.002)

    asyncio.run(scenario())


def test_halt_does_not_raise_for_a_board_that_is_gone() -> None:
    async def scenario() -> None:
        async with served(reply_timeout_s=0.1) as cell:
            await cell.service.connect()
            cell.bench.emulator.inject("silent")
            await cell.service.halt()
            assert not cell.service.view().connected

    asyncio.run(scenario())


def test_close_in_mid_index_leaves_no_task_and_a_belt_that_stands() -> None:
    async def scenario() -> None:
        async with served() as cell:
            cell.service.request_part()
            await cell.bench.indexing_at(0.03)
            await cell.service.close()
            await cell.bench.at_rest()
            assert cell.bench.world.travel_m < 0.09
            assert not cell.service.view().connected
            await cell.service.close()

    asyncio.run(scenario())


@pytest.mark.parametrize("trouble", ["unplugged", "silent"])
def test_a_board_that_is_away_for_a_moment_brings_its_part_all_the_same(trouble: str) -> None:
    async def scenario() -> None:
        async with served(retries=0, reconnect_timeout_s=10.0, reply_timeout_s=0.1) as cell:
            await cell.service.connect()
            cell.service.request_part()
            await cell.bench.indexing_at(0.04)
            cell.bench.emulator.inject(trouble)
            await cell.bench.at_rest()
            cell.bench.emulator.clear(trouble)
            await cell.service.part_ready()
            assert cell.bench.world.travel_m == pytest.approx(PITCH_M, abs=0.002)
            assert BeltActivity.FAULT not in cell.activities()

    asyncio.run(scenario())


def test_an_idle_board_that_is_lost_is_shown_and_found_again_by_itself() -> None:
    async def scenario() -> None:
        async with served(reply_timeout_s=0.1) as cell:
            await cell.service.connect()
            watching = asyncio.create_task(cell.service.watch(lambda: True), name="watch")
            cell.bench.emulator.inject("unplugged")
            await cell.bench.until(lambda: not cell.service.view().connected)
            cell.bench.emulator.clear("unplugged")
            await cell.bench.until(lambda: cell.service.view().connected)
            assert cell.bench.conveyor.resets == 1  # noticed, though nobody heard the banner
            watching.cancel()
            await asyncio.gather(watching, return_exceptions=True)

    asyncio.run(scenario())


def test_a_part_that_vanishes_before_the_arm_comes_is_not_called_ready() -> None:
    async def scenario() -> None:
        async with bench(parts=1) as cell:
            cell.emulator.inject("sensor_blocked", reads=True)

            def snatch(view: ConveyorData) -> None:
                if view.activity == BeltActivity.PRESENTING:
                    cell.emulator.clear("sensor_blocked")

            service = BeltService(cell.conveyor, 0, lambda: 1, snatch)
            service.request_part()
            with pytest.raises(CellFault, match="gone again") as caught:
                await service.part_ready()
            assert caught.value.code == "belt_jam"
            await service.close()

    asyncio.run(scenario())


def test_room_is_made_once_for_each_part_that_comes_back() -> None:
    async def scenario() -> None:
        async with served() as cell:
            cell.service.request_part()
            await cell.service.part_ready()
            travelled_m = cell.bench.world.travel_m
            cell.service.request_room()
            await cell.service.room_ready()
            assert not cell.bench.world.part_at_pick()
            gone_m = travelled_m - cell.bench.world.travel_m
            assert PITCH_M <= gone_m <= 1.2 * PITCH_M
            assert BeltActivity.MAKING_ROOM in cell.activities()
            cell.service.request_room()
            await cell.service.room_ready()
            assert travelled_m - cell.bench.world.travel_m == pytest.approx(gone_m)
            cell.service.room_was_used()
            assert cell.service.ready
            cell.service.request_room()
            await cell.service.room_ready()
            assert travelled_m - cell.bench.world.travel_m == pytest.approx(2 * gone_m)

    asyncio.run(scenario())


def test_who_asks_for_a_part_while_room_is_made_gets_it() -> None:
    async def scenario() -> None:
        async with served() as cell:
            cell.service.request_part()
            await cell.service.part_ready()
            cell.service.request_room()
            await cell.bench.until(lambda: cell.service.view().activity == "making_room")
            cell.service.request_part()
            await cell.service.part_ready()
            assert cell.service.ready

    asyncio.run(scenario())


def test_a_belt_that_does_not_go_back_is_a_jam_and_can_be_asked_again() -> None:
    async def scenario() -> None:
        async with served() as cell:
            cell.service.request_part()
            await cell.service.part_ready()
            cell.bench.emulator.inject("stall")
            cell.service.request_room()
            with pytest.raises(CellFault, match="did not move") as raised:
                await cell.service.room_ready()
            assert raised.value.code == "belt_jam"
            assert cell.service.view().activity == BeltActivity.FAULT
            cell.bench.emulator.clear("stall")
            await cell.service.recover()
            cell.service.request_room()
            await cell.service.room_ready()
            assert not cell.bench.world.part_at_pick()

    asyncio.run(scenario())
