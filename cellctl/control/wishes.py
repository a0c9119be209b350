"""The stages from words to a plan that somebody has said yes to. Nothing moves in them."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import structlog

from cellctl.assembly import BuildPlan, Intent, Request, Role, StepKind, Utterance
from cellctl.clock import Clock
from cellctl.config import CellConfig
from cellctl.control.audio import audio_file
from cellctl.control.controller import Post
from cellctl.control.design_chain import BY_MYSELF, design_by_chain
from cellctl.control.designing import (
    at_pace,
    change_over,
    choose,
    design_another,
    plan_upload,
    redesign,
    take_apart,
)
from cellctl.control.job import Job, Phase
from cellctl.control.ledger import Ledger
from cellctl.control.plainly import plainly
from cellctl.control.proposals import Proposals
from cellctl.control.states import Event
from cellctl.errors import CellctlError, CellFault, DesignError, NoObjectError, PlanError
from cellctl.listening.hearing import Hearing
from cellctl.listening.translating import TranslatingInterpreter, Translator
from cellctl.listening.understanding.choosing import interpreter_for
from cellctl.listening.understanding.embedded import EmbeddedInterpreter
from cellctl.listening.understanding.interpreter import Interpreter, Setting
from cellctl.messages import SpeechData, StatusData
from cellctl.wording import Wording
from cellctl.worker import WorkerProcess

if TYPE_CHECKING:
    from cellctl.mesh import GeneratedMesh

log = structlog.get_logger(__name__)


class Wishes:
    """Turns what a person wants into a plan.

    Args:
        config: the cell.
        clock: cell time.
        hearing: the recogniser.
        designer: the process that designs and plans.
        show: publishes what was heard.
        ledger: what is believed of the cell's parts.
        wording: the messages of the cell's language.
    """

    def __init__(
        self,
        config: CellConfig,
        clock: Clock,
        *,
        hearing: Hearing,
        designer: WorkerProcess,
        show: Callable[[StatusData], None],
        ledger: Callable[[], Ledger],
        wording: Wording,
    ) -> None:
        self._config = config
        self._clock = clock
        self._hearing = hearing
        self._designer = designer
        self._show = show
        self._ledger = ledger
        self._wording = wording
        self._interpreter: Interpreter = interpreter_for(config)
        self._rules: Interpreter = EmbeddedInterpreter()
        if translator := Translator(wording.hearing.get("words", {})):
            self._interpreter = TranslatingInterpreter(self._interpreter, translator)
            self._rules = TranslatingInterpreter(self._rules, translator)
        self.recording: tuple[str, bytes] | None = None
        """Name and content of the recording to listen to; forgotten when it is heard."""
        self.recogniser = "not loaded"
        self.explain: Callable[[Utterance, Request], str] = lambda _, request: _restate(request)
        """Says to a visitor why a sentence begins no job."""

    async def hear(self, job: Job, post: Post) -> None:
        """Listen to the recording."""
        assert self.recording is not None
        name, wav = self.recording
        self.recogniser = await self._hearing.warm_up()
        post(Event.SPEECH_STARTED)
        log.info("listening", name=name, recogniser=self.recogniser)
        with audio_file(wav) as path:
            utterance = await self._hearing.hear_wav(path)
        self.recording = None
        self._show(SpeechData(utterance=utterance))
        if not utterance.text:
            raise NoObjectError("I heard nothing that I could understand.", "Please say it again.")

        def keep() -> None:
            job.utterance = utterance

        post(Event.HEARD, keep)

    async def understand(self, utterance: Utterance) -> Request:
        """Find out what words ask for, and show it."""
        # It may ask a service; the loop goes on meanwhile.
        request = await asyncio.to_thread(
            self._interpreter.interpret, utterance.text, Setting.of(self._config)
        )
        self._show(SpeechData(utterance=utterance, request=request))
        log.info("understood", intent=request.intent)
        return request

    async def reads_as_change(self, text: str) -> bool:
        """Whether words change a shape, such as ``make it taller``.

        By rules alone, and told to nobody: it may be talk that is not meant for the cell.
        """
        setting = Setting.of(self._config)
        request = await asyncio.to_thread(self._rules.interpret, text, setting)
        return request.intent is Intent.EDIT and not request.refusal

    async def interpret(self, job: Job, post: Post) -> None:
        """Find out what the words ask for."""
        assert job.utterance is not None
        request = await self.understand(job.utterance)
        request = job.request = request.with_nothing_to_change()
        if not request.buildable:
            raise NoObjectError(self.explain(job.utterance, request))

        def keep() -> None:
            job.phase = Phase.GENERATING

        post(Event.UNDERSTOOD, keep)

    async def generate(self, job: Job, post: Post) -> None:
        """Design the shape, or change it."""
        with _or_as_before(job, post):
            wish = await (self._another(job) if job.another else self._asked(job))
            generated = wish.generated
            log.info("designed", title=generated.title, provenance=generated.provenance)

            def keep() -> None:
                job.request, job.generated, job.message = wish.request, generated, ""
                job.proposals = wish.proposals
                job.phase = Phase.VALIDATING

            post(Event.DESIGNED, keep)

    async def _asked(self, job: Job) -> _Wish:
        """What was asked for, or the change that was."""
        request = job.change or job.request
        assert request is not None
        services: frozenset[str] = frozenset()
        if request.intent is Intent.EDIT:
            generated = await self._compute(redesign, job.generated, request, self._config)
            replaces = any(edit.op == "replace" for edit in request.edits)
            if job.request is not None and not replaces:
                edits = (*job.request.edits, *request.edits)
                request = job.request.model_copy(update={"edits": edits})
                if request.edits[-1].op == "undo":
                    request = _as_it_is_now(request, generated)
        else:
            tell = partial(self._tell, job)
            designed = await design_by_chain(request, self._config, self._compute, tell)
            generated = designed.mesh
            services = frozenset({designed.by} - BY_MYSELF)
        return _Wish(request, generated, Proposals(request, generated, services=services))

    async def _another(self, job: Job) -> _Wish:
        """Another shape for the same wish; services are asked when nothing else is left.

        Raises:
            DesignError: there is no other.
        """
        present = job.generated
        if present is None:
            raise DesignError("I have nothing else for it.", "Say what it should be.")
        wish = job.proposals if job.proposals.asked else Proposals(job.request, present)
        try:
            generated = await self._compute(design_another, present, wish, self._config)
        except DesignError:
            left = set(self._config.generating.chain) - BY_MYSELF - wish.services
            if wish.request is None or not left:
                raise
            skip, tell = BY_MYSELF | wish.services, partial(self._tell, job)
            # What is asked is paid for, whatever comes of it.
            job.proposals = replace(wish, services=wish.services | left)
            generated, by = await design_by_chain(
                wish.request, self._config, self._compute, tell, skip=skip
            )
            wish = replace(wish, services=wish.services | {by})
        return _Wish(job.request, generated, wish)

    def _compute(
        self, function: Callable[..., GeneratedMesh], *arguments: object
    ) -> Awaitable[GeneratedMesh]:
        """Run what computes in the designer process."""
        timeout_s = self._config.planning.timeout_s
        return self._designer.call(function, *arguments, timeout_s=timeout_s)

    def _tell(self, job: Job, line: str) -> None:
        """Show the visitor how far a service is."""
        job.message = self._wording.translated(line)
        log.info("designing", told=line)
        self._show(job.view())

    async def plan(self, job: Job, post: Post) -> None:
        """Make a plan that this cell can build."""
        events = {"checking": Event.DISCRETISED, "sequencing": Event.CHECKED}
        reached: set[str] = set()

        def progress(name: str) -> None:
            if name in events and name not in reached:
                reached.add(name)
                post(events[name])

        with _or_as_before(job, post):
            generated, plan = await self._planned(job, progress)
            for name in events:
                progress(name)
            self._ask(job, generated, plan, post)

    def _ask(self, job: Job, generated: GeneratedMesh | None, plan: BuildPlan, post: Post) -> None:
        """Ask whether to build it, unless the policy says yes already."""

        def keep() -> None:
            job.generated, job.plan = generated, plan
            job.end_change()
            job.phase = Phase.CONFIRMING
            log.info("planned", title=plan.title, parts=plan.parts, plan=plan.plan_id)

        def keep_and_go() -> None:
            keep()
            job.phase = Phase.BUILDING

        if self._config.policy.confirmation == "waived":
            log.info("confirmation waived by policy: building without asking")
            takes = bool(plan.steps) and plan.steps[0].kind is StepKind.REMOVE
            post(Event.PLANNED_TAKING if takes else Event.PLANNED_WAIVED, keep_and_go)
        else:
            post(Event.PLANNED, keep)

    async def _planned(
        self, job: Job, progress: Callable[[str], None]
    ) -> tuple[GeneratedMesh | None, BuildPlan]:
        """A plan and the shape that it is for; where something stands, one that changes it over."""
        call = self._designer.call
        timeout_s = self._config.planning.timeout_s
        ledger = self._ledger()
        standing, counts = ledger.standing, ledger.counts
        # A part in the gripper will be laid back, or built in: it counts as on the belt.
        on_belt = counts.belt + counts.gripper
        if job.takes_apart:
            return None, await call(
                take_apart, standing, self._config, on_belt,
                timeout_s=timeout_s, progress=progress,
            )  # fmt: skip
        available = counts.available + len(standing)
        generated = job.generated
        if generated is not None:
            generated, plan = await self._chosen(job, generated, available, progress)
        else:
            assert job.upload is not None
            name, content = job.upload_name, job.upload
            if job.pace is not None and standing:
                raise PlanError(
                    "A trial begins with an empty workspace.", "Say `cellctl take-apart` first."
                )
            plan = await call(
                plan_upload, name, content, self._config, available,
                timeout_s=timeout_s, progress=progress,
            )  # fmt: skip
            if job.pace is not None:
                plan = await call(at_pace, plan, job.pace, self._config, timeout_s=timeout_s)
        if standing:
            plan = await call(
                change_over, plan, standing, self._config, on_belt, timeout_s=timeout_s
            )
        return generated, plan

    async def _chosen(
        self, job: Job, first: GeneratedMesh, available: int, progress: Callable[[str], None]
    ) -> tuple[GeneratedMesh, BuildPlan]:
        """The shape, or a better one for the same wish, and its plan.

        Raises:
            CellctlError: why none can be planned.
        """
        config, wish = self._config, job.proposals
        planning = config.planning
        if job.another:
            # Who asks for another one has had a first answer, and can wait longer.
            longer = planning.model_copy(update={"others_budget_s": planning.budget_s})
            config = config.model_copy(update={"planning": longer})
        chosen = await self._designer.call(
            choose, first, wish, config, available, timeout_s=planning.timeout_s, progress=progress
        )
        job.proposals = replace(wish, shown=wish.shown | chosen.tried)
        if chosen.plan is None:
            assert chosen.refusal is not None, "what has no plan was refused"
            raise chosen.refusal
        return chosen.mesh or first, chosen.plan

    async def confirm(self, job: Job, post: Post) -> None:
        """Wait for a yes; silence means no."""
        await self._clock.sleep(self._config.policy.confirmation_timeout_s)

        def silence() -> None:
            job.message = self._wording.text("done.silence")

        post(Event.DECLINE, silence)


def _as_it_is_now(request: Request, generated: GeneratedMesh) -> Request:
    """A wish that names what a change back has restored, which may be another object."""
    made = generated.description
    noun = (getattr(made, "noun", "") or getattr(made, "family", "")) if made else ""
    if not noun or noun in request.objects:
        return request
    assert made is not None, "it has a noun"
    return request.model_copy(
        update={"phrase": noun, "objects": (noun,), "attributes": getattr(made, "attributes", {})}
    )


class _Wish(NamedTuple):
    """What is wanted, as it was designed."""

    request: Request | None
    generated: GeneratedMesh
    proposals: Proposals


@contextmanager
def _or_as_before(job: Job, post: Post) -> Iterator[None]:
    """Where a change cannot be designed or planned, what was planned before stands."""
    try:
        yield
    except CellFault:
        raise
    except CellctlError as error:
        if job.before is None:
            raise
        log.info("change not made", reason=str(error))
        why = str(error) if job.role is Role.OPERATOR else plainly(error)
        post(Event.KEPT, lambda: job.undo_change(why))


def _restate(request: Request) -> str:
    return (
        request.refusal
        or request.reason
        or "That is no physical object. Please ask for a thing to build."
    )
