"""The physical stages of taking apart: grip, part, bring back, put back on the belt.

The same acts as those of a build carry it: an intent before, an outcome after. While the latch is
closed on a part that still stands, the part counts as standing; it counts as in the gripper from
the moment at which it is off its cell, which the arm's pose tells.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Literal

import structlog

from cellctl.assembling.route import Route, Stance
from cellctl.assembly import Cell, PartOutcome, Step, StepKind, TakeOff
from cellctl.control.acts import ActKind
from cellctl.control.building import Builder
from cellctl.control.job import Grip, Job
from cellctl.control.recovery import Doubt
from cellctl.control.touch import Travel
from cellctl.errors import CellFault
from cellctl.feeding.inventory import Move

log = structlog.get_logger(__name__)

_PULL = TakeOff(how="pull", force_n=0.0)
_BACK = frozenset({ActKind.RETURN, ActKind.PUT_BACK})

Taken = Literal["to_belt", "to_place", "again"]
"""Where a part goes that was taken off: to the belt, or to the cell where the next one is placed;
``again``: the latch had let it go, and it stands."""


class Dismantler(Builder):
    """A builder that also takes parts off and brings them back to the belt; see ``Builder``."""

    _taken_step: Step | None = None
    """The step by which the part in the gripper was taken off."""

    @property
    def grip(self) -> Grip:
        """What the latch has."""
        if self._open_act is not None:
            kind = self._open_act[1]
            if kind is ActKind.TAKE_OFF:
                return Grip.GRIPPED
            closing = kind in {ActKind.PICK, ActKind.GRIP}
            return Grip.LATCHING if closing else Grip.RELEASING
        if self.ledger.gripped is not None and not self.ledger.holding:
            return Grip.GRIPPED
        return super().grip

    def begin(self) -> None:
        """A new job; a part that is in the gripper still was taken by no step of it."""
        super().begin()
        self._taken_step = None

    async def grip_standing(self, job: Job) -> None:
        """Go to the part that is to be taken off and close the latch on it.

        Raises:
            CellFault: of the arm or the gripper.
        """
        step = _taken(job)
        if self.ledger.gripped == step.cell:
            return
        await self.let_stand(job)
        hands = self._hands
        self._start_clock()
        async with self._act(ActKind.GRIP, job):
            if self.grip is Grip.NOTHING:
                await self._refuse_unknown_part()
                if not hands.is_open():
                    await hands.open()
                await self._travel(
                    lambda start, placed: hands.routes.to_grip(step.cell, placed, start), job
                )
            if not hands.is_open():
                await hands.open()
            hands.expect_at(hands.routes.place_stance(step.cell))
            self._latch_moves(ActKind.GRIP)
            await hands.close()

    @property
    def gripping_cut_off(self) -> bool:
        """Whether the latch was told to close on a part that stands, and has not confirmed it."""
        return self._open_act is not None and self._open_act[1] is ActKind.GRIP

    @property
    def taking_cut_off(self) -> bool:
        """Whether taking a part off was begun and has not ended."""
        return self._open_act is not None and self._open_act[1] is ActKind.TAKE_OFF

    @property
    def putting_back_cut_off(self) -> bool:
        """Whether letting a part go at the pick station was begun and has not ended."""
        return self._open_act is not None and self._open_act[1] is ActKind.PUT_BACK

    async def take_off(self, job: Job) -> Taken:
        """Part the gripped part from its neighbours and lift it clear; the belt makes room for it.

        Raises:
            CellFault: of the arm; ``gripper_silent`` when the latch does not confirm the part.
        """
        step, hands = _taken(job), self._hands
        self._start_clock()
        stands = hands.is_at(hands.routes.place_stance(step.cell))
        if not hands.latched() and stands:
            await self._grip_was_lost(job)
            return "again"
        if not self._goes_on(job):
            self._belt.request_room()
        async with self._act(ActKind.TAKE_OFF, job) as act:
            # From here on the arm's pose tells whether the part has come along.
            self._latch_moves(ActKind.TAKE_OFF)
            if not hands.latched():
                self.doubt = self._doubt_taken(step)
                raise CellFault("gripper_silent", "It has ceased to confirm the part on the way.")
            if stands:
                await self._travel(
                    lambda start, placed: hands.routes.take_off(
                        step.cell, step.take_off or _PULL, placed, start
                    ),
                    job,
                )
            act.moves = (Move.TAKE_OFF,)
        goes_on = self._goes_on(job)
        job.standing = self.standing
        self._taken_step = step
        if not goes_on:
            return "to_belt"
        job.outcomes.append(self._outcome(step))
        return "to_place"

    def _goes_on(self, job: Job) -> bool:
        """Whether the part that is taken off is placed next, and need not go to the belt."""
        return job.next_placement is not None and not job.cancelling

    async def _grip_was_lost(self, job: Job) -> None:
        """The part stands, and the latch does not confirm it: it is to be gripped anew.

        Raises:
            CellFault: ``gripper_silent`` when that did not help.
        """
        async with self._act(ActKind.TAKE_OFF, job) as act:
            self._open_act = None
            act.failed("The latch has ceased to confirm the part; it stands.")
        self._retries += 1
        log.warning("grip lost", retry=self._retries)
        if self._retries > self._config.gripper.retries:
            self._retries = 0
            raise CellFault("gripper_silent", "It does not confirm a part that stands.")

    def _doubt_taken(self, step: Step) -> Doubt:
        """The latch does not confirm a part that was on its way off; a person has to look."""
        assert self._open_act is not None, "it was begun"
        return Doubt(
            act_id=self._open_act[0],
            kind=ActKind.TAKE_OFF,
            sentence=f"Part {step.index + 1} may be in the gripper, or stand at its cell",
            believed="gripper",
        )

    async def bring_back(self, job: Job) -> None:
        """Bring the part in the gripper to the pick station, where the belt makes room.

        Raises:
            CellFault: of the arm or the belt.
        """
        hands = self._hands
        self._start_clock()
        if not hands.latched() and not self._vouched:
            self.doubt_unconfirmed(self._brought_by(job))
            raise CellFault("gripper_silent", "It has ceased to confirm the part on the way.")
        await self._see_it_held(self._brought_by(job))
        async with self._act(ActKind.RETURN, job):
            if hands.is_at(hands.routes.pick_stance()):
                return
            self._belt.request_room()
            await self._travel_upright(job)
            await self._belt.room_ready()
            await self._travel(lambda start, placed: hands.routes.to_station(placed, start), job)

    async def put_back(self, job: Job) -> PartOutcome | None:
        """Let the part go at the pick station and count it; None where it was left over from a job
        before this one, and no step of it is done.

        Raises:
            CellFault: of the gripper; ``gripper_silent`` when the latch has ceased to confirm its
                part on the way, which may then lie anywhere.
        """
        hands = self._hands
        if self.misses_held() and not self._vouched:
            self.doubt_unconfirmed(self._brought_by(job))
            raise CellFault("gripper_silent", "It has ceased to confirm the part on the way.")
        async with self._act(ActKind.PUT_BACK, job) as act:
            hands.expect_at(hands.routes.pick_stance())
            self._latch_moves(ActKind.PUT_BACK)
            await hands.open()
            act.moves = (Move.PUT_BACK,)
        self._belt.room_was_used()
        step, self._taken_step = self._brought_by(job), None
        job.standing = self.standing
        if step is None:
            self._count_from(None)
            return None
        outcome = self._outcome(step)
        job.outcomes.append(outcome)
        return outcome

    async def let_stand(self, job: Job) -> None:
        """Open the latch on a part that it has gripped and that shall stand where it does.

        Raises:
            CellFault: of the gripper, ``arm_moved``, or ``part_stuck``: it does not come off.
        """
        cell = self.ledger.gripped
        if cell is None or self.ledger.holding:
            return
        async with self._act(ActKind.LET_STAND, job):
            await self._leave_standing(cell, partial(self._travel, job=job))

    async def let_stand_by_hand(self, speed_fraction: float) -> bool:
        """As ``let_stand``, by an operator's order; False where nothing is gripped, or the open
        gripper was moved off the part already.

        Args:
            speed_fraction: share of the usual speed.

        Raises:
            CellFault: of the arm or the gripper, ``arm_moved``, or ``part_stuck``.
        """
        cell = self.ledger.gripped
        if cell is None or self.ledger.holding:
            return False
        if self._hands.is_told_open() and not self._hands.is_at(
            self._hands.routes.place_stance(cell)
        ):
            return False

        async def travel(plan: Callable[[Stance, frozenset[Cell]], Route]) -> None:
            await self._hands.travel(plan, self.standing, speed_fraction=speed_fraction)

        await self._leave_standing(cell, travel)
        return True

    async def _leave_standing(self, cell: Cell, travel: Travel) -> None:
        """Bring a part that is gripped, and may hang a little above its seat, back to it; open the
        latch, and feel that the gripper is free of it."""
        self._hands.expect_at(self._hands.routes.place_stance(cell))
        await travel(lambda start, placed: self._hands.routes.back_to_grip(cell, placed, start))
        await self._hands.open()
        await self._touch.free(cell, travel)

    async def retreat(self, job: Job) -> None:
        """Let a gripped part stand, then go up and home.

        Raises:
            CellFault: of the arm or the gripper.
        """
        await self.let_stand(job)
        if self.grip is Grip.PART:
            await self._travel_upright(job)
        await super().retreat(job)

    async def pick(self, job: Job) -> bool:
        """As ``Builder.pick``; a part that is gripped and shall stand is let go first.

        Raises:
            CellFault: of arm, belt or gripper.
        """
        await self.let_stand(job)
        return await super().pick(job)

    async def place(self, job: Job) -> bool:
        """As ``Builder.place``; a part that was cut off while it was tilted comes upright first.

        Raises:
            CellFault: of arm, belt or gripper; ``pick_missed`` when trying again did not help.
        """
        if not self.ledger.lift_unchecked:
            await self._travel_upright(job)
        return await super().place(job)

    async def _refuse_unknown_part(self) -> None:
        if self.ledger.gripped is None:
            await super()._refuse_unknown_part()

    async def _travel_upright(self, job: Job) -> None:
        """Leave a tilt that a movement was cut off in."""

        def upright(start: Stance, placed: frozenset[Cell]) -> Route:
            return self._hands.routes.upright(start, placed)

        await self._travel(upright, job)

    async def _intend(self, kind: ActKind, job: Job) -> int:
        if self._open_act is not None or kind not in {*_BACK, ActKind.LET_STAND}:
            return await super()._intend(kind, job)
        step = self._brought_by(job) if kind in _BACK else job.step
        cell = self.ledger.gripped if kind is ActKind.LET_STAND else None
        if cell is None and step is not None:
            cell = step.cell
        index = step.index if step is not None else None
        return await self._journal.intend(kind, job.job_id, index, cell)

    def _brought_by(self, job: Job) -> Step | None:
        """The step that took off the part which goes back; None where a job before this one left
        it in the gripper."""
        return self._taken_step or job.step_before

    def _start_clock(self) -> None:
        if self._part_began_s is None:
            self._part_began_s = self._clock.now_s()


def _taken(job: Job) -> Step:
    step = job.step
    assert step is not None, "taking off needs a step"
    assert step.kind is StepKind.REMOVE, "only a step that takes a part off"
    return step
