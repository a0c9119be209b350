"""Placing that feels: a seat under the part before it is let go, and a gripper that is free after.

Both are felt at rest, a fraction of a millimetre below and above the seat, so that no delay of a
network or a busy computer counts: the arm is as far as it goes, and then the force is read.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from statistics import fmean
from typing import TYPE_CHECKING

from cellctl.assembling.poses import to_matrix
from cellctl.assembly import Cell
from cellctl.errors import CellFault

if TYPE_CHECKING:
    from cellctl.clock import Clock
    from cellctl.config import CellConfig
    from cellctl.control.moving import ArmAndLatch, Plan

_READINGS = {"ur10e": 3, "ur10": 8}
"""How many states a force is averaged over: a sensor is quieter than currents of joints."""
_POLL_S = 0.004

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
        self._upward = to_matrix(config.base.frame)[2, :3]
        self.felt_s = 0.0
        """What feeling has taken in all (cell time)."""

    async def seat(self, cell: Cell, standing: frozenset[Cell], travel: Travel) -> None:
        """Feel whether the part that is held is pressed on what carries it, where a column down to
        the floor does; no other joints bear being pressed on.

        Raises:
            CellFault: ``not_seated``: there is nothing under it; or of the arm.
        """
        if not self._hands.routes.presses(cell, standing):
            return
        began_s = self._clock.now_s()
        # The way to the cell ends there already, unless it was broken off.
        await self._go(cell, -self._robot.touch_depth_m, travel, carrying=True)
        pressed_n = await self._upward_n()
        self.felt_s += self._clock.now_s() - began_s
        if pressed_n < self._robot.touch_force_n:
            raise CellFault(
                "not_seated",
                f"{self._robot.touch_depth_m * 1000:.1f} mm below its seat at {list(cell)} the "
                f"part is pressed with {pressed_n:.1f} N; {self._robot.touch_force_n:g} N are due.",
            )

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
        held_n = -await self._upward_n()
        if held_n > self._robot.touch_force_n:
            raise CellFault(
                "part_stuck",
                f"The part at {list(cell)} holds the gripper with {held_n:.1f} N although the "
                "latch is open.",
            )

    async def _go(self, cell: Cell, above_m: float, travel: Travel, *, carrying: bool) -> None:
        await travel(
            lambda start, placed: self._hands.routes.near_seat(
                cell, above_m, placed, start, carrying=carrying
            )
        )

    async def _upward_n(self) -> float:
        """The mean of the next readings, along the vertical."""
        readings: list[float] = []
        told_s = -1.0
        while len(readings) < _READINGS[self._robot.model]:
            state = self._hands.state()
            if state.robot_time_s != told_s:
                told_s = state.robot_time_s
                readings.append(float(self._upward @ state.tcp_force_n))
            await self._clock.sleep(_POLL_S)
        return fmean(readings)
