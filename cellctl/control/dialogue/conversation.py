"""The conversation at work: what somebody says goes through the table, and its act is done."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import replace
from datetime import timedelta

import structlog

from cellctl.assembly import Intent, Request, Role, Utterance
from cellctl.clock import Clock
from cellctl.control.cell import Cell
from cellctl.control.commands import Commands
from cellctl.control.dialogue.answering import Answering
from cellctl.control.dialogue.answers import Answers
from cellctl.control.dialogue.board import DialogueBoard
from cellctl.control.dialogue.explaining import Explainer
from cellctl.control.dialogue.names import Names
from cellctl.control.dialogue.naming import Naming
from cellctl.control.dialogue.reading import Phrasebook, Reading
from cellctl.control.dialogue.said import Said, Who, is_for_all
from cellctl.control.dialogue.table import Act, Input, Place, decide
from cellctl.control.dialogue.transcript import Transcript
from cellctl.control.dialogue.turns import Turns
from cellctl.control.job import Job
from cellctl.control.states import Event
from cellctl.errors import CellctlError, RefusedError
from cellctl.messages import StateData, StatusData
from cellctl.wording import Line

log = structlog.get_logger(__name__)

_TICK_S = 0.25
"""How often time-outs and turns are looked at (wall time)."""


class Conversation:
    """Talks with the people in front of the cell, and with those at their screens.

    Args:
        cell: what the talk is about.
        board: what people see and hear of it.
        commands: carries words of command out.
        turns: the wishes that wait.
        clock: cell time.
        transcript: keeps what is said, where the policy says so.
    """

    def __init__(
        self,
        cell: Cell,
        board: DialogueBoard,
        *,
        commands: Commands,
        turns: Turns,
        clock: Clock,
        transcript: Transcript,
    ) -> None:
        self._cell = cell
        self._board = board
        self._commands = commands
        self._turns = turns
        self._clock = clock
        self._transcript = transcript
        self._wording = cell.sentences.wording
        self._naming = Naming(self._wording)
        self.phrasebook = Phrasebook(self._wording)
        self._answers = Answers(cell, lambda: turns.entries)
        self._explainer = Explainer(self._wording, clock)
        self._names = Names(clock.now_s)
        self._place = Place.STARTING
        self._deadline_s = 0.0
        cell.wishes.explain = self.explain
        answering = Answering(cell, board, commands=commands, turns=turns)
        self._acts: dict[Act, Callable[[Said], Awaitable[Line]]] = {
            Act.UNDERSTAND: self._understand,
            Act.BEGIN: self._begin,
            Act.BEGIN_AGAIN: self._begin_again,
            Act.QUEUE: self._queue,
            Act.QUEUE_AGAIN: self._queue_again,
            Act.CHANGE: self._change,
            Act.ANOTHER: self._another,
            Act.CONFIRM: answering.confirm,
            Act.DECLINE: answering.decline,
            Act.ASK_HAND_OVER: answering.ask_hand_over,
            Act.HAND_OVER: answering.hand_over,
            Act.LEAVE: answering.leave,
            Act.ANSWER: self._answer,
            Act.REPEAT: self._repeat,
            Act.KEEP_NAME: self._keep_name,
            Act.CANCEL: self._cancel,
            Act.EXPLAIN: self._explain,
            Act.EXPLAIN_ANSWER: self._explain_answer,
            Act.EXPLAIN_STATE: self._explain_state,
            Act.HELP: self._help,
            Act.NOTHING_ASKED: self._refuse("explain.nothing_asked"),
            Act.EXPLAIN_CHANGE: self._refuse("explain.change"),
            Act.NOT_YOURS: self._refuse("explain.not_yours"),
            Act.TAKE_APART: self._command,
            Act.STOP: self._command,
            Act.PAUSE: self._command,
            Act.RESUME: self._command,
        }

    # --- doors ---------------------------------------------------------------------------------

    @property
    def asked(self) -> str:
        """Name of the question that is open; empty for none."""
        return self._board.questions.open

    @property
    def asks(self) -> bool:
        """Whether a yes or a no would be an answer now."""
        return self._follow() in {Place.ASKING_BUILD, Place.ASKING_APART, Place.ASKING_HAND_OVER}

    async def is_change(self, text: str) -> bool:
        """Whether words ask for something else than what the one in front is asked about now.

        The plan is only asked about again for them, and nothing moves.
        """
        job = self._cell.active_job
        if self._follow() is not Place.ASKING_BUILD or job is None or job.owner:
            return False
        said = self.phrasebook.read(text).said
        if said is not Input.SENTENCE:
            return said is Input.ANOTHER
        return await self._cell.wishes.reads_as_change(text)

    async def hear(self, utterance: Utterance, begun_s: float) -> str:
        """Do what somebody said in front of the cell; returns what the cell says to it.

        Args:
            utterance: what was heard.
            begun_s: when that speech began (monotonic): a yes is for what was asked by then.

        Raises:
            CellctlError: why it is not done.
        """
        answers = self._board.questions.meant(begun_s)
        return await self.take(utterance, Role.VISITOR, answers=answers)

    async def take(
        self, utterance: Utterance, role: Role, owner: str = "", *, answers: str | None = None
    ) -> str:
        """Do what somebody said, typed or spoken; returns what the cell says to it.

        Args:
            utterance: what was said.
            role: of the one who says it.
            owner: mark of that visitor.
            answers: name of the question that a yes would be for; None: of whichever is open.

        Raises:
            CellctlError: why it is not done.
        """
        reading = self.phrasebook.read(utterance.text)
        if reading.said is not Input.SENTENCE:
            self._explainer.understood()
        self._board.heard(utterance.text)
        self._names.heard(owner, at_work=self._has_job(owner))
        self._transcript.keep(role.value, utterance.text)
        return await self._say(Said(Who(role, owner), utterance, reading, answers=answers))

    async def press(
        self, said: Input, role: Role, owner: str = "", *, answers: str | None = None
    ) -> str:
        """Do what a button says; see ``take``.

        Raises:
            CellctlError: why it is not done.
        """
        if said in {Input.TAKE_APART, Input.HAND_OVER}:
            self._board.heard("")  # what was said before is about something else
        self._names.heard(owner, at_work=self._has_job(owner))
        pressed = Utterance(text=said.value.replace("_", " "), source="text")
        return await self._say(Said(Who(role, owner), pressed, Reading(said), answers=answers))

    def drop(self, ticket: int) -> str:
        """Forget one wish that waits, whosever it is; returns what is said of it.

        Raises:
            RefusedError: none has that number.
        """
        dropped = self._turns.remove(ticket)
        if dropped is None:
            raise RefusedError(self._wording.text("queue.no_such", ticket=ticket))
        self._board.refresh()
        return self._wording.text("queue.dropped_by_operator", wish=dropped.wish)

    async def run(self) -> None:
        """Look after time-outs and turns until cancelled."""
        self._turns.recall()
        while True:
            await asyncio.sleep(_TICK_S)
            try:
                await self.tick()
            except CellctlError as error:
                log.info("turn not begun", reason=str(error))

    async def tick(self) -> None:
        """What time brings: silence that means no, turns, and wishes that expire."""
        place = self._follow()
        if place is Place.ASKING_HAND_OVER and self._clock.now_s() >= self._deadline_s:
            nobody = Utterance(text="", source="text")
            await self._say(Said(Who(Role.VISITOR), nobody, Reading(Input.SILENCE)))
        for entry in self._turns.expire():
            self._board.say(self._wording.line("queue.expired", wish=entry.wish))
        at_rest = place is Place.READY and self._cell.controller.state == "idle"
        turn = self._turns.next(at_rest=at_rest, standing=bool(self._cell.builder.standing))
        if turn is None:
            return
        entry = turn.entry
        job = Job(Role.VISITOR, utterance=turn.utterance, owner=entry.owner)
        job.owner_name = entry.name
        try:
            await self._cell.controller.command(Event.SAY, lambda: self._cell.begin(job))
        except RefusedError:
            self._turns.put_back(turn)
            raise
        key = "queue.turn_named" if entry.name else "queue.turn"
        fields = {"name": entry.name} if entry.name else {}
        self._board.say(self._wording.line(key, wish=entry.wish, **fields))

    def tell(self, text: str) -> None:
        """Say something in the cell's language that is no answer: no words were made out."""
        self._transcript.keep("cell", text)
        self._board.say(Line(key="told", text=text, language=self._wording.language))

    def note(self, data: StatusData) -> None:
        """Something was published: the machine may have gone elsewhere."""
        if isinstance(data, StateData):
            self._follow()
        self._board.note(data)

    def explain(self, utterance: Utterance, request: Request) -> str:
        """Why a sentence begins no job; an answer where it was a question."""
        reading = self.phrasebook.read(utterance.text)
        if reading.topic is not None:
            return self._answers.answer(reading.topic, Place.READY).text
        return self._explainer.explain(request, typed=utterance.source == "text").text

    # --- the table at work ---------------------------------------------------------------------

    def _follow(self) -> Place:
        """Go where the machine has gone."""
        before = self._place
        self._place = decide(before, self._board.scene().input).place
        if before is Place.ASKING_HAND_OVER and self._place is not before:
            self._board.ask_hand_over(None)
        return self._place

    async def _say(self, said: Said) -> str:
        """Decide, act, and say what comes of it."""
        try:
            line = await self._decide(said)
        except CellctlError as error:
            message, hint = map(self._wording.translated, (error.message, error.hint))
            text = f"{message} {hint}".strip()
            self._transcript.keep("cell", text)
            self._board.say(Line(key="refused", text=text, language=self._wording.language))
            if isinstance(error, RefusedError):
                raise RefusedError(message, hint) from error
            raise
        if is_for_all(line, self._follow()):
            self._board.say(line)
        self._transcript.keep("cell", line.text)
        return line.text

    async def _decide(self, said: Said) -> Line:
        place = self._follow()
        decision = decide(place, said.reading.said, stranger=self._is_stranger(said.who))
        log.info("conversation", place=place, said=said.reading.said, act=decision.act)
        line = await self._acts[decision.act](said)
        if decision.place is not place:
            self._arrive(decision.place, line)
        return line

    def _arrive(self, place: Place, line: Line) -> None:
        self._place = place
        if place is Place.ASKING_HAND_OVER:
            config = self._cell.config
            open_s = config.policy.confirmation_timeout_s
            self._deadline_s = self._clock.now_s() + open_s
            wall = timedelta(seconds=open_s / config.cell.clock_rate)
            self._board.ask_hand_over(self._clock.wall_time() + wall, line)
        else:
            self._board.ask_hand_over(None)
        self._follow()

    def _has_job(self, owner: str) -> bool:
        job = self._cell.active_job
        return job is not None and job.owner == owner

    def _is_stranger(self, who: Who) -> bool:
        job = self._cell.active_job
        if job is None or who.role is Role.OPERATOR:
            return False
        # An operator's job is asked about in front of the cell, and nowhere else.
        return job.owner != who.owner

    def _line(self, key: str, **fields: object) -> Line:
        return self._wording.line(key, **fields)

    def _refuse(self, key: str, hint: str = "") -> Callable[[Said], Awaitable[Line]]:
        async def refuse(_said: Said) -> Line:
            raise RefusedError(self._wording.text(key), hint and self._wording.text(hint))

        return refuse

    # --- wishes --------------------------------------------------------------------------------

    async def _understand(self, said: Said) -> Line:
        request = await self._cell.wishes.understand(said.utterance)
        kinds = {Intent.DESIGN: Input.WISH, Intent.EDIT: Input.CHANGE}
        kind = Input.UNCLEAR if request.refusal else kinds.get(request.intent, Input.UNCLEAR)
        return await self._decide(replace(said, reading=Reading(kind), request=request))

    async def _begin(self, said: Said) -> Line:
        if self._turns.waits_before(said.who.owner) and said.who.role is Role.VISITOR:
            request = said.request or await self._cell.wishes.understand(said.utterance)
            request = request.with_nothing_to_change()
            if not request.buildable:
                raise RefusedError(self.explain(said.utterance, request))
            return await self._queue(replace(said, request=request))
        job = Job(said.who.role, utterance=said.utterance, owner=said.who.owner)
        job.owner_name = self._names.of(said.who.owner)
        await self._cell.controller.command(Event.SAY, lambda: self._cell.begin(job))
        return self._line("reply.thinking")

    async def _begin_again(self, said: Said) -> Line:
        before = self._cell.job
        if before is None or before.utterance is None or before.takes_apart:
            raise RefusedError(self._wording.text("explain.nothing_before"))
        return await self._begin(replace(said, utterance=before.utterance))

    async def _queue(self, said: Said, copies: int = 1) -> Line:
        request = said.request
        assert request is not None, "a wish that waits was understood"
        if said.who.role is Role.OPERATOR:
            # An operator has the cell's own word, and need not wait in a line.
            state = self._cell.controller.state
            raise RefusedError(self._wording.text("refused.busy", state=state))
        owner = said.who.owner
        wish = self._naming.wish(request)
        if self._turns.is_full_for(owner):
            raise RefusedError(self._wording.text("queue.full"))
        name = self._names.of(owner)
        self._turns.add(said.utterance, wish, owner=owner, name=name, copies=copies)
        job = self._cell.active_job
        place = len(self._turns.entries)
        if job is None:
            return self._line("queue.in_line", wish=wish, place=place)
        about = self._cell.sentences.thing(job) or self._wording.text("queue.another_job")
        return self._line("queue.added", job=about, wish=wish, place=place)

    async def _queue_again(self, said: Said) -> Line:
        job = self._cell.active_job
        if job is None or job.request is None or job.utterance is None or job.takes_apart:
            raise RefusedError(self._wording.text("explain.nothing_before"))
        return await self._queue(replace(said, utterance=job.utterance, request=job.request))

    async def _change(self, said: Said) -> Line:
        request = said.request
        assert request is not None, "a change was understood"
        if request.edits and all(edit.attribute == "looks" for edit in request.edits):
            # No description knows what is nicer; whoever asks for it can choose.
            return await self._another(said)
        job = self._changeable(said.who)
        await self._tell_change(job, lambda: job.begin_change(request))
        if request.intent is Intent.EDIT:
            self._board.say(self._line("understood.change"))
        return self._line("reply.changing")

    async def _another(self, said: Said) -> Line:
        job = self._changeable(said.who)
        if job.generated is None:
            raise RefusedError(
                self._wording.text("explain.no_other"),
                self._wording.text("explain.how_to_answer_build"),
            )
        await self._tell_change(job, job.begin_another)
        return self._line("reply.another")

    def _changeable(self, who: Who) -> Job:
        """The job that is asked about, which that person may change."""
        job = self._cell.active_job
        if job is None:
            raise RefusedError(self._wording.text("explain.nothing_asked"))
        if who.role is Role.VISITOR and job.role is not who.role:
            raise RefusedError(
                "The operator began this job; only the operator changes it.",
                self._wording.text("explain.how_to_answer_build"),
            )
        return job

    async def _tell_change(self, job: Job, begin: Callable[[], None]) -> None:
        await self._cell.controller.command(
            Event.CHANGE,
            begin,
            unless=lambda: "" if self._cell.active_job is job else "That came too late.",
        )

    # --- words of command ----------------------------------------------------------------------

    def _reply(self, word: str, text: str) -> Line:
        return Line(key=f"reply.{word}", text=text, language=self._wording.language)

    async def _command(self, said: Said) -> Line:
        word = said.reading.said.value
        if word == "stop":
            self._board.hush()
        else:
            self._refuse_in_a_fault(said.who)
        if word == "resume" and said.who.role is Role.VISITOR:
            raise RefusedError(self._wording.text("explain.resume"))
        return self._reply(word, await self._commands.take(word, said.who.role, said.who.owner))

    async def _cancel(self, said: Said) -> Line:
        """End the own job; a visitor whose job it is not forgets the own wish that waits."""
        who = said.who
        job = self._cell.active_job
        own = job is not None and (job.role, job.owner) == (who.role, who.owner)
        if who.role is Role.VISITOR and not own:
            dropped = self._turns.drop(who.owner)
            if dropped is not None:
                return self._line("queue.dropped", wish=dropped.wish)
        self._refuse_in_a_fault(who)
        self._board.hush()
        thinking = self._place is not Place.WORKING and self._place is not Place.WAITING
        text = await self._commands.take("cancel", who.role, who.owner)
        # Where nothing moves, it has ended already, and was said to have.
        return self._line("reply.no") if thinking else self._reply("cancel", text)

    # --- talk ----------------------------------------------------------------------------------

    async def _answer(self, said: Said) -> Line:
        assert said.reading.topic is not None, "a question is about something"
        return self._answers.answer(said.reading.topic, self._place)

    async def _repeat(self, _said: Said) -> Line:
        line = self._board.data.line
        return line if line is not None else self._line("reply.nothing_said")

    async def _help(self, _said: Said) -> Line:
        match self._place:
            case Place.ASKING_BUILD:
                return self._line("explain.how_to_answer_build")
            case Place.ASKING_APART | Place.ASKING_HAND_OVER:
                return self._line("explain.how_to_answer_apart")
            case Place.WAITING | Place.FAULT:
                return self._line("answer.doing", sentence=self._cell.line.text)
            case _:
                return self._line("reply.help")

    async def _keep_name(self, said: Said) -> Line:
        owner, name = said.who.owner, said.reading.name
        self._names.keep(owner, name)
        self._turns.call(owner, name)
        job = self._cell.active_job
        if job is not None and not self._is_stranger(said.who):
            job.owner_name = name
        return self._line("reply.named", name=name)

    async def _explain(self, said: Said) -> Line:
        assert said.request is not None, "it was read and not understood"
        typed = said.utterance.source == "text"
        raise RefusedError(self._explainer.explain(said.request, typed=typed).text)

    async def _explain_answer(self, said: Said) -> Line:
        """What is neither yes nor no while something is asked."""
        asked = "build" if self._place is Place.ASKING_BUILD else "apart"
        request = said.request
        message = self._wording.text(f"explain.asked_{asked}")
        if request is not None and asked == "build":
            message = self._explainer.refusal(request) or message
        raise RefusedError(message, self._wording.text(f"explain.how_to_answer_{asked}"))

    async def _explain_state(self, said: Said) -> Line:
        raise self._not_now(said.who)

    def _refuse_in_a_fault(self, who: Who) -> None:
        """The machine says how a fault is cleared, which no visitor can do.

        Raises:
            RefusedError: to a visitor, why nothing can be done now.
        """
        if who.role is Role.VISITOR and self._follow() is Place.FAULT:
            raise self._not_now(who)

    def _not_now(self, who: Who) -> RefusedError:
        cell = self._cell
        state = cell.line.text if who.role is Role.VISITOR else cell.last_state.sentence
        return RefusedError(self._wording.text("explain.busy", state=state))
