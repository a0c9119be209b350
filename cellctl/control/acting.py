"""Acts of the arm in the journal, and what is believed of the part that is on its way.

Each act is written into the journal as an intent before it and an outcome after it. An act that is
cut off while the latch moves keeps its intent without an outcome until the devices, or a person,
can say how far it came; so nothing is done twice and no part is dropped, whatever ends, the daemon
included.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import structlog

from cellctl.assembly import Cell, Step, StepKind
from cellctl.clock import Clock
from cellctl.config import CellConfig
from cellctl.control.act_report import ActReport, called
from cellctl.control.acts import ActKind, Outcome
from cellctl.control.job import Grip, Job
from cellctl.control.journal import Journal
from cellctl.control.ledger import Ledger
from cellctl.control.moving import ArmAndLatch
from cellctl.control.recovery import Doubt, Evidence, moves_to, settle, unconfirmed
from cellctl.errors import CellFault, RefusedError, UsageError
from cellctl.feeding.inventory import Move
from cellctl.feeding.service import BeltService
from cellctl.messages import PartPlace

log = structlog.get_logger(__name__)

_CLOSING = frozenset({ActKind.PICK, ActKind.GRIP, ActKind.RELEASE})
"""Acts in which the latch is told to close; on a part that was let go, to find out whether it
stands."""


class Acting:
    """Keeps the journal of physical acts, and settles those that were cut off.

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

    @property
    def gripped(self) -> Cell | None:
        """The cell of the standing part that the gripper has hold of, or may have."""
        return self.ledger.gripped

    async def settle_cut(self, step: Step | None) -> None:
        """Decide what the acts came to that were cut off, by what the devices say now.

        What they cannot say is kept as ``doubt``.

        Args:
            step: the one that was under way.

        Raises:
            CellFault: ``gripper_holds``: the latch holds something nobody knows of; or a device
                does not answer.
        """
        if any(act.kind in _CLOSING for act in self._journal.unsettled()):
            # It may have been told a moment ago: what it will say counts, not what it says now.
            await self._hands.wait_closed()
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

    async def recover(self, part: PartPlace, job: Job | None) -> None:
        """An operator says where the part is that was on its way, in the job under way.

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
        cell = self._cell_of_held(job)
        if part == "cell" and cell is None and doubt.act_id is None:
            raise UsageError("No job is under way whose cell the part could be at.")
        if part == "gripper" and self._hands.is_told_open():
            raise UsageError("The latch is open, so the part cannot be in the gripper.")
        detail = f"an operator says: {part}"
        if doubt.act_id is not None:
            indexes = (await self._belt.state()).indexes if doubt.kind is ActKind.PICK else None
            self._journal.settle(doubt.act_id, outcome, detail, moves, indexes)
        elif moves:
            at = cell if part == "cell" else None
            await self._journal.record(ActKind.SETTLE, cell=at, detail=detail, moves=moves)
        self.doubt = self._open_act = None
        self._lifted = self._vouched = part == "gripper"

    def _cell_of_held(self, job: Job | None) -> Cell | None:
        """Where the part in the gripper stands if it is "at its cell": where it was taken off, as
        long as it does not go on to another cell."""
        step, taken_from = job.step if job is not None else None, self.ledger.taken_from
        goes_on = (
            job is not None
            and not job.cancelling
            and step is not None
            and step.kind is StepKind.PLACE
        )
        if taken_from is not None and not goes_on:
            return taken_from
        return step.cell if step is not None else None

    def part_is_missing(self, cell: Cell) -> None:
        """An operator says that a part no longer stands: whatever the latch was about to do with it
        is over."""
        open_act = self._open_act
        if open_act is None:
            return
        acts = {act.act_id: act for act in self._journal.unsettled()}
        if acts[open_act[0]].cell == cell:
            detail = "an operator says that the part is missing"
            self._journal.settle(open_act[0], "failed", detail)
            self.doubt = self._open_act = None

    def end_job(self) -> None:
        """No job waits for the part that the belt was asked for."""
        self._end_feed("interrupted", "the job has ended")

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

    # --- acts ----------------------------------------------------------------------------------

    def _end_feed(self, outcome: Outcome, detail: str = "") -> None:
        act_id, self._feed_act = self._feed_act, None
        if act_id is not None:
            self._journal.settle(act_id, outcome, detail)

    def _never_closed(self) -> None:
        """The act in which the latch may have been told to close: it was not, as its line tells."""
        assert self._open_act is not None, "such an act keeps its intent"
        (act_id, _), self._open_act = self._open_act, None
        self._journal.settle(act_id, "interrupted", "cut off before the latch was told to close")

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
