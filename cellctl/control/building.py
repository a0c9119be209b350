"""The physical stages of a build: feed, pick, place, let go, retreat.

Each act is written into the journal as an intent before it and an outcome after it. Where an act is
cut short, ``Builder.grip`` says how far it came, so that it can be taken up again without doing
anything twice and without dropping a part.
"""

from __future__ import annotations

import asyncio
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import structlog

from cellctl.assembling.arm import Arm, ArmState
from cellctl.assembling.gripper import Gripper
from cellctl.assembling.route import Route, RoutePlanner, Stance
from cellctl.assembly import Cell
from cellctl.clock import Clock
from cellctl.config import CellConfig
from cellctl.control.job import Grip, Job
from cellctl.control.journal import ActKind, Journal
from cellctl.errors import CellFault, PlanError
from cellctl.feeding.inventory import Act as Moved
from cellctl.feeding.inventory import Inventory
from cellctl.feeding.service import BeltService
from cellctl.messages import PartOutcome

log = structlog.get_logger(__name__)

_LIFT_SHARE = 0.7
"""Once the TCP has risen by this share of a voxel, the station's sensor no longer sees its part."""
_LIFT_POLL_S = 0.02
_STAYED_M = 0.005
"""The arm counts as where it was left within this distance."""


class _Report:
    """What an act came to, where it did not simply succeed."""

    def __init__(self) -> None:
        self.reason = ""

    def failed(self, reason: str) -> None:
        """It did nothing, and that is no fault yet."""
        self.reason = reason


class Builder:
    """Moves parts from the belt to their cells.

    Args:
        config: the cell.
        clock: cell time.
        arm, gripper, belt: the devices.
        journal: where acts are written.
        inventory: where the parts are; its sum never changes.
    """

    def __init__(
        self,
        config: CellConfig,
        clock: Clock,
        *,
        arm: Arm,
        gripper: Gripper,
        belt: BeltService,
        journal: Journal,
        inventory: Inventory,
    ) -> None:
        self._config = config
        self._clock = clock
        self._arm = arm
        self._gripper = gripper
        self._belt = belt
        self._journal = journal
        self.inventory = inventory
        self._routes = RoutePlanner(config)
        self.grip = Grip.NOTHING
        self.standing: set[Cell] = set()
        """Cells of the workspace that hold a part."""
        self._opened = False
        """The gripper has confirmed that it is open since it last closed."""
        self._release_cell: Cell | None = None
        """Where the part goes that is being let go."""
        self._missed = False
        """The last pick left its part at the station; the arm hangs just above it, latched."""
        self._lift_unchecked = False
        self._retries = 0
        self._waited_s = 0.0
        self._part_began_s: float | None = None

    # --- between jobs -------------------------------------------------------------------------

    def begin(self) -> None:
        """A new job: times and retries count from here."""
        self._part_began_s, self._waited_s, self._retries = None, 0.0, 0

    def settle_grip(self, job: Job) -> None:
        """Decide what a cut-off latching or letting go came to, by the gripper's status line.

        A confirmed latch holds its part, which the next job builds in. Without one, a part that
        was being let go stands, and one that was being taken still lies at the station.
        """
        state = self._arm.state()
        latched = state is not None and self._status_high(state)
        if self.grip is Grip.LATCHING and not latched:
            self.inventory.apply(Moved.MISS)
            self.grip, self._missed = Grip.NOTHING, True
        elif self.grip is Grip.RELEASING and not latched:
            self._count_standing()
            job.placed += 1
        elif self.grip is Grip.LATCHING:
            self.grip, self._lift_unchecked = Grip.PART, True
        elif self.grip is Grip.RELEASING:
            self.grip, self._release_cell = Grip.PART, None

    def check_at_start(self) -> None:
        """Refuse to begin with a gripper that may hold something nobody knows of.

        Raises:
            CellFault: ``gripper_holds``.
        """
        if self._status_high(self._state()):
            raise CellFault("gripper_holds")

    def parts_available(self) -> int:
        """How many parts a plan may use: those on the belt and the one in the gripper."""
        return self.inventory.available

    def declare_clear(self) -> None:
        """An operator says that nothing stands any more; its parts are on the belt again."""
        act = self._journal.intend(ActKind.CLEAR, job_id="")
        while self.standing:
            self.inventory.apply(Moved.TAKE_APART)
            self.standing.pop()
        self._journal.settle(act, "done")

    # --- the stages ---------------------------------------------------------------------------

    async def feed(self, job: Job, near: Callable[[], None]) -> None:
        """Wait until a part lies at the pick station; at once when the gripper has one.

        Raises:
            CellFault: of the belt or the gripper.
        """
        if self.grip is not Grip.NOTHING:
            return
        began_s = self._clock.now_s()
        if self._part_began_s is None:
            self._part_began_s = began_s
        step = job.step
        with self._act(ActKind.FEED, job):
            self._belt.request_part()
            await self._belt.part_ready(near)
        self._waited_s += self._clock.now_s() - began_s
        log.debug("part ready", step=step.index if step is not None else None)

    async def pick(self, job: Job) -> bool:
        """Take the part at the station, at once when the gripper has one; False when none is there.

        Raises:
            CellFault: of arm, belt or gripper.
        """
        if self.grip is Grip.PART:
            return True
        if self._part_began_s is None:
            self._part_began_s = self._clock.now_s()
        with self._act(ActKind.PICK, job) as act:
            if self.grip is Grip.NOTHING:
                if not self._is_open() and not self._missed:
                    await self._open()
                await self._move(self._routes.to_pick, job)
                if not self._is_open():
                    await self._open()
                if not (await self._belt.state()).part_present:
                    act.failed("No part lies at the station any more.")
                    return False
                self.inventory.apply(Moved.PICK)
                self.grip = Grip.LATCHING
            self._expect_at(self._routes.pick_stance())
            self._opened = False
            await self._gripper.latch()
            self.grip = Grip.PART
            self._missed = False
            self._lift_unchecked = True
        return True

    async def place(self, job: Job) -> bool:
        """Bring the part to its cell; False when the part stayed at the station.

        Raises:
            CellFault: of arm, belt or gripper; ``pick_missed`` when trying again did not help.
        """
        step = job.step
        assert step is not None, "placing needs a step"
        with self._act(ActKind.PLACE, job) as act:
            move = asyncio.create_task(
                self._move(
                    lambda start, placed: self._routes.to_cell(step.cell, placed, start), job
                )
            )
            try:
                if self._lift_unchecked:
                    await self._risen(move, _LIFT_SHARE * self._config.voxel.pitch_m)
                    if (await self._belt.state()).part_present:
                        await self._arm.stop()
                        act.failed("The part stayed at the station.")
                        self._give_up_pick()
                        return False
                    self._lift_unchecked = False
                # The next part comes in only when this one hangs higher than it is.
                pitch_m = self._config.voxel.pitch_m
                await self._risen(move, pitch_m + self._config.robot.clearance_m / 2)
                if job.more_after_this and not job.cancelling:
                    self._belt.request_part()
                await move
            finally:
                move.cancel()
                await asyncio.gather(move, return_exceptions=True)
        return True

    async def release(self, job: Job) -> PartOutcome:
        """Let the part go at its cell and count it.

        Raises:
            CellFault: of the gripper.
        """
        step = job.step
        assert step is not None, "letting go needs a step"
        with self._act(ActKind.RELEASE, job):
            self._expect_at(self._routes.place_stance(step.cell))
            self.grip, self._release_cell = Grip.RELEASING, step.cell
            await self._open()
            self._count_standing()
        now_s = self._clock.now_s()
        began_s = self._part_began_s if self._part_began_s is not None else now_s
        outcome = PartOutcome(
            step=step.index,
            cell=step.cell,
            seconds=round(now_s - began_s, 3),
            waited_s=round(self._waited_s, 3),
            retries=self._retries,
        )
        job.outcomes.append(outcome)
        job.placed += 1
        self._part_began_s, self._waited_s, self._retries = now_s, 0.0, 0
        return outcome

    async def retreat(self, job: Job) -> None:
        """Go up and home.

        Raises:
            CellFault: of the arm.
        """
        with self._act(ActKind.RETREAT, job):
            carrying = self.grip is not Grip.NOTHING
            await self._move(
                lambda start, placed: self._routes.retreat(start, placed, carrying=carrying), job
            )
            await self._move(
                lambda start, placed: self._routes.to_home(start, placed, carrying=carrying), job
            )
        self._part_began_s = None

    # --- inside -------------------------------------------------------------------------------

    def _count_standing(self) -> None:
        """The part that was let go stands at its cell."""
        assert self._release_cell is not None, "letting go has a cell"
        self.inventory.apply(Moved.PLACE)
        self.standing.add(self._release_cell)
        self.grip, self._release_cell = Grip.NOTHING, None

    async def _open(self) -> None:
        await self._gripper.unlatch()
        self._opened = True

    def _is_open(self) -> bool:
        """Confirmed open, and still told to be: a stop of the robot may have dropped its output."""
        output = self._config.gripper.command_output
        return self._opened and bool(self._state().digital_outputs >> output & 1)

    def _status_high(self, state: ArmState) -> bool:
        return bool(state.digital_inputs >> self._config.gripper.status_input & 1)

    def _expect_at(self, stance: Stance) -> None:
        """The latch moves only where the arm was sent.

        Raises:
            CellFault: ``arm_moved``.
        """
        off_m = math.dist(self._state().tcp_pose[:3], stance.tcp_pose[:3])
        if off_m > _STAYED_M:
            raise CellFault("arm_moved", f"It is {off_m * 1000:.0f} mm from where it was left.")

    async def _move(self, plan: Callable[[Stance, frozenset[Cell]], Route], job: Job) -> None:
        """Plan a checked route from where the arm is, and follow it."""
        state = self._state()
        stance = Stance(state.tcp_pose, state.joints_rad)
        try:
            route = await asyncio.to_thread(plan, stance, frozenset(self.standing))
        except PlanError as error:
            raise CellFault("no_route", error.message) from error
        if not route.path:
            return
        if job.first_motion_s is None:
            job.first_motion_s = self._clock.now_s()
        await self._arm.follow(route.path, route.duration_s)

    async def _risen(self, move: asyncio.Task[None], height_m: float) -> None:
        """Wait until the TCP is so far above the pick station, or the movement has ended."""
        height_m += self._routes.pick_stance().tcp_pose[2]
        while not move.done() and self._state().tcp_pose[2] < height_m:
            await self._clock.sleep(_LIFT_POLL_S)
        if move.done():
            await move

    def _give_up_pick(self) -> None:
        """The part is still at the station: nothing is in the gripper, whatever it reports."""
        self.grip = Grip.NOTHING
        self._missed, self._lift_unchecked = True, False
        self.inventory.apply(Moved.MISS)
        self._retries += 1
        log.warning("pick missed", retry=self._retries)
        if self._retries > self._config.gripper.retries:
            self._retries = 0
            raise CellFault("pick_missed")

    def _state(self) -> ArmState:
        state = self._arm.state()
        if state is None:
            raise CellFault("robot_lost")
        return state

    @contextmanager
    def _act(self, kind: ActKind, job: Job) -> Iterator[_Report]:
        """An intent before, an outcome after, whatever happens between."""
        step = job.step
        act = self._journal.intend(
            kind,
            job.job_id,
            step.index if step is not None else None,
            step.cell if step is not None else None,
        )
        report = _Report()
        try:
            yield report
        except asyncio.CancelledError:
            self._journal.settle(act, "interrupted")
            raise
        except Exception as error:
            self._journal.settle(act, "failed", str(error))
            raise
        self._journal.settle(act, "failed" if report.reason else "done", report.reason)
