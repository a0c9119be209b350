"""What the cell does in each state, and the job it does it for.

``Cell`` is the work behind the machine: the controller calls ``run_stage`` for the state it is in,
and the stage reports with events. The physical stages are in ``building``; the others are here.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import structlog

from cellctl.assembly import Cell as CellIndex
from cellctl.assembly import PartOutcome, Role
from cellctl.clock import Clock
from cellctl.config import CellConfig
from cellctl.control.acts import ActKind, JobFiles
from cellctl.control.controller import Controller, Post
from cellctl.control.devices import Devices
from cellctl.control.dismantling import Dismantler
from cellctl.control.gripper_watch import GripperWatch
from cellctl.control.hand import HandMoves
from cellctl.control.job import Job, Phase
from cellctl.control.journal import Journal
from cellctl.control.possible import possible
from cellctl.control.recalled import recalled_job
from cellctl.control.sentences import Sentences
from cellctl.control.states import Event, top_of
from cellctl.control.taking_apart import TakingApart
from cellctl.control.wishes import Wishes
from cellctl.errors import CellctlError, CellFault, ExitStatus, RefusedError
from cellctl.feeding.inventory import Counts, Move
from cellctl.messages import Outcome, PartData, PartPlace, StateData, StatusData
from cellctl.wording import Wording

log = structlog.get_logger(__name__)

_WORKING = frozenset({"assembling", "disassembling"})
_OUTCOMES: dict[ExitStatus, Outcome] = {
    ExitStatus.USAGE: "unreadable",
    ExitStatus.NO_OBJECT: "no_object",
    ExitStatus.CANNOT_PLAN: "cannot_plan",
}
"""How a request ends that was refused with an error of this status."""


class Cell:
    """The stages of one cell and its present job.

    Args:
        config: the cell.
        clock: cell time.
        devices: what the stages work with.
        builder: the physical stages.
        journal: where jobs are written.
        publish: sends a status message; gets the data and the state.
        wording: the messages of the cell's language.
    """

    def __init__(
        self,
        config: CellConfig,
        clock: Clock,
        *,
        devices: Devices,
        builder: Dismantler,
        journal: Journal,
        publish: Callable[[StatusData, str], None],
        wording: Wording,
    ) -> None:
        self.config = config
        self._clock = clock
        self._devices = devices
        self.builder = builder
        self._journal = journal
        self._publish = publish
        self.sentences = Sentences(
            wording,
            config.voxel.pitch_m,
            config.dialogue.copies_limit,
            lambda: builder.ledger.counts.available + len(builder.standing),
        )
        self.line = wording.line("state.starting")
        """The present state in words, as visitors are told of it."""
        self.controller = Controller(self, publish)
        self.wishes = Wishes(
            config,
            clock,
            hearing=devices.hearing,
            designer=devices.designer,
            show=lambda data: publish(data, self.controller.state),
            ledger=lambda: builder.ledger,
            wording=wording,
        )
        self._taking_apart = TakingApart(
            builder,
            check=self._check_before_motion,
            show=self._show_part,
            next_event=self._next_event,
        )
        self.hand = HandMoves(builder, devices.hands, devices.belt, journal)
        self.job: Job | None = None
        self._asks_hand_over = False
        self._checked = False
        """The robot and the belt were looked over since the last rest."""
        self._kept_files: JobFiles | None = None
        """What the journal has of the present job's files."""
        self.started = False
        self.left_starting = asyncio.Event()
        """Set when the devices were found, or were not."""
        self.been_idle = asyncio.Event()
        """Set when a wish could first be taken."""
        self.last_state = StateData(
            state="starting", previous="", event="", commands=possible("starting")
        )
        self._stages: dict[str, Callable[[Post], Awaitable[None]]] = {
            "start": self._start,
            "hear": self._for_job(self.wishes.hear),
            "interpret": self._for_job(self.wishes.interpret),
            "generate": self._for_job(self.wishes.generate),
            "plan": self._for_job(self.wishes.plan),
            "confirm": self._for_job(self.wishes.confirm),
            "feed": self._feed,
            "refill": self._refill,
            "pick": self._pick,
            "place": self._place,
            "verify": self._verify,
            "retreat": self._retreat,
            "grip": self._for_job(self._taking_apart.grip),
            "part": self._for_job(self._taking_apart.part),
            "return": self._for_job(self._taking_apart.bring_back),
            "put_back": self._for_job(self._taking_apart.put_back),
            "brake": self._brake,
            "hand": self._hand,
            "hold": self._hold,
            "recover": self._recover,
        }

    @property
    def gripper_board(self) -> GripperWatch:
        """The board of the gripper, beside its lines."""
        return self._devices.gripper_board

    @property
    def active_job(self) -> Job | None:
        """The job under way; None when there is none or it has ended."""
        return self.job if self.job is not None and self.job.finished_s is None else None

    # --- what the request desk asks for -------------------------------------------------------

    def begin_audio(self, name: str, wav: bytes, role: Role, owner: str = "") -> None:
        """Start a job from a wav file."""
        self.wishes.recording = (name, wav)
        self.begin(Job(role, owner=owner))

    def begin(self, job: Job) -> None:
        """Start a job."""
        job.end_of_speech_s = self._clock.now_s()
        job.began_at = self._clock.wall_time()
        job.standing = self.builder.standing
        self.job, self._kept_files = job, None
        self.builder.begin()
        self._keep(job)
        structlog.contextvars.bind_contextvars(job=job.job_id)
        log.info("job begins", role=job.role)

    def _keep(self, job: Job) -> None:
        """Write the job down; its files only when they are new."""
        files = JobFiles(mesh=job.generated, upload=job.upload)
        self._journal.keep_job(job.record(), files if files != self._kept_files else None)
        self._kept_files = files

    def resume_event(self) -> Event:
        """Which variant of ``resume`` fits how far things have come."""
        if not self.started:
            return Event.RESUME_STARTING
        job = self.active_job
        if job is None:
            return Event.RESUME_IDLE
        if self.builder.putting_back_cut_off:
            # Whatever the plan wants next: a job that is cancelled may have one part to place.
            return Event.RESUME_PUTTING_BACK
        return job.resume_event(self.builder.grip, self.builder.gripped)

    async def record(
        self,
        kind: ActKind,
        *,
        at: CellIndex | None = None,
        detail: str = "",
        moves: tuple[Move, ...] = (),
        counts: Counts | None = None,
    ) -> None:
        """Write down what a person says of parts, and tell everyone; see ``Journal.record``."""
        job = self.active_job
        await self._journal.record(
            kind,
            job_id=job.job_id if job is not None else "",
            cell=at,
            detail=detail,
            moves=moves,
            counts=counts,
        )
        self._stood_anew()

    async def recover_part(self, part: PartPlace) -> None:
        """An operator says where the part is that was on its way; see ``Builder.recover``."""
        await self.builder.recover(part, self.active_job)
        self._stood_anew()

    async def resume_doubt(self) -> None:
        """Whoever resumes takes for granted what is believed of the part in doubt.

        Raises:
            RefusedError: a part should be in the gripper, and its latch is no longer confirmed; the
                next ``resume`` takes for granted that it is.
        """
        if self.builder.doubt is None and self.builder.misses_held():
            job = self.active_job
            self.builder.doubt_unconfirmed(job.step if job is not None else None)
            self.tell()
            raise RefusedError(self.last_state.sentence)
        if self.builder.doubt is not None:
            await self.recover_part(self.builder.doubt.believed)

    def _stood_anew(self) -> None:
        """What stands has changed by a person's word."""
        if self.job is not None and self.job.finished_s is None:
            self.job.standing = self.builder.standing
        self.tell()

    def asks_hand_over(self, asked: bool) -> None:
        """The conversation asks whether somebody takes along what stands, or no longer does."""
        if asked is not self._asks_hand_over:
            self._asks_hand_over = asked
            at = self.controller.state
            changed = {"commands": self._possible(at), "state": at, "previous": at}
            self.last_state = self.last_state.model_copy(update=changed)
            self._publish(self.last_state, at)

    def _possible(self, state: str) -> tuple[str, ...]:
        apart = self.active_job is not None and self.active_job.takes_apart
        return possible(state, asks_hand_over=self._asks_hand_over, takes_apart=apart)

    def tell(self) -> None:
        """Publish the state anew: something changed that the machine does not know of."""
        self._tell(self.last_state.event, self.last_state.previous, self.controller.state)

    # --- what the controller asks for ---------------------------------------------------------

    async def run_stage(self, name: str, post: Post) -> None:
        """Run one stage; see ``Stages``."""
        await self._stages[name](post)

    def request_ended(self, error: CellctlError) -> None:
        """Keep the reason why a request ended, for the visitor."""
        if (job := self.job) is not None:
            log.info("not possible", reason=str(error))
            job.message = self.sentences.refusal(error, job.role)
            job.outcome = _OUTCOMES.get(error.exit_status, "failed")

    def changed(self, event: Event, before: str, after: str) -> None:
        """Keep the job's record in step with the machine, and tell everyone."""
        if after != "starting":
            self.left_starting.set()
        if before == "paused_moving" and after != before:
            self.hand.left()
        if after == "idle":
            self.been_idle.set()
        by_hand = {before, after} == {"paused_resting", "paused_moving"}
        if top_of(after) in {"idle", "paused", "fault"} and not by_hand:
            self._checked = False
        job = self.active_job
        if job is not None:
            self._follow(job, event, after)
            self._keep(job)
        log.info("state", event_name=event.value, before=before, after=after)
        self._tell(event.value, before, after)

    def _tell(self, event: str, before: str, after: str) -> None:
        job = self.job
        fault = self.controller.latched.fault if self.controller.latched else None
        told = self.sentences.describe(
            after,
            job,
            fault,
            self.builder.doubt,
            self.builder.ledger,
            recalled=event == Event.RECALLED.value,
        )
        self.line = self.sentences.for_visitors(after, fault) or told
        self.last_state = StateData(
            state=after,
            previous=before,
            event=event,
            pausing=job is not None and job.pausing,
            cancelling=job is not None and job.cancelling,
            commands=self._possible(after),
            sentence=told.text,
        )
        self._publish(self.last_state, after)
        if job is not None:
            self._publish(job.view(), after)
        self._publish(self._devices.gripper_board.view(self.builder.grip.value), after)

    def _follow(self, job: Job, event: Event, after: str) -> None:
        if event is Event.PAUSE and top_of(after) in _WORKING:
            job.pausing = True
        elif top_of(after) in {"paused", "fault"}:
            job.pausing = False
        if event is Event.CANCEL and top_of(after) in _WORKING:
            job.cancelling = True
        heard_in_vain = job.phase is Phase.HEARING and top_of(after) in {"paused", "fault"}
        if event is Event.CANCEL and after == "paused_braking":
            job.cancelling = True
        cancelled = event is Event.AT_REST and job.cancelling
        if heard_in_vain:
            job.outcome = "failed"
            job.message = self.sentences.wording.text("done.interrupted")
        if after == "idle" or cancelled or heard_in_vain:
            if event is Event.COMPLETED:
                job.outcome = job.outcome_when_home()
                job.message = self.sentences.finished(job)
            elif event is Event.DECLINE:
                job.outcome = "declined"
                job.message = job.message or self.sentences.wording.text("done.declined")
            elif event in {Event.CANCEL, Event.STOP, Event.AT_REST}:
                job.outcome = "cancelled"
                job.message = self.sentences.cancelled(job)
            self.wishes.recording = None
            job.finished_s = self._clock.now_s()
            job.finished_at = self._clock.wall_time()
            self.builder.end_job()
            log.info("job ends", outcome=job.outcome, message=job.message)
            structlog.contextvars.unbind_contextvars("job")

    # --- stages: devices ----------------------------------------------------------------------

    async def _start(self, post: Post) -> None:
        await self._journal.start()
        await self._journal.flush()
        await self._devices.connect()
        job = self._recall()
        await self.builder.settle_cut(job.step if job is not None else None)
        if job is not None:
            job.standing = self.builder.standing

        def done() -> None:
            self.started = True

        def recalled() -> None:
            self.started = True
            self.job = job

        if job is None and self.builder.doubt is None:
            post(Event.STARTED, done)
        else:
            post(Event.RECALLED, recalled)

    def _recall(self) -> Job | None:
        """The job to go on with: this daemon's own, or one that an earlier one did not finish."""
        interrupted = self.sentences.wording.text("done.interrupted")
        return self.active_job or recalled_job(
            self._journal, self._clock, self.builder.standing, interrupted
        )

    async def _brake(self, post: Post) -> None:
        await self._devices.halt()
        job = self.active_job
        if job is not None and job.cancelling:
            await self.controller.stage_before_ended()
            await self.builder.settle_cut(job.step)
            job.standing = self.builder.standing
        post(Event.AT_REST)

    async def _hand(self, post: Post) -> None:
        await self._check_before_motion()
        await self.hand.run(post)

    async def _hold(self, post: Post) -> None:  # noqa: ARG002 - every stage has the same form
        try:
            await self._devices.halt()
        except CellFault as fault:
            # The cell is in a fault already; its first cause is what counts.
            log.warning("while holding", reason=str(fault))

    async def _recover(self, post: Post) -> None:
        if not self._journal.is_open:
            # Another file may be there now: what it says counts, as after a death.
            await self._journal.start()
            self.started, self.job = False, None
        await self._journal.flush()
        await self._devices.recover()
        post(Event.RECOVERED)

    # --- stages: part after part --------------------------------------------------------------

    async def _refill(self, post: Post) -> None:  # noqa: ARG002 - every stage has the same form
        """Wait for parts on the belt; ``refill`` leads on."""
        await self._clock.sleep(self.config.policy.refill_timeout_s)
        raise CellFault("belt_empty", "Nobody has laid parts on it.")

    async def _feed(self, post: Post) -> None:
        job = self._job()
        job.phase = Phase.BUILDING
        if job.cancelling or job.step is None:
            post(Event.WIND_UP)
            return
        if job.pausing:
            post(Event.PAUSE)
            return
        await self._check_before_motion()
        if self.builder.belt_is_empty():
            post(Event.BELT_EMPTY)
            return
        if await self.builder.in_the_way():
            # Picking finds nothing, makes way, and asks again.
            post(Event.PART_READY)
            return
        await self.builder.feed(job, near=lambda: post(Event.PART_NEAR))
        post(Event.PART_READY)

    async def _pick(self, post: Post) -> None:
        job = self._job()
        if job.pausing:
            post(Event.PAUSE_NOW)
            return
        await self._check_before_motion()
        picked = await self.builder.pick(job)
        post(Event.PICKED if picked else Event.PICK_AGAIN)

    async def _place(self, post: Post) -> None:
        job = self._job()
        if job.pausing:
            post(Event.PAUSE_NOW)
            return
        await self._check_before_motion()
        lifted = await self.builder.place(job)
        post(Event.PLACED if lifted else Event.PICK_AGAIN)

    async def _verify(self, post: Post) -> None:
        job = self._job()
        await self._check_before_motion()
        outcome = await self.builder.release(job)
        self._show_part(job, outcome)
        post(self._next_event(job))

    def _show_part(self, job: Job, outcome: PartOutcome) -> None:
        assert job.plan is not None, "a job with steps has a plan"
        total = len(job.plan.steps)
        self._publish(
            PartData(job_id=job.job_id, outcome=outcome, placed=job.placed, total=total),
            self.controller.state,
        )

    def _next_event(self, job: Job) -> Event:
        """What leads from a step that is done to the next one, or home."""
        if job.step is None or job.cancelling:
            return Event.WIND_UP
        if job.takes:
            return Event.NEXT_PART_STANDS
        return Event.NEXT_PART_READY if self._devices.belt.ready else Event.NEXT_PART_AWAITED

    async def _retreat(self, post: Post) -> None:
        job = self._job()
        job.phase = Phase.RETREATING
        if job.pausing:
            post(Event.PAUSE_NOW)
            return
        await self._devices.belt.halt()
        await self._check_before_motion()
        await self.builder.retreat(job)
        post(Event.COMPLETED)

    async def _check_before_motion(self) -> None:
        """Before the first motion of a job, and again after each pause and fault: the robot and the
        belt are what the plan is for.

        Raises:
            CellFault: ``robot_mismatch``, ``belt_mismatch`` or of a device that does not answer.
        """
        if self._checked:
            return
        await self._devices.verify()
        self._checked = True

    def _for_job(
        self, stage: Callable[[Job, Post], Awaitable[None]]
    ) -> Callable[[Post], Awaitable[None]]:
        return lambda post: stage(self._job(), post)

    def _job(self) -> Job:
        assert self.job is not None, "a stage of a job runs only with a job"
        return self.job
