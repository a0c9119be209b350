"""Placing that feels: a seat under the part before it is let go, and a gripper that is free after.

Both are felt at rest, a fraction of a millimetre below and above the seat, so that no delay of a
network or a busy computer counts: the arm is as far as it goes, and then it is read what it feels
(``feeling``). What a part meets above its seat is felt on the way down, too.
"""

from __future__ import annotations

import asyncio
import math
from collections import deque
from collections.abc import Awaitable, Callable
from statistics import fmean
from typing import TYPE_CHECKING

from cellctl.assembly import Cell
from cellctl.control.feeling import feeling_of
from cellctl.errors import CellFault

if TYPE_CHECKING:
    from cellctl.clock import Clock
    from cellctl.config import CellConfig
    from cellctl.control.moving import ArmAndLatch, Plan

_POLL_S = 0.004
_NEAR_SEAT_M = 0.12
"""Within this of its seat a part may stand on something: a part that is where it should go is a
pitch high."""

Travel = Callable[["Plan"], Awaitable[None]]
"""Follows a checked route from where the arm is."""


Beside = Callable[[Awaitable[None]], Awaitable[None]]
"""Awaits what it is given, and may do something else meanwhile."""


async def alone(awaited: Awaitable[None]) -> None:
    """Await it, and do nothing else."""
    await awaited


class Touch:
    """What the arm feels where it places.

    Args:
        config: the cell; ``robot.touch_depth_m`` 0 feels nothing.
        clock: cell time.
        hands: the arm.
    """

    def __init__(self, config: CellConfig, clock: Clock, hands: ArmAndLatch) -> None:
        self._robot = config.robot
        self._clock = clock
        self._hands = hands
        self._feeling = feeling_of(config)
        self.felt_s = 0.0
        """What feeling has taken in all (cell time)."""

    async def met_early(self, move: asyncio.Task[None], cell: Cell) -> str:
        """Watch the way down to a cell until the movement ends, or the part meets something.

        Args:
            move: brings the part to its cell.
            cell: where it goes.

        Returns:
            What is felt then, in words; empty when it met nothing.
        """
        feeling = self._feeling
        seat = self._hands.routes.place_stance(cell).tcp_pose[:3]
        readings: deque[float] = deque(maxlen=feeling.moving)
        feeling.begin()
        read_s: float | None = None
        while not move.done():
            state = self._hands.state()
            if state.robot_time_s == read_s:
                await self._clock.sleep(_POLL_S)
                continue
            read_s = state.robot_time_s
            # Elsewhere the part hangs free, and whatever shakes it is no contact.
            if math.dist(state.tcp_pose[:3], seat) < _NEAR_SEAT_M:
                readings.append(feeling.upward(state) - feeling.slack(state))
                met = fmean(readings)
                if met > feeling.early and len(readings) == readings.maxlen:
                    return feeling.told(met)
            else:
                feeling.watch(state)
            await self._clock.sleep(_POLL_S)
        return ""

    async def seat(self, cell: Cell, standing: frozenset[Cell], travel: Travel) -> None:
        """Feel whether the part that is held is pressed on what carries it, where a column down to
        the floor does; no other joints bear being pressed on.

        Raises:
            CellFault: ``not_seated``: there is nothing under it; ``contact_early``: what is there
                stands too high; or of the arm.
        """
        if not self._hands.routes.presses(cell, standing):
            return
        began_s = self._clock.now_s()
        # The way to the cell ends there already, unless it was broken off.
        await self._go(cell, -self._robot.touch_depth_m, travel, carrying=True)
        pressed, feeling = await self._upward(), self._feeling
        self.felt_s += self._clock.now_s() - began_s
        if pressed > feeling.early:
            raise contact_early(cell, feeling.told(pressed))
        if pressed < feeling.touches:
            raise CellFault(
                "not_seated",
                f"{self._robot.touch_depth_m * 1000:.1f} mm below its seat at {list(cell)} the "
                f"part is {feeling.told(pressed)}; {feeling.amount(feeling.touches)} are due.",
            )

    async def stands(self, cell: Cell, standing: frozenset[Cell], travel: Travel) -> bool:
        """Whether a part that was let go stands. One on a column presses up on the open gripper,
        which is where the part was pressed on its seat. On any other nothing may press: there the
        latch closes once more, and the gripper says whether it has a part.

        Args:
            cell: where it is.
            standing: what stood before it.
            travel: follows a route.

        Raises:
            CellFault: of the arm or the gripper.
        """
        if not self._hands.routes.presses(cell, standing):
            return await self._hands.finds_part()
        began_s = self._clock.now_s()
        # It is there already, unless the letting go was broken off.
        await self._go(cell, -self._robot.touch_depth_m, travel, carrying=False)
        pressed = await self._upward()
        self.felt_s += self._clock.now_s() - began_s
        return pressed >= self._feeling.touches

    def freeing(self, cell: Cell) -> Plan | None:
        """The movement that feels whether a part that is let go is free; None where nothing is
        felt."""
        depth_m = self._robot.touch_depth_m
        if depth_m == 0.0:
            return None
        return lambda start, placed: self._hands.routes.near_seat(
            cell, depth_m, placed, start, carrying=False
        )

    async def free(self, cell: Cell, travel: Travel, beside: Beside = alone) -> None:
        """Rise a little from the part that was let go; back to its seat where it holds on.

        Args:
            cell: where it is.
            travel: follows a route.
            beside: what is done meanwhile.

        Raises:
            CellFault: ``part_stuck``; or of the arm.
        """
        if self._robot.touch_depth_m == 0.0:
            return
        began_s = self._clock.now_s()
        await self._go(cell, self._robot.touch_depth_m, travel, carrying=False)
        try:
            await beside(self._feel_free(cell))
        except CellFault as fault:
            if fault.code == "part_stuck":
                await self._go(cell, 0.0, travel, carrying=False)
            raise
        self.felt_s += self._clock.now_s() - began_s

    async def _feel_free(self, cell: Cell) -> None:
        felt = await self._upward()
        if -felt > self._feeling.touches:
            raise CellFault(
                "part_stuck",
                f"The gripper is {self._feeling.told(felt)} by the part at {list(cell)}, although "
                "the latch is open.",
            )

    async def _go(self, cell: Cell, above_m: float, travel: Travel, *, carrying: bool) -> None:
        await travel(
            lambda start, placed: self._hands.routes.near_seat(
                cell, above_m, placed, start, carrying=carrying
            )
        )

    async def _upward(self) -> float:
        """The mean of the next readings, along the vertical."""
        readings: list[float] = []
        told_s = -1.0
        while len(readings) < self._feeling.resting:
            state = self._hands.state()
            if state.robot_time_s != told_s:
                told_s = state.robot_time_s
                readings.append(self._feeling.upward(state))
            await self._clock.sleep(_POLL_S)
        return fmean(readings)


def contact_early(cell: Cell, felt: str) -> CellFault:
    """The part that goes to a cell has met something above its seat."""
    return CellFault("contact_early", f"At {list(cell)} it is {felt}.")
