"""What all physical acts use: checked movements, and a latch that moves only in place."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, NamedTuple

import structlog

from cellctl.assembling.arm import Switch
from cellctl.assembling.latch_gripper import STEADY_S
from cellctl.assembling.poses import distance
from cellctl.assembling.route import Route, RoutePlanner, Stance
from cellctl.assembling.travel import travel
from cellctl.assembly import Cell
from cellctl.control.recovery import left_station, stayed
from cellctl.errors import CellFault, PlanError

if TYPE_CHECKING:
    from cellctl.assembling.arm import Arm, ArmState
    from cellctl.assembling.gripper import Gripper
    from cellctl.clock import Clock
    from cellctl.config import CellConfig

_POLL_S = 0.02
_SAME_JOINTS_RAD = 0.002
_CLOSING_M = 0.001
"""So close to its part the open latch is told to close: it moves far less than it has play by the
time the gripper has its seat."""
_NEARLY_M = 0.12
"""So close to the station the arm takes a tenth of a second or two to arrive."""

log = structlog.get_logger(__name__)


Plan = Callable[[Stance, frozenset[Cell]], Route]
"""Makes a route from the arm's stance and what stands."""


class Ahead(NamedTuple):
    """A movement that comes after the next one."""

    key: str
    """What it is for; ``travel`` takes it up by this."""
    plan: Plan
    standing: frozenset[Cell]
    """Cells that will hold a part."""


class _Foreseen(NamedTuple):
    """A route that was planned before it is needed."""

    key: str
    start: Stance
    standing: frozenset[Cell]
    route: Route

    def fits(self, key: str, here: Stance, standing: frozenset[Cell]) -> bool:
        """Whether it is for this, and nothing has changed since."""
        if self.key != key or self.standing != standing:
            return False
        pairs = zip(here.joints_rad, self.start.joints_rad, strict=True)
        return max(abs(a - b) for a, b in pairs) < _SAME_JOINTS_RAD


class ArmAndLatch:
    """The arm with its gripper, moved by checked routes only.

    Args:
        config: the cell.
        clock: cell time.
        arm, gripper: the devices.
    """

    def __init__(self, config: CellConfig, clock: Clock, arm: Arm, gripper: Gripper) -> None:
        self._config = config
        self._clock = clock
        self.arm = arm
        self._gripper = gripper
        self.routes = RoutePlanner(config)
        self._opened = False
        """The gripper has confirmed that it is open since it last closed."""
        self._closing = False
        """It was told to close at the end of the last movement."""
        self._unproven = True
        """A latch that it confirms was not watched for longer than a fault could look like it."""
        self._foreseen: _Foreseen | None = None
        """What comes next, ready at the controller."""
        self._ahead: _Foreseen | None = None
        """What comes after that, only planned."""
        self.waited_for_routes_s = 0.0
        """How long the arm has stood in all because its route was not planned yet (cell time)."""
        self.waited_for_latch_s = 0.0
        """The same because the latch moved."""

    def state(self) -> ArmState:
        """The newest state.

        Raises:
            CellFault: ``robot_lost``: there is none.
        """
        state = self.arm.state()
        if state is None:
            raise CellFault("robot_lost")
        return state

    def stance(self) -> Stance:
        """Where the arm is, or is told to be where it presses on something.

        Raises:
            CellFault: ``robot_lost``.
        """
        state = self.state()
        off_m = math.hypot(*state.tcp_lag_m)
        # Further off, as after a stop, its target says nothing of where it is.
        pressing = off_m <= self._config.robot.early_lag_m
        return Stance(state.told_pose if pressing else state.tcp_pose, state.joints_rad)

    async def foreseeing(
        self,
        meanwhile: Awaitable[None],
        key: str,
        plan: Plan,
        standing: frozenset[Cell],
        ahead: Ahead | None = None,
    ) -> None:
        """Wait for something at rest, such as the latch, and have the next route ready at the
        controller meanwhile.

        Args:
            meanwhile: what is waited for.
            key: what the route is for; ``travel`` takes it up by this.
            plan: makes the route.
            standing: cells that will hold a part.
            ahead: the movement after it, which is only planned.

        Raises:
            CellFault: of what is waited for.
        """
        foresight = asyncio.create_task(self._foresee(key, plan, standing, ahead))
        try:
            await meanwhile
            began_s = self._clock.now_s()
            await foresight
            self.waited_for_routes_s += self._clock.now_s() - began_s
        finally:
            foresight.cancel()
            await asyncio.gather(foresight, return_exceptions=True)

    async def _foresee(
        self, key: str, plan: Plan, standing: frozenset[Cell], ahead: Ahead | None
    ) -> None:
        self._foreseen = None
        start = self.stance()
        try:
            route = self._planned_ahead(key, start, standing)
            if route is None:
                route = await asyncio.to_thread(plan, start, standing)
            if route.path:
                await self.arm.prepare(route.path)
            self._foreseen = _Foreseen(key, start, standing, route)
            if ahead is not None:
                after = await asyncio.to_thread(ahead.plan, route.end, ahead.standing)
                self._ahead = _Foreseen(ahead.key, route.end, ahead.standing, after)
        except (PlanError, CellFault) as error:
            # Whoever sets out meets it again, and says so.
            log.info("next route not prepared", route=key, reason=str(error))

    def _planned_ahead(self, key: str, start: Stance, standing: frozenset[Cell]) -> Route | None:
        ahead, self._ahead = self._ahead, None
        return ahead.route if ahead is not None and ahead.fits(key, start, standing) else None

    async def _planned(self, key: str, plan: Plan, standing: frozenset[Cell]) -> Route:
        began_s, start = self._clock.now_s(), self.stance()
        if route := self._planned_ahead(key, start, standing):
            return route
        try:
            return await asyncio.to_thread(plan, start, standing)
        except PlanError as error:
            raise CellFault("no_route", error.message) from error
        finally:
            self.waited_for_routes_s += self._clock.now_s() - began_s

    def _take_foreseen(self, key: str, standing: frozenset[Cell]) -> Route | None:
        """The route that was foreseen for this, if nothing has changed since."""
        foreseen, self._foreseen = self._foreseen, None
        fits = foreseen is not None and foreseen.fits(key, self.stance(), standing)
        return foreseen.route if foreseen is not None and fits else None

    async def travel(
        self,
        plan: Plan,
        standing: frozenset[Cell],
        began: Callable[[], None] = lambda: None,
        speed_fraction: float = 1.0,
        key: str = "",
        *,
        closing: bool = False,
    ) -> None:
        """Plan a checked route from where the arm is, unless it was foreseen, and follow it.

        Args:
            plan: makes the route from the arm's stance and what stands.
            standing: cells that hold a part.
            began: called when there is a way to go, before it begins.
            speed_fraction: share of the speeds that the route has.
            key: what it is for, where it may have been foreseen.
            closing: an open latch is told to close when the gripper is all but on its part, and
                ``close`` has less to wait for.

        Raises:
            CellFault: ``no_route``, or of the arm.
        """
        route = self._take_foreseen(key, standing) or await self._planned(key, plan, standing)
        if not route.path and route.joints is None:
            return
        began()
        switch = None
        if closing and self.is_open() and not self.latched():
            switch = Switch(
                line=self._config.gripper.command_output, high=False, within_m=_CLOSING_M
            )
        await travel(self.arm, route.slowed(speed_fraction), switch)
        self._closing = switch is not None

    async def check_wiring(self) -> float:
        """Prove the gripper's lines with an empty latch; see ``Gripper.check_wiring``."""
        self._opened = False
        return await self._gripper.check_wiring()

    async def wait_clear_of_station(self, move: asyncio.Task[None]) -> None:
        """Wait until a part that comes in cannot touch what the gripper holds, or the movement has
        ended.

        Raises:
            CellFault: of the arm.
        """
        while not move.done() and self.near_station(carrying=True):
            await self._clock.sleep(_POLL_S)
        if move.done():
            await move

    async def wait_left_station(self, move: asyncio.Task[None]) -> None:
        """Wait until the station's sensor cannot see the gripper's part any more, or the movement
        has ended.

        Raises:
            CellFault: of the arm.
        """
        pick, pitch_m = self.routes.pick_stance().tcp_pose, self._config.voxel.pitch_m
        while not move.done() and not left_station(self.state().tcp_pose, pick, pitch_m):
            await self._clock.sleep(_POLL_S)
        if move.done():
            await move

    async def wait_nearly_at_station(self, move: asyncio.Task[None]) -> None:
        """Wait until the arm is about to arrive at the pick station, or the movement has ended.

        Raises:
            CellFault: of the arm.
        """
        station = self.routes.pick_stance().tcp_pose[:3]
        while not move.done() and math.dist(self.state().tcp_pose[:3], station) > _NEARLY_M:
            await self._clock.sleep(_POLL_S)
        if move.done():
            await move

    def may_be_closing(self, stance: Stance, unless_known: bool) -> bool:
        """Whether the latch may have been told to close in a stance.

        Args:
            stance: where there is something to close on.
            unless_known: what holds while the robot does not say where it is.
        """
        if self.arm.state() is None:
            return unless_known
        return self.is_at(stance) and not self.is_told_open()

    def near_station(self, *, carrying: bool) -> bool:
        """Whether a part that comes in could touch the gripper, or the part that it holds.

        A gripper that has risen from there by itself (``RoutePlanner.rise``) is clear.
        """
        pitch_m, clearance_m = self._config.voxel.pitch_m, self._config.robot.clearance_m
        here, station = self.state().tcp_pose, self.routes.pick_stance().tcp_pose
        beside = math.dist(here[:2], station[:2]) < 2.0 * pitch_m
        hanging_m = pitch_m if carrying else 0.0
        return beside and here[2] - station[2] < hanging_m + clearance_m / 2

    def is_at(self, stance: Stance) -> bool:
        """Whether the TCP is where it is in that stance, and turned as it is there."""
        return stayed(self.state().tcp_pose, stance.tcp_pose)

    def expect_at(self, stance: Stance) -> None:
        """The latch moves only where the arm was sent.

        Raises:
            CellFault: ``arm_moved``.
        """
        here = self.state().tcp_pose
        if not stayed(here, stance.tcp_pose):
            off_m, off_rad = distance(here, stance.tcp_pose)
            raise CellFault(
                "arm_moved",
                f"It is {off_m * 1000:.0f} mm and {math.degrees(off_rad):.1f} degrees from where "
                "it was left.",
            )

    async def open(self) -> None:
        """Open the latch.

        Raises:
            CellFault: of the gripper.
        """
        self._closing, self._unproven = False, True
        began_s = self._clock.now_s()
        await self._gripper.unlatch()
        self.waited_for_latch_s += self._clock.now_s() - began_s
        self._opened = True

    async def close(self, *, prove: bool = True) -> None:
        """Close the latch, and see it confirmed.

        Args:
            prove: see it confirmed for longer than a fault could look like it.

        Raises:
            CellFault: of the gripper.
        """
        begun, self._closing = self._closing and not self.is_told_open(), False
        self._opened, self._unproven = False, True
        began_s = self._clock.now_s()
        await self._gripper.latch(prove=prove, begun=begun)
        self._unproven = not prove
        self.waited_for_latch_s += self._clock.now_s() - began_s

    async def finds_part(self) -> bool:
        """Close the latch where a part should stand, ask the gripper whether it has one, and let it
        stand.

        Raises:
            CellFault: of the gripper.
        """
        await self.close()
        found = await self._gripper.feels_part()
        await self.open()
        return found

    async def proof(self) -> None:
        """Wait for the proof that was left out when the latch closed, or that was cut off; at once
        where none was.

        Raises:
            CellFault: ``gripper_fault`` or ``gripper_reset``: it was revoked, and the arm stopped.
        """
        if self._unproven:
            await self._gripper.proof()
            self._unproven = False

    def is_told_open(self) -> bool:
        """Whether the command line tells the latch to be open."""
        return bool(self.state().digital_outputs >> self._config.gripper.command_output & 1)

    def is_open(self) -> bool:
        """Confirmed open, and still told to be: a stop of the robot may have dropped its output."""
        return self._opened and self.is_told_open()

    def forget_opening(self) -> None:
        """The gripper has started anew: what it confirmed before counts no longer."""
        self._opened = False

    async def adopt_line(self) -> None:
        """Order the latch what it is told already: what a person switched on the pendant before a
        reset was meant. Moves nothing.

        Raises:
            CellFault: of the arm.
        """
        await self.arm.set_output(self._config.gripper.command_output, self.is_told_open())

    async def wait_closed(self) -> None:
        """Give a latch that is told to close the time to confirm it.

        Raises:
            CellFault: of the arm.
        """
        if not self.is_told_open() and not self.latched():
            lines = self._config.gripper
            await self.arm.wait_input(lines.status_input, True, lines.travel_timeout_s)

    async def proves_latched(self) -> bool:
        """Whether the status line confirms a closed latch now, and for longer than it toggles."""
        waited_from_s = self._clock.now_s()
        while self.latched():
            if self._clock.now_s() - waited_from_s > STEADY_S:
                return True
            await self._clock.sleep(_POLL_S)
        return False

    async def stays_latched(self) -> bool:
        """Whether the status line confirms a closed latch for longer than it toggles.

        Raises:
            CellFault: ``gripper_fault``: it toggles; or of the arm.
        """
        if not self.latched():
            return False
        if await self.arm.wait_input(self._config.gripper.status_input, False, STEADY_S):
            raise CellFault("gripper_fault")
        return True

    def latched(self) -> bool:
        """Whether the status line confirms a closed latch."""
        return bool(self.state().digital_inputs >> self._config.gripper.status_input & 1)
