"""The conveyor's driver over a line that loses, doubles, delays, garbles and cuts its frames.

The world counts: every part is advanced once, by one pitch, and none is passed over or lost.
"""

from __future__ import annotations

import asyncio

import pytest

from cellctl.errors import CellFault
from tests.feeding.bench import Bench, bench

PITCH_M = 0.03
"""Short, for many indexes in little time."""
STATES_A_PART = 9
"""Commands between two indexes."""
DELAY_S = 0.3
"""Longest delay of a line (cell time)."""
TOLERANCE_M = 0.002


async def persist(cell: Bench, *, present: bool) -> None:
    """Give a command until it is carried out; a line this bad is sometimes lost for a while."""
    while True:
        try:
            await (cell.conveyor.present() if present else cell.conveyor.state())
        except CellFault as fault:
            if fault.code != "belt_lost":
                raise
        else:
            return


async def through_noise(commands: int, share: float) -> Bench:
    """Bring parts one after another, with the world looked at after each."""
    parts = commands // (STATES_A_PART + 1)
    async with bench(parts, PITCH_M, reply_timeout_s=0.03, index_timeout_s=60.0) as cell:
        await cell.conveyor.connect()
        cell.emulator.inject("noise", share=share, delay_s=DELAY_S)
        for number in range(1, parts + 1):
            await persist(cell, present=True)
            assert cell.world.part_at_pick(), "no part came"
            # Nothing holds the belt now: a line of the index that comes late would move it.
            cell.world.take()
            for asked in range(STATES_A_PART):
                if asked == number % 2:  # before any newer line, or after one
                    await cell.clock.sleep(DELAY_S)
                await persist(cell, present=False)
            assert cell.world.travel_m == pytest.approx(number * PITCH_M, abs=TOLERANCE_M)
        assert not cell.world.ahead_m, "a part was left behind"
        truth = cell.emulator.truth()
        assert truth.indexes == parts
        assert truth.travel_m == pytest.approx(parts * PITCH_M, abs=TOLERANCE_M)
        assert truth.resets == 0
        return cell


def test_hundreds_of_commands_through_a_bad_line_bring_every_part_once() -> None:
    asyncio.run(through_noise(200, 0.3))


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_ten_thousand_commands_through_a_bad_line_bring_every_part_once() -> None:
    asyncio.run(through_noise(10_000, 0.3))
