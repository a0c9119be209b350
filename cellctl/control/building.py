"""The physical stages of a build: feed, pick, place, let go, retreat."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial

import structlog

from cellctl.assembling.route import Route, Stance
from cellctl.assembly import Cell, PartOutcome, Step
from cellctl.clock import Clock
from cellctl.config import CellConfig
from cellctl.control.acting import Acting
from cellctl.control.acts import ActKind
from cellctl.control.job import Grip, Job
from cellctl.control.journal import Journal
from cellctl.control.moving import Ahead, ArmAndLatch
from cellctl.control.touch import Beside, Touch, alone, contact_early
from cellctl.errors import CellFault
from cellctl.feeding.belt import BeltState
from cellctl.feeding.inventory import Move
from cellctl.feeding.service import BeltService

log = structlog.get_logger(__name__)

_FREE = "off the part that was let go"
_STATION = "to the pick station"
_UNFELT = "nothing is felt under the gripper"


class Builder(Acting):
    """Moves parts from the belt to their cells; see ``Acting`` for the arguments."""

    def __init__(
        self,
        config: CellConfig,
        clock: Clock,
        *,
        hands: ArmAndLatch,
        belt: BeltService,
        journal: Journal,
    ) -> None:
        super().__init__(config, clock, hands=hands, belt=belt, journal=journal)
        self._touch = Touch(config, clock, hands)
        self._retries = 0
        self._waited_s = 0.0
        self._latch_before_s = 0.0
        self._routes_before_s = self._felt_before_s = 0.0
        self._part_began_s: float | None = None

    def begin(self) -> None:
        """A new job: times and retries count from here."""
        self._count_from(None)

    def _count_from(self, began_s: float | None) -> None:
        self._part_began_s, self._waited_s, self._retries = began_s, 0.0, 0
        self._latch_before_s = self._hands.waited_for_latch_s
        self._routes_before_s = self._hands.waited_for_routes_s
        self._felt_before_s = self._touch.felt_s

    # --- the stages ---------------------------------------------------------------------------

    async def in_the_way(self) -> bool:
        """Whether the arm must leave the station before a part can come: picking sees to that.

        Raises:
            CellFault: of the belt.
        """
        if self.grip is not Grip.NOTHING or not self._hands.near_station(carrying=False):
            return False
        return not (await self._belt.state()).part_present

    def belt_is_empty(self) -> bool:
        """Whether somebody must lay parts on the belt before one can come."""
        return self.grip is Grip.NOTHING and self.ledger.counts.belt == 0

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
        await self._ask_for_part(job)
        try:
            # While the belt works.
            await self._open_empty()
            await self._belt.part_ready(near)
        except asyncio.CancelledError:
            self._end_feed("interrupted")
            raise
        except CellFault as fault:
            self._end_feed("failed", str(fault))
            raise
        self._end_feed("done")
        self._waited_s += self._clock.now_s() - began_s

    async def pick(self, job: Job) -> bool:
        """Take the part at the station, at once when the gripper has one; False when none is there.

        Raises:
            CellFault: of arm, belt or gripper.
        """
        if self.grip is Grip.PART:
            return True
        if self._part_began_s is None:
            self._part_began_s = self._clock.now_s()
        hands = self._hands
        if self.grip is Grip.LATCHING and hands.is_told_open():
            self._never_closed()
        async with self._act(ActKind.PICK, job) as act:
            belt = await (self._reach(job) if self.grip is Grip.NOTHING else self._belt.state())
            if self.grip is Grip.LATCHING and not belt.part_present:
                # The arm was there before the belt had answered.
                hands.expect_at(hands.routes.pick_stance())
                await hands.open()
                self._open_act = None
            if self.grip is Grip.NOTHING and not belt.part_present:
                act.failed("No part lies at the station any more.")
                self._end_feed("failed", act.reason)
                # The next part must not run into the gripper.
                await self._travel(partial(hands.routes.rise, carrying=False), job)
                return False
            self._end_feed("done")
            hands.expect_at(hands.routes.pick_stance())
            self._latch_moves(ActKind.PICK)
            step = job.step
            assert step is not None, "a part is picked for a step"
            await hands.foreseeing(
                hands.close(prove=False),
                _way_to(step.cell, job),
                partial(hands.routes.to_seat, step.cell, pace=job.pace),
                self.standing,
            )
            act.moves, act.belt_indexes = (Move.PICK,), belt.indexes
            self._lifted = self._vouched = False
        return True

    async def _open_empty(self) -> None:
        """Have the latch open before the arm sets out; after a miss it may hold a part after all,
        and opens over the belt.

        Raises:
            CellFault: of the gripper, or of the arm.
        """
        await self._refuse_unknown_part()
        if not self._hands.is_open() and not self.ledger.missed:
            await self._hands.open()

    async def _reach(self, job: Job) -> BeltState:
        """Go to the part at the station, unless it is gone by the time the arm is nearly there. The
        latch begins to close as the arm arrives.

        Raises:
            CellFault: of arm, belt or gripper.
        """
        hands = self._hands
        await self._open_empty()
        move = asyncio.create_task(
            self._travel(hands.routes.to_pick, job, key=_STATION, closing=not self.ledger.missed)
        )
        near = False
        try:
            await hands.wait_nearly_at_station(move)
            near = True
            belt = await self._belt.state()
            if belt.part_present:
                await move
        finally:
            move.cancel()
            await asyncio.gather(move, return_exceptions=True)
            if not self.ledger.missed and hands.may_be_closing(hands.routes.pick_stance(), near):
                self._latch_moves(ActKind.PICK)
        if belt.part_present and self.grip is Grip.NOTHING and not hands.is_open():
            await hands.open()
        return belt

    async def place(self, job: Job) -> bool:
        """Bring the part to its cell; False when the part stayed at the station.

        Raises:
            CellFault: of arm, belt or gripper; ``pick_missed`` when trying again did not help;
                ``contact_early`` when the part meets something above its seat.
        """
        step = job.step
        assert step is not None, "placing needs a step"
        async with self._act(ActKind.PLACE, job) as act:
            routes = self._hands.routes
            move = asyncio.create_task(
                self._travel(
                    partial(routes.to_seat, step.cell, pace=job.pace),
                    job,
                    key=_way_to(step.cell, job),
                )
            )
            try:
                # While the part rises straight up, slowly at first.
                await self._see_it_held(step)
                lifted = await self._see_it_lift(move)
                if lifted:
                    await self._call_the_next(move, job)
                    await self._descend(move, step.cell)
                else:
                    await self._hands.arm.stop()
                    act.failed("The part stayed at the station.", Move.MISS)
                    self._retries += 1
            finally:
                move.cancel()
                await asyncio.gather(move, return_exceptions=True)
        if not lifted:
            log.warning("pick missed", retry=self._retries)
            if self._retries > self._config.gripper.retries:
                self._retries = 0
                raise CellFault("pick_missed")
        return lifted

    async def _see_it_held(self, step: Step | None) -> None:
        """See that the latch stays confirmed, unless a person has said that it has the part.

        Raises:
            CellFault: ``gripper_fault`` or ``gripper_reset``: it does not, and a person has to look
                where the part is; or of the arm.
        """
        if self._vouched:
            return
        try:
            await self._hands.proof()
        except CellFault as fault:
            if fault.code in {"gripper_fault", "gripper_reset"}:
                self.doubt_unconfirmed(step)
            raise

    async def _descend(self, move: asyncio.Task[None], cell: Cell) -> None:
        """Wait for the end of the way to a cell, and stop where the part meets something."""
        watch = asyncio.create_task(self._touch.met_early(move, cell))
        try:
            await asyncio.wait({move, watch}, return_when=asyncio.FIRST_COMPLETED)
            if watch.done() and (felt := watch.result()):
                await self._hands.arm.stop()
                raise contact_early(cell, felt)
            await move
        finally:
            watch.cancel()
            await asyncio.gather(watch, return_exceptions=True)

    async def release(self, job: Job) -> PartOutcome:
        """Let the part go at its cell and count it.

        Raises:
            CellFault: of the gripper; ``gripper_silent`` when the latch has ceased to confirm its
                part on the way, which may then lie anywhere; ``not_seated`` when nothing carries
                it; ``part_stuck`` when it does not come off the gripper; ``part_fell`` when, in a
                trial, it is not felt to stand.
        """
        step = job.step
        assert step is not None, "letting go needs a step"
        if self.misses_held() and not self._vouched:
            self.doubt_unconfirmed(step)
            raise CellFault("gripper_silent", "It has ceased to confirm the part on the way.")
        async with self._act(ActKind.RELEASE, job) as act:
            self._hands.expect_at(self._hands.routes.place_stance(step.cell))
            if self.grip is Grip.PART:
                await self._touch.seat(step.cell, self.standing, partial(self._travel, job=job))
            self._latch_moves(ActKind.RELEASE)
            await self._let_go(job, step.cell)
            stands = job.pace is None or await self._touch.stands(
                step.cell, self.standing, partial(self._travel, job=job)
            )
            await self._touch.free(
                step.cell, partial(self._travel, job=job, key=_FREE), self._next_prepared(job)
            )
            act.moves = (Move.PLACE,)
            if not stands:
                self._open_act = None  # nothing is in doubt: it was let go, and fell
                act.failed(_UNFELT, Move.PLACE, Move.LOSE_PLACED)
        if not stands:
            job.standing = self.standing
            raise CellFault("part_fell", f"At {list(step.cell)} {_UNFELT}.")
        job.outcomes.append(self._outcome(step))
        job.standing = self.standing
        return job.outcomes[-1]

    def _outcome(self, step: Step) -> PartOutcome:
        """What the step took, since the one before; the next one counts from here."""
        now_s = self._clock.now_s()
        began_s = self._part_began_s if self._part_began_s is not None else now_s
        outcome = PartOutcome(
            step=step.index,
            kind=step.kind,
            cell=step.cell,
            seconds=round(now_s - began_s, 3),
            waited_s=round(self._waited_s, 3),
            latch_s=round(self._hands.waited_for_latch_s - self._latch_before_s, 3),
            route_s=round(self._hands.waited_for_routes_s - self._routes_before_s, 3),
            touch_s=round(self._touch.felt_s - self._felt_before_s, 3),
            predicted_s=step.duration_s,
            retries=self._retries,
        )
        self._count_from(now_s)
        return outcome

    async def _let_go(self, job: Job, cell: Cell) -> None:
        """Open the latch, with the movement after it ready, and the one to the next part planned
        for when this one stands."""
        freeing = self._touch.freeing(cell)
        if freeing is None:
            await self._hands.open()
            return
        ahead = None
        if job.more_after_this and not job.cancelling:
            ahead = Ahead(_STATION, self._hands.routes.to_pick, self.standing | {cell})
        await self._hands.foreseeing(self._hands.open(), _FREE, freeing, self.standing, ahead)

    def _next_prepared(self, job: Job) -> Beside:
        """Awaits something while the way to the next part is made ready, if that lies there."""
        step, routes = job.step, self._hands.routes
        assert step is not None, "a part was let go for a step"
        if not job.more_after_this or job.cancelling or not self._belt.ready:
            return alone
        standing = self.standing | {step.cell}
        return lambda awaited: self._hands.foreseeing(awaited, _STATION, routes.to_pick, standing)

    async def retreat(self, job: Job) -> None:
        """Go up and home.

        Raises:
            CellFault: of the arm.
        """
        routes = self._hands.routes
        carrying = self.grip is not Grip.NOTHING
        async with self._act(ActKind.RETREAT, job):
            await self._travel(
                lambda start, placed: routes.retreat(start, placed, carrying=carrying), job
            )
            await self._travel(
                lambda start, placed: routes.to_home(start, placed, carrying=carrying), job
            )
        self._part_began_s = None

    # --- inside -------------------------------------------------------------------------------

    async def _travel(
        self,
        plan: Callable[[Stance, frozenset[Cell]], Route],
        job: Job,
        key: str = "",
        *,
        closing: bool = False,
    ) -> None:
        def began() -> None:
            if job.first_motion_s is None:
                job.first_motion_s = self._clock.now_s()

        await self._hands.travel(plan, self.standing, began, key=key, closing=closing)

    async def _see_it_lift(self, move: asyncio.Task[None]) -> bool:
        """Whether the part leaves the station with the gripper."""
        if self.ledger.lift_unchecked and not self._lifted:
            await self._hands.wait_left_station(move)
            belt, before = await self._belt.state(), self.ledger.belt_indexes
            if belt.part_present and before is not None and belt.indexes < before:
                # The board was restarted meanwhile: it may be the same part, or the next one.
                await self._hands.arm.stop()
                self.doubt_held(
                    "The part may be in the gripper, or still at the pick station", "gripper"
                )
                raise CellFault("pick_missed", "The conveyor's board was restarted meanwhile.")
            another = before is not None and belt.indexes > before
            self._lifted = another or not belt.part_present
            return self._lifted
        return True

    async def _call_the_next(self, move: asyncio.Task[None], job: Job) -> None:
        """The next part comes in only when this one hangs higher than it is, or is elsewhere."""
        await self._hands.wait_clear_of_station(move)
        if job.more_after_this and not job.cancelling and self.ledger.counts.belt > 0:
            await self._ask_for_part(job)

    async def _ask_for_part(self, job: Job) -> None:
        """Have the belt bring a part. The intent tells, after a crash, that the part in the gripper
        had left the station by then: another part may lie there."""
        if self._feed_act is None:
            self._feed_act = await self._journal.intend(ActKind.FEED, job.job_id)
        self._belt.request_part()


def _way_to(cell: Cell, job: Job) -> str:
    """What a way that is made in advance is known by: one to the same cell at another pace is not
    the same."""
    return f"{cell} {job.pace}"
