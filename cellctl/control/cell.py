"""What the cell does in each state, and the job it does it for.

``Cell`` is the work behind the machine: the controller calls ``run_stage`` for the state it is in,
and the stage reports with events. The physical stages are in ``building``; the others are here.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

import structlog

from cellctl.assembling.arm import Arm
from cellctl.assembly import BuildPlan, Intent, Request, Role, Utterance
from cellctl.clock import Clock
from cellctl.config import CellConfig
from cellctl.control import sentences
from cellctl.control.audio import audio_file
from cellctl.control.building import Builder
from cellctl.control.controller import Controller, Post
from cellctl.control.job import Job, Phase
from cellctl.control.states import Event, top_of
from cellctl.errors import CellctlError, CellFault, ExitStatus, NoObjectError
from cellctl.feeding.service import BeltService
from cellctl.generating.design import design
from cellctl.listening.hearing import Hearing
from cellctl.listening.request import read_request
from cellctl.messages import GripperData, Outcome, PartData, SpeechData, StateData, StatusData
from cellctl.validating.plan import plan_build, plan_file
from cellctl.worker import WorkerProcess

log = structlog.get_logger(__name__)

_OUTCOMES: dict[ExitStatus, Outcome] = {
    ExitStatus.USAGE: "unreadable",
    ExitStatus.NO_OBJECT: "no_object",
    ExitStatus.CANNOT_PLAN: "cannot_plan",
}
"""How a request ends that was refused with an error of this status."""
_DEVICE_PATIENCE_S = 30.0
"""Longest time for which one device may keep a stop or a reset waiting (wall time)."""


@dataclass(frozen=True)
class Devices:
    """The hardware, the stages' services, and the people's ears."""

    arm: Arm
    belt: BeltService
    hearing: Hearing
    designer: WorkerProcess


class Cell:
    """The stages of one cell and its present job.

    Args:
        config: the cell.
        clock: cell time.
        devices: what the stages work with.
        builder: the physical stages.
        publish: sends a status message; gets the data and the state.
    """

    def __init__(
        self,
        config: CellConfig,
        clock: Clock,
        devices: Devices,
        builder: Builder,
        publish: Callable[[StatusData, str], None],
    ) -> None:
        self.config = config
        self._clock = clock
        self._devices = devices
        self.builder = builder
        self._publish = publish
        self.controller = Controller(self, publish)
        self.job: Job | None = None
        self.started = False
        self.recogniser = "not loaded"
        self._audio: tuple[str, bytes] | None = None
        self._upload: tuple[str, bytes] | None = None
        self.last_state = StateData(state="starting", previous="", event="")
        self._stages: dict[str, Callable[[Post], Awaitable[None]]] = {
            "start": self._start,
            "hear": self._hear,
            "interpret": self._interpret,
            "generate": self._generate,
            "plan": self._plan,
            "confirm": self._confirm,
            "feed": self._feed,
            "pick": self._pick,
            "place": self._place,
            "verify": self._verify,
            "retreat": self._retreat,
            "brake": self._brake,
            "hold": self._hold,
            "recover": self._recover,
        }

    @property
    def active_job(self) -> Job | None:
        """The job under way; None when there is none or it has ended."""
        return self.job if self.job is not None and self.job.finished_s is None else None

    # --- what the request desk asks for -------------------------------------------------------

    def begin_text(self, utterance: Utterance, role: Role) -> None:
        """Start a job from words."""
        self._begin(Job(role, utterance=utterance))

    def begin_audio(self, name: str, wav: bytes, role: Role) -> None:
        """Start a job from a wav file."""
        self._audio = (name, wav)
        self._begin(Job(role))

    def begin_upload(self, name: str, content: bytes, role: Role) -> None:
        """Start a job from a mesh or plan file."""
        self._upload = (name, content)
        job = Job(role)
        job.phase = Phase.VALIDATING
        self._begin(job)

    def _begin(self, job: Job) -> None:
        job.end_of_speech_s = self._clock.now_s()
        self.job = job
        self.builder.begin()
        structlog.contextvars.bind_contextvars(job=job.job_id)
        log.info("job begins", role=job.role)

    def resume_event(self) -> Event:
        """Which variant of ``resume`` fits how far things have come."""
        if not self.started:
            return Event.RESUME_STARTING
        job = self.active_job
        return Event.RESUME_IDLE if job is None else job.resume_event(self.builder.grip)

    # --- what the controller asks for ---------------------------------------------------------

    async def run_stage(self, name: str, post: Post) -> None:
        """Run one stage; see ``Stages``."""
        await self._stages[name](post)

    def request_ended(self, error: CellctlError) -> None:
        """Keep the reason why a request ended, for the visitor."""
        job = self.job
        if job is not None:
            job.message = str(error)
            job.outcome = _OUTCOMES.get(error.exit_status, "failed")

    def changed(self, event: Event, before: str, after: str) -> None:
        """Keep the job's record in step with the machine, and tell everyone."""
        job = self.active_job
        if job is not None:
            self._follow(job, event, after)
        job = self.job
        self.last_state = StateData(
            state=after,
            previous=before,
            event=event.value,
            pausing=job is not None and job.pausing,
            cancelling=job is not None and job.cancelling,
            sentence=sentences.describe(
                after,
                job,
                self.controller.latched.fault if self.controller.latched else None,
                pitch_m=self.config.voxel.pitch_m,
            ),
        )
        log.info("state", event_name=event.value, before=before, after=after)
        self._publish(self.last_state, after)
        if job is not None:
            self._publish(job.view(), after)
        self._publish(GripperData(holding=self.builder.grip.value), after)

    def _follow(self, job: Job, event: Event, after: str) -> None:
        if event is Event.PAUSE and top_of(after) == "assembling":
            job.pausing = True
        elif top_of(after) in {"paused", "fault"}:
            job.pausing = False
        if event is Event.CANCEL and top_of(after) == "assembling":
            job.cancelling = True
        heard_in_vain = job.phase is Phase.HEARING and top_of(after) in {"paused", "fault"}
        cancelled = event is Event.CANCEL and top_of(after) == "paused"
        if cancelled:
            self.builder.settle_grip(job)
        if heard_in_vain:
            job.outcome = "failed"
            job.message = "I was interrupted; please say it again."
        if after == "idle" or cancelled or heard_in_vain:
            if event is Event.COMPLETED:
                done = job.step is None
                job.outcome = "built" if done else "cancelled"
                job.message = sentences.finished(job)
            elif event is Event.DECLINE:
                job.outcome = "declined"
                job.message = job.message or "All right, I shall not build it."
            elif event in {Event.CANCEL, Event.STOP}:
                job.outcome = "cancelled"
                job.message = sentences.cancelled(job)
            self._audio = self._upload = None
            job.finished_s = self._clock.now_s()
            log.info("job ends", outcome=job.outcome, message=job.message)
            structlog.contextvars.unbind_contextvars("job")

    # --- stages: devices ----------------------------------------------------------------------

    async def _start(self, post: Post) -> None:
        identity = await self._devices.arm.connect()
        log.info("robot connected", **identity.model_dump())
        await self._devices.belt.connect()
        self.builder.check_at_start()
        await self._devices.designer.call(_warm_up, timeout_s=60.0)

        def done() -> None:
            self.started = True

        post(Event.STARTED, done)

    async def _brake(self, post: Post) -> None:
        await self._halt_everything()
        post(Event.AT_REST)

    async def _hold(self, post: Post) -> None:  # noqa: ARG002 - every stage has the same form
        try:
            await self._halt_everything()
        except CellFault as fault:
            # The cell is in a fault already; its first cause is what counts.
            log.warning("while holding", reason=str(fault))

    async def _halt_everything(self) -> None:
        """Stop arm and belt, both even if one of them fails.

        Raises:
            CellFault: the arm or the belt could not be told to stop.
        """
        try:
            async with asyncio.timeout(_DEVICE_PATIENCE_S):
                results = await asyncio.gather(
                    self._devices.arm.stop(), self._devices.belt.halt(), return_exceptions=True
                )
        except TimeoutError:
            raise CellFault("robot_lost", "It does not confirm that it stopped.") from None
        for result in results:
            if isinstance(result, BaseException):
                raise result

    async def _recover(self, post: Post) -> None:
        await self._devices.arm.recover()
        await self._devices.belt.recover()
        post(Event.RECOVERED)

    # --- stages: from words to a plan ---------------------------------------------------------

    async def _hear(self, post: Post) -> None:
        job = self._job()
        assert self._audio is not None
        name, wav = self._audio
        self.recogniser = await self._devices.hearing.warm_up()
        post(Event.SPEECH_STARTED)
        log.info("listening", name=name, recogniser=self.recogniser)
        with audio_file(wav) as path:
            utterance = await self._devices.hearing.hear_wav(path)
        self._audio = None
        self._publish(SpeechData(utterance=utterance), self.controller.state)
        if not utterance.text:
            raise NoObjectError("I heard nothing that I could understand.", "Please say it again.")

        def keep() -> None:
            job.utterance = utterance

        post(Event.HEARD, keep)

    async def _interpret(self, post: Post) -> None:
        job = self._job()
        assert job.utterance is not None
        request = read_request(job.utterance.text, self.config.voxel.pitch_m)
        self._publish(SpeechData(utterance=job.utterance, request=request), self.controller.state)
        log.info("understood", intent=request.intent, phrase=request.phrase)
        job.request = request
        if request.intent is not Intent.DESIGN:
            raise NoObjectError(_restate(request))

        def keep() -> None:
            job.phase = Phase.GENERATING

        post(Event.UNDERSTOOD, keep)

    async def _generate(self, post: Post) -> None:
        job = self._job()
        assert job.request is not None
        generated = await self._devices.designer.call(
            design, job.request, self.config, timeout_s=self.config.planning.timeout_s
        )

        def keep() -> None:
            job.generated = generated
            job.phase = Phase.VALIDATING

        post(Event.DESIGNED, keep)

    async def _plan(self, post: Post) -> None:
        job = self._job()
        events = {"checking": Event.DISCRETISED, "sequencing": Event.CHECKED}
        reached: set[str] = set()

        def progress(name: str) -> None:
            if name in events and name not in reached:
                reached.add(name)
                post(events[name])

        plan = await self._planned(job, progress)
        for name in events:
            progress(name)

        def keep() -> None:
            job.plan = plan
            job.phase = Phase.CONFIRMING
            log.info("planned", title=plan.title, parts=plan.parts, plan=plan.plan_id)

        def keep_and_go() -> None:
            keep()
            job.phase = Phase.BUILDING

        if self.config.policy.confirmation == "waived":
            log.info("confirmation waived by policy: building without asking")
            post(Event.PLANNED_WAIVED, keep_and_go)
        else:
            post(Event.PLANNED, keep)

    async def _planned(self, job: Job, progress: Callable[[str], None]) -> BuildPlan:
        call = self._devices.designer.call
        timeout_s = self.config.planning.timeout_s
        available = self.builder.parts_available()
        if job.generated is not None:
            return await call(
                plan_build, job.generated, self.config, available,
                timeout_s=timeout_s, progress=progress,
            )  # fmt: skip
        assert self._upload is not None
        name, content = self._upload
        return await call(
            plan_file, name, content, self.config, available,
            timeout_s=timeout_s, progress=progress,
        )  # fmt: skip

    async def _confirm(self, post: Post) -> None:
        job = self._job()
        await self._clock.sleep(self.config.policy.confirmation_timeout_s)

        def silence() -> None:
            job.message = "Nobody said yes, so I shall not build it."

        post(Event.DECLINE, silence)

    # --- stages: part after part --------------------------------------------------------------

    async def _feed(self, post: Post) -> None:
        job = self._job()
        job.phase = Phase.BUILDING
        if job.cancelling:
            post(Event.WIND_UP)
            return
        if job.pausing:
            post(Event.PAUSE)
            return
        await self.builder.feed(job, near=lambda: post(Event.PART_NEAR))
        post(Event.PART_READY)

    async def _pick(self, post: Post) -> None:
        job = self._job()
        if job.pausing:
            post(Event.PAUSE_NOW)
            return
        picked = await self.builder.pick(job)
        post(Event.PICKED if picked else Event.PICK_AGAIN)

    async def _place(self, post: Post) -> None:
        job = self._job()
        if job.pausing:
            post(Event.PAUSE_NOW)
            return
        lifted = await self.builder.place(job)
        post(Event.PLACED if lifted else Event.PICK_AGAIN)

    async def _verify(self, post: Post) -> None:
        job = self._job()
        outcome = await self.builder.release(job)
        assert job.plan is not None
        self._publish(
            PartData(
                job_id=job.job_id, outcome=outcome, placed=job.placed, total=len(job.plan.steps)
            ),
            self.controller.state,
        )
        if job.step is None or job.cancelling:
            post(Event.WIND_UP)
        elif self._devices.belt.ready:
            post(Event.NEXT_PART_READY)
        else:
            post(Event.NEXT_PART_AWAITED)

    async def _retreat(self, post: Post) -> None:
        job = self._job()
        job.phase = Phase.RETREATING
        if job.pausing:
            post(Event.PAUSE_NOW)
            return
        await self._devices.belt.halt()
        await self.builder.retreat(job)
        post(Event.COMPLETED)

    def _job(self) -> Job:
        assert self.job is not None, "a stage of a job runs only with a job"
        return self.job


def _restate(request: Request) -> str:
    return request.reason or "That is no physical object. Please ask for a thing to build."


def _warm_up() -> None:
    """Runs in the worker: importing this module there has loaded the planner already."""
