"""The physical stages of a build: feed, pick, place, let go, retreat.

Each act is written into the journal as an intent before it and an outcome after it. An act that is
cut off while the latch moves keeps its intent without an outcome until the devices, or a person,
can say how far it came; so nothing is done twice and no part is dropped, whatever ends, the daemon
included.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial

import structlog

from cellctl.assembling.route import Route, Stance
from cellctl.assembly import Cell, PartOutcome, Step
from cellctl.clock import Clock
from cellctl.config import CellConfig
from cellctl.control.act_report import ActReport, called
from cellctl.control.acts import ActKind, Outcome
from cellctl.control.job import Grip, Job
from cellctl.control.journal import Journal
from cellctl.control.ledger import Ledger
from cellctl.control.moving import ArmAndLatch
from cellctl.control.recovery import Doubt, Evidence, moves_to, settle, unconfirmed
from cellctl.control.touch import Touch
from cellctl.errors import CellFault, RefusedError, UsageError
from cellctl.feeding.inventory import Move
from cellctl.feeding.service import BeltService
from cellctl.messages import PartPlace

log = structlog.get_logger(__name__)

_FREE = "off the part that was let go"


class Builder:
    """Moves parts from the belt to their cells.

    Args:
        config: the cell.
        clock: cell time.
        hands: the arm and its latch.
        belt: brings parts.
        journal: where acts are written, and what is believed of the cell.
    """

    def __init__(
        self,
        config: CellConfig,
        clock: Clock,
        *,
        hands: ArmAndLatch,
        belt: BeltService,
        journal: Journal,
    ) -> None:
        self._config = config
        self._clock = clock
        self._hands = hands
        self._belt = belt
        self._journal = journal
        self._touch = Touch(config, clock, hands)
        self.doubt: Doubt | None = None
        """What nobody can know about the part that was on its way."""
        self._open_act: tuple[int, ActKind] | None = None
        """The act in which the latch was told to move and has not confirmed it."""
        self._act_id: int | None = None
        """The newest act."""
        self._feed_act: int | None = None
        """The act in which the belt was asked for a part."""
        self._lifted = False
        """The part in the gripper was seen to leave the station."""
        self._vouched = False
        """A person has said that the part is in the gripper, whatever the latch confirms."""
        self._retries = 0
        self._waited_s = 0.0
        self._latch_before_s = 0.0
        self._routes_before_s = 0.0
        self._part_began_s: float | None = None

    # --- what is believed ---------------------------------------------------------------------

    @property
    def ledger(self) -> Ledger:
        """Where the parts are."""
        return self._journal.ledger

    @property
    def standing(self) -> frozenset[Cell]:
        """Cells of the workspace that hold a part."""
        return self.ledger.standing

    @property
    def grip(self) -> Grip:
        """What the latch has."""
        if self._open_act is not None:
            latching = self._open_act[1] is ActKind.PICK
            return Grip.LATCHING if latching else Grip.RELEASING
        return Grip.PART if self.ledger.holding else Grip.NOTHING

    def begin(self) -> None:
        """A new job: times and retries count from here."""
        self._count_from(None)

    def _count_from(self, began_s: float | None) -> None:
        self._part_began_s, self._waited_s, self._retries = began_s, 0.0, 0
        self._latch_before_s = self._hands.waited_for_latch_s
        self._routes_before_s = self._hands.waited_for_routes_s

    async def settle_cut(self, step: Step | None) -> None:
        """Decide what the acts came to that were cut off, by what the devices say now.

        What they cannot say is kept as ``doubt``.

        Args:
            step: the one that was under way.

        Raises:
            CellFault: ``gripper_holds``: the latch holds something nobody knows of; or a device
                does not answer.
        """
        # Nothing is forgotten before all devices have answered, and nothing waits in between.
        belt = await self._belt.state()
        arm = self._hands.state()
        unsettled, ledger = self._journal.unsettled(), self.ledger
        self.doubt = self._open_act = self._feed_act = None
        if not unsettled and not ledger.holding:
            await self._refuse_unknown_part()
            return
        cell = next((act.cell for act in reversed(unsettled) if act.cell is not None), None)
        routes = self._hands.routes
        evidence = Evidence.of(
            self._config,
            arm,
            belt,
            routes.pick_stance().tcp_pose,
            routes.place_stance(cell).tcp_pose if cell is not None else None,
        )
        settlement = settle(ledger, unsettled, evidence, called(step))
        for act in settlement.acts:
            self._journal.settle(act.act_id, act.outcome, act.detail, act.moves, act.belt_indexes)
        if settlement.missed:
            await self._journal.record(
                ActKind.SETTLE, detail="it was never lifted", moves=(Move.MISS,)
            )
        self._lifted = settlement.lifted
        self.doubt = settlement.doubt
        log.info(
            "settled what was cut off",
            acts=[f"{act.act_id} {act.outcome}" for act in settlement.acts],
            missed=settlement.missed,
            doubt=settlement.doubt.sentence if settlement.doubt else "",
            **evidence.model_dump(),
        )
        if settlement.doubt is None and not self.ledger.holding:
            await self._refuse_unknown_part()

    async def _refuse_unknown_part(self) -> None:
        """Raises ``gripper_holds`` when the latch has closed and no act says on what."""
        if not self.ledger.missed and await self._hands.stays_latched():
            raise CellFault("gripper_holds")

    def misses_held(self) -> bool:
        """Whether a part counts as held and the latch does not confirm it."""
        return self.grip is Grip.PART and not self._hands.latched()

    def doubt_unconfirmed(self, step: Step | None) -> None:
        """The latch does not confirm the part that counts as held; a person has to look."""
        assert self.ledger.holding, "only a part that counts as held can be missed"
        self.doubt = unconfirmed(called(step), self._hands.is_told_open())

    def doubt_held(self, sentence: str, believed: PartPlace) -> None:
        """The part that counts as held may be elsewhere; a person has to look.

        Args:
            sentence: what is believed, and why.
            believed: what ``resume`` takes for granted.
        """
        assert self.ledger.holding, "only a part that counts as held can be missed"
        self.doubt = Doubt(act_id=None, kind=ActKind.PLACE, sentence=sentence, believed=believed)

    async def recover(self, part: PartPlace, step: Step | None) -> None:
        """An operator says where the part is that was on its way.

        Raises:
            RefusedError: there is no such part, or the latch still holds it.
            UsageError: the part cannot be there.
            CellFault: ``journal_failed``, ``robot_lost``.
        """
        doubt = self.doubt or self._undoubted()
        if self.doubt is None and part == "gripper" and doubt.act_id is None:
            return
        if self._hands.latched() and part not in {"gripper", "station"}:
            raise RefusedError(
                "The latch is closed, on the part as it seems.",
                "Say `cellctl recover gripper`; then hold the part and open the latch with "
                "`cellctl hand open --part-held`.",
            )
        outcome, moves = moves_to(doubt, part)
        if part == "cell" and step is None and doubt.act_id is None:
            raise UsageError("No job is under way whose cell the part could be at.")
        if part == "gripper" and self._hands.is_told_open():
            raise UsageError("The latch is open, so the part cannot be in the gripper.")
        detail = f"an operator says: {part}"
        if doubt.act_id is not None:
            indexes = (await self._belt.state()).indexes if doubt.kind is ActKind.PICK else None
            self._journal.settle(doubt.act_id, outcome, detail, moves, indexes)
        elif moves:
            cell = step.cell if step is not None and part == "cell" else None
            await self._journal.record(ActKind.SETTLE, cell=cell, detail=detail, moves=moves)
        self.doubt = self._open_act = None
        self._lifted = self._vouched = part == "gripper"

    def _undoubted(self) -> Doubt:
        """The part that was on its way, as if it were in doubt.

        Raises:
            RefusedError: there is none.
        """
        if self._open_act is not None:
            act_id, kind = self._open_act
            return Doubt(act_id=act_id, kind=kind, sentence="", believed="gripper")
        if not self.ledger.holding:
            raise RefusedError("No part is in the gripper, and none is in doubt.")
        return Doubt(act_id=None, kind=ActKind.PLACE, sentence="", believed="gripper")

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
        async with self._act(ActKind.PICK, job) as act:
            if self.grip is Grip.NOTHING:
                await self._refuse_unknown_part()
                if not hands.is_open() and not self.ledger.missed:
                    await hands.open()
                await self._travel(hands.routes.to_pick, job)
                if not hands.is_open():
                    await hands.open()
            belt = await self._belt.state()
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
                hands.close(),
                str(step.cell),
                lambda start, placed: hands.routes.to_cell(step.cell, placed, start),
                self.standing,
            )
            act.moves, act.belt_indexes = (Move.PICK,), belt.indexes
            self._lifted = self._vouched = False
        return True

    async def place(self, job: Job) -> bool:
        """Bring the part to its cell; False when the part stayed at the station.

        Raises:
            CellFault: of arm, belt or gripper; ``pick_missed`` when trying again did not help.
        """
        step = job.step
        assert step is not None, "placing needs a step"
        async with self._act(ActKind.PLACE, job) as act:
            routes = self._hands.routes
            move = asyncio.create_task(
                self._travel(
                    lambda start, placed: routes.to_cell(step.cell, placed, start),
                    job,
                    key=str(step.cell),
                )
            )
            try:
                lifted = await self._see_it_lift(move)
                if lifted:
                    await self._call_the_next(move, job)
                    await move
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

    async def release(self, job: Job) -> PartOutcome:
        """Let the part go at its cell and count it.

        Raises:
            CellFault: of the gripper; ``gripper_silent`` when the latch has ceased to confirm its
                part on the way, which may then lie anywhere; ``not_seated`` when nothing carries
                it; ``part_stuck`` when it does not come off the gripper.
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
            await self._let_go(step.cell)
            await self._touch.free(step.cell, partial(self._travel, job=job, key=_FREE))
            act.moves = (Move.PLACE,)
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
            predicted_s=step.duration_s,
            retries=self._retries,
        )
        self._count_from(now_s)
        return outcome

    async def _let_go(self, cell: Cell) -> None:
        """Open the latch, with the movement after it ready."""
        freeing = self._touch.freeing(cell)
        if freeing is None:
            await self._hands.open()
            return
        await self._hands.foreseeing(self._hands.open(), _FREE, freeing, self.standing)

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
        self, plan: Callable[[Stance, frozenset[Cell]], Route], job: Job, key: str = ""
    ) -> None:
        def began() -> None:
            if job.first_motion_s is None:
                job.first_motion_s = self._clock.now_s()

        await self._hands.travel(plan, self.standing, began, key=key)

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

    def _end_feed(self, outcome: Outcome, detail: str = "") -> None:
        act_id, self._feed_act = self._feed_act, None
        if act_id is not None:
            self._journal.settle(act_id, outcome, detail)

    def _latch_moves(self, kind: ActKind) -> None:
        """From here on only the devices, or a person, can say what became of the act."""
        assert self._act_id is not None, "the latch moves in an act"
        self._open_act = (self._act_id, kind)

    @asynccontextmanager
    async def _act(self, kind: ActKind, job: Job) -> AsyncIterator[ActReport]:
        """An intent before, an outcome after, whatever happens between."""
        act_id = await self._intend(kind, job)
        self._act_id = act_id
        report = ActReport()

        def close(outcome: Outcome, detail: str) -> None:
            if self._open_act is not None and outcome != "done":
                return  # it keeps its intent, and is taken up again
            self._journal.settle(act_id, outcome, detail, report.moves, report.belt_indexes)
            self._open_act = None

        try:
            yield report
        except asyncio.CancelledError:
            close("interrupted", "")
            raise
        except Exception as error:
            close("failed", str(error))
            raise
        close("failed" if report.reason else "done", report.reason)

    async def _intend(self, kind: ActKind, job: Job) -> int:
        """The id of the act: of the one that was cut off while the latch moved, or of a new one."""
        if self._open_act is not None:
            assert self._open_act[1] is kind, "an act is taken up again by its own stage"
            return self._open_act[0]
        step = job.step
        return await self._journal.intend(
            kind,
            job.job_id,
            step.index if step is not None else None,
            step.cell if step is not None else None,
        )
