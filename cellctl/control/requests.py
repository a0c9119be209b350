"""The request desk: from a request on the bus to an event in the inbox, roles checked."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable

import structlog

from cellctl.assembly import Role, Utterance
from cellctl.control.archive import Archive
from cellctl.control.audio import audio_file
from cellctl.control.books import Books
from cellctl.control.cell import Cell
from cellctl.control.conversation import take_another, take_change
from cellctl.control.door import Answer
from cellctl.control.ears import LiveEars
from cellctl.control.job import Job
from cellctl.control.possible import possible
from cellctl.control.states import Event
from cellctl.errors import CellctlError, RefusedError, UsageError
from cellctl.listening.commands import spoken_command
from cellctl.listening.hearing import Hearing
from cellctl.listening.wav import read_wav
from cellctl.messages import (
    OPERATOR_COMMANDS,
    BuildCommand,
    ConfirmCommand,
    ControlReply,
    ControlRequest,
    GripperCommand,
    HandCommand,
    HearCommand,
    Inquiry,
    ListenCommand,
    MuteCommand,
    Order,
    PlainCommand,
    ReplyData,
    ReplyError,
    SayCommand,
    Snapshot,
    SnapshotCommand,
    SpeechData,
    StatusData,
)

log = structlog.get_logger(__name__)

_OVERHEARING_LIMIT = 2
"""How many recordings may wait to be heard while a job is under way."""
OVERHEARD_S = 5.0
"""Longest recording that is listened to then: nothing may keep a spoken *stop* waiting for long."""

_HAND_TIMEOUT_S = 120.0
"""Longest movement by hand that somebody waits for (wall time)."""

_EVENTS = {
    "pause": Event.PAUSE,
    "stop": Event.STOP,
    "cancel": Event.CANCEL,
    "reset": Event.RESET,
}
_DONE = {
    "pause": "Pausing at the next safe point.",
    "resume": "Going on.",
    "stop": "Stopping now; the part stays in the gripper.",
    "cancel": "Ending the job; what stands stays.",
    "reset": "Clearing the fault; nothing moves until you resume.",
}
_NOTHING_MOVES = "Nothing is under way, and nothing moves."
_WORDS: dict[str, str | bool] = {
    "stop": "stop",
    "pause": "pause",
    "resume": "resume",
    "cancel": "cancel",
    "take_apart": "take_apart",
    "another": "another",
    "yes": True,
    "no": False,
}


class RequestDesk:
    """Answers the requests of visitors and operators.

    Args:
        cell: the cell that the requests are for.
        hearing: recognises speech that comes while a job is under way.
        publish: sends a status message; gets the data and the state.
        snapshot: makes the whole picture.
        ears: the microphone.
        archive: answers what is asked of jobs and of the cell.
    """

    def __init__(
        self,
        cell: Cell,
        hearing: Hearing,
        publish: Callable[[StatusData, str], None],
        snapshot: Callable[[], Snapshot],
        ears: LiveEars,
        *,
        archive: Archive,
    ) -> None:
        self._cell = cell
        self._hearing = hearing
        self._publish = publish
        self._snapshot = snapshot
        self._ears = ears
        self._books = Books(cell)
        self._archive = archive
        self._overhearing: set[asyncio.Task[None]] = set()

    async def handle(self, request: ControlRequest, attachment: bytes | None, role: Role) -> Answer:
        """Carry one request of that role out; never raises."""
        answer = await self._answer(request, attachment, role)
        reply = answer.reply
        message = reply.error.message if reply.error is not None else reply.message
        self._archive.recollection.commanded(request.body, role, ok=reply.ok, message=message)
        return answer

    async def _answer(
        self, request: ControlRequest, attachment: bytes | None, role: Role
    ) -> Answer:
        body = request.body
        try:
            _refuse_visitors(body.command, role)
            if isinstance(body, Inquiry):
                data, file = await self._archive.answer(body, role)
                return Answer(self._reply(request, data=data), file)
            message = await self._dispatch(body, attachment, role)
        except CellctlError as error:
            return Answer(self._reply(request, error=ReplyError.of(error)))
        except Exception as error:
            log.exception("request failed", command=body.command)
            text = f"{type(error).__name__}: {error}"
            why = ReplyError(code="internal", message=text)
            return Answer(self._reply(request, error=why))
        snapshot = self._snapshot() if body.command == "snapshot" else None
        return Answer(self._reply(request, message=message, snapshot=snapshot))

    def _reply(
        self,
        request: ControlRequest,
        *,
        message: str = "",
        snapshot: Snapshot | None = None,
        data: ReplyData | None = None,
        error: ReplyError | None = None,
    ) -> ControlReply:
        job = self._cell.job
        return ControlReply(
            id=request.id,
            ok=error is None,
            state=self._cell.controller.state,
            message=message,
            job_id=job.job_id if job is not None else "",
            snapshot=snapshot,
            data=data,
            error=error,
        )

    async def _dispatch(  # noqa: PLR0911 - one way out a command
        self, body: Order, attachment: bytes | None, role: Role
    ) -> str:
        match body:
            case SayCommand():
                return await self.take(Utterance(text=body.text, source="text"), role)
            case ListenCommand():
                return self._ears.listen()
            case MuteCommand():
                return self._ears.mute(body.command == "mute")
            case HearCommand():
                return await self._hear(body.name, _file(attachment, body.name), role)
            case BuildCommand():
                content = _file(attachment, body.name)
                await self._cell.controller.command(
                    Event.BUILD, lambda: self._cell.begin(Job.of_file(body.name, content, role))
                )
                return f"Planning {body.name}."
            case ConfirmCommand():
                return await self._word(body.answer, role)
            case PlainCommand():
                return await self._word(body.command, role)
            case HandCommand():
                return await self._hand(body)
            case GripperCommand():
                return await self._gripper(body)
            case SnapshotCommand():
                return ""
            case _:
                return await self._books.take(body)

    async def _word(self, word: str | bool, role: Role) -> str:
        """Carry out a command without arguments, or a yes or no."""
        controller = self._cell.controller
        if isinstance(word, bool):
            job = self._cell.active_job
            yes = job.confirm_event() if job is not None else Event.CONFIRM
            await controller.command(yes if word else Event.DECLINE)
            return "Then I begin." if word else "Then I leave it."
        if word == "another":
            return await take_another(self._cell, role)
        if word == "cancel":
            self._refuse_to_cancel_anothers(role)
        if word == "take_apart":
            await controller.command(
                Event.TAKE_APART,
                lambda: self._cell.begin(Job.taking_apart(role)),
                unless=self._why_nothing_to_take_apart,
            )
            return "I am working out how it comes apart."
        if word in {"clear", "hand_over"}:
            return await self._books.empty_workspace(handed_over=word == "hand_over")
        if word == "pause" and role is Role.VISITOR and controller.state == "idle":
            # Only an operator could lead out of it again.
            raise RefusedError("There is nothing to pause.")
        if word == "resume":
            await self._resume()
            return _DONE[word]
        idle = controller.state == "idle"
        await controller.command(_EVENTS[word])
        return _NOTHING_MOVES if idle and word == "stop" else _DONE[word]

    async def _resume(self) -> None:
        """Go on; what is believed of a part in doubt is taken for granted then."""
        cell = self._cell
        if cell.controller.state == "paused_resting":
            await cell.resume_doubt()
        job = cell.active_job
        why_not = job.why_not_resume if job is not None else None
        await cell.controller.command(cell.resume_event(), unless=why_not)

    def _why_nothing_to_take_apart(self) -> str:
        idle = self._cell.controller.state == "idle"
        return (
            "Nothing stands in the workspace." if idle and not self._cell.builder.standing else ""
        )

    async def _hand(self, command: HandCommand) -> str:
        hand = self._cell.hand
        ended: list[asyncio.Future[str]] = []
        await self._cell.controller.command(
            Event.HAND, lambda: ended.append(hand.begin(command)), unless=self._why_no_hand(command)
        )
        try:
            async with asyncio.timeout(_HAND_TIMEOUT_S):
                return await asyncio.shield(ended[0])
        except TimeoutError:
            raise RefusedError(
                "It still moves, and is no longer waited for.", "`cellctl stop` ends it."
            ) from None

    async def _gripper(self, said: GripperCommand) -> str:
        """Ask the gripper's board; nothing of it is changed while a job moves."""
        at_rest = "gripper" in possible(self._cell.controller.state)
        if said.do != "show" and not at_rest:
            raise RefusedError(
                "Something moves, or is about to.", "Pause first; `cellctl gripper show` may ask."
            )
        return await self._cell.gripper_board.take(said)

    def _why_no_hand(self, command: HandCommand) -> Callable[[], str]:
        def why_not() -> str:
            if self._cell.controller.state != "paused_resting":
                return ""  # the machine has its own reason
            return self._cell.hand.why_not(command)

        return why_not

    async def take(self, utterance: Utterance, role: Role) -> str:
        """Do what somebody said: a command, or a wish; returns what happens now.

        Raises:
            CellctlError: why it is not done.
        """
        word = spoken_command(utterance.text)
        asks = self._cell.controller.state == "validating_confirming"
        if word is not None:
            # Before anything is built, "another one" is another shape for the same wish.
            return await self._spoken_word("another" if asks and word == "again" else word, role)
        if asks:
            return await take_change(self._cell, utterance, role)
        await self._cell.controller.command(
            Event.SAY, lambda: self._cell.begin(Job(role, utterance=utterance))
        )
        return "I am thinking about it."

    async def _hear(self, name: str, wav: bytes, role: Role) -> str:
        if self._cell.controller.state == "idle":
            await self._cell.controller.command(
                Event.HEAR, lambda: self._cell.begin_audio(name, wav, role)
            )
            return "I am listening."
        if len(self._overhearing) >= _OVERHEARING_LIMIT:
            raise RefusedError("Too many recordings wait to be heard.", "Try again in a moment.")
        with audio_file(wav) as path:
            samples = await asyncio.to_thread(read_wav, path, OVERHEARD_S)
        task = asyncio.create_task(self._overhear(name, samples.tobytes(), role), name="overhear")
        self._overhearing.add(task)
        task.add_done_callback(self._overhearing.discard)
        return "I am busy; I listen for stop and the like only."

    async def _overhear(self, name: str, pcm: bytes, role: Role) -> None:
        """While a job is under way only the words of command count."""
        try:
            utterance = await self._hearing.hear_samples(pcm)
            self._publish(SpeechData(utterance=utterance), self._cell.controller.state)
            word = spoken_command(utterance.text)
            if word is None:
                log.info("heard while busy", text=utterance.text)
                return
            await self._spoken_word(word, role)
        except CellctlError as error:
            log.info("heard while busy", name=name, reason=str(error))
        except Exception:
            log.exception("heard in vain", name=name)

    async def _spoken_word(self, word: str, role: Role) -> str:
        meaning = _WORDS.get(word)
        if meaning is None:
            raise UsageError(f"{word!r} is no command of this cell.")
        if role is not Role.OPERATOR and meaning in OPERATOR_COMMANDS:
            raise RefusedError(f"{word} needs the operator.")
        return await self._word(meaning, role)

    def _refuse_to_cancel_anothers(self, role: Role) -> None:
        """A visitor may end what a visitor began; an operator everything."""
        job = self._cell.job
        if job is None or job.outcome:
            return
        if role is Role.VISITOR and job.role is not role:
            raise RefusedError(
                "The operator began this job; cancel needs the operator.",
                "Say stop if the cell has to stop now.",
            )

    async def close(self) -> None:
        """End what is still being listened to."""
        for task in list(self._overhearing):
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task


def _refuse_visitors(command: str, role: Role) -> None:
    if role is not Role.OPERATOR and command in OPERATOR_COMMANDS:
        raise RefusedError(f"{command} needs the operator.")


def _file(attachment: bytes | None, name: str) -> bytes:
    if not attachment:
        raise UsageError(f"{name}: the request carries no file, or an empty one.")
    return attachment
