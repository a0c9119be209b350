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
from cellctl.control.commands import Commands, refuse_visitors
from cellctl.control.dialogue.conversation import Conversation
from cellctl.control.dialogue.table import Input
from cellctl.control.door import Answer
from cellctl.control.ears import LiveEars
from cellctl.control.job import Job
from cellctl.control.possible import possible
from cellctl.control.states import Event
from cellctl.errors import CellctlError, RefusedError, UsageError
from cellctl.listening.hearing import Hearing
from cellctl.listening.wav import read_wav
from cellctl.messages import (
    BuildCommand,
    ConfirmCommand,
    ControlReply,
    ControlRequest,
    DropWishCommand,
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
    visitor_mark,
)

log = structlog.get_logger(__name__)

_OVERHEARING_LIMIT = 2
"""How many recordings may wait to be heard while a job is under way."""
OVERHEARD_S = 5.0
"""Longest recording that is listened to then: nothing may keep a spoken *stop* waiting for long."""

_HAND_TIMEOUT_S = 120.0
"""Longest movement by hand that somebody waits for (wall time)."""

_PRESSED = {
    "stop": Input.STOP,
    "pause": Input.PAUSE,
    "resume": Input.RESUME,
    "cancel": Input.CANCEL,
    "take_apart": Input.TAKE_APART,
    "another": Input.ANOTHER,
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
        conversation: takes what visitors say and press.
        commands: carries out what is asked without arguments.
    """

    def __init__(
        self,
        cell: Cell,
        hearing: Hearing,
        *,
        publish: Callable[[StatusData, str], None],
        snapshot: Callable[[], Snapshot],
        ears: LiveEars,
        archive: Archive,
        conversation: Conversation,
        commands: Commands,
    ) -> None:
        self._cell = cell
        self._hearing = hearing
        self._publish = publish
        self._snapshot = snapshot
        self._ears = ears
        self._conversation = conversation
        self._commands = commands
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
            refuse_visitors(body.command, role)
            if isinstance(body, Inquiry):
                data, file = await self._archive.answer(body, role)
                return Answer(self._reply(request, data=data), file)
            message = await self._dispatch(body, attachment, role, visitor_mark(request.visitor))
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
        """An answer, in the cell's language."""
        job, translated = self._cell.job, self._cell.sentences.wording.translated
        if error is not None:
            said = {"message": translated(error.message), "hint": translated(error.hint)}
            error = error.model_copy(update=said)
        return ControlReply(
            id=request.id,
            ok=error is None,
            state=self._cell.controller.state,
            message=translated(message),
            job_id=job.job_id if job is not None else "",
            snapshot=snapshot,
            data=data,
            error=error,
        )

    async def _dispatch(  # noqa: PLR0911 - one way out a command
        self, body: Order, attachment: bytes | None, role: Role, owner: str
    ) -> str:
        match body:
            case SayCommand():
                said = Utterance(text=body.text, source="text")
                return await self._conversation.take(said, role, owner, answers=body.asked)
            case ListenCommand():
                return self._listen(role, owner)
            case MuteCommand():
                return self._ears.mute(body.command == "mute")
            case HearCommand():
                return await self._hear(body.name, _file(attachment, body.name), role, owner)
            case BuildCommand():
                content = _file(attachment, body.name)
                job = Job.of_file(body.name, content, role, body.pace)
                await self._cell.controller.command(Event.BUILD, lambda: self._cell.begin(job))
                return f"Planning {body.name}."
            case ConfirmCommand():
                answer = Input.YES if body.answer else Input.NO
                return await self._conversation.press(answer, role, owner, answers=body.asked)
            case DropWishCommand():
                return self._conversation.drop(body.ticket)
            case PlainCommand():
                return await self._plain(body.command, role, owner)
            case HandCommand():
                return await self._hand(body)
            case GripperCommand():
                return await self._gripper(body)
            case SnapshotCommand():
                return ""
            case _:
                return await self._books.take(body)

    def _listen(self, role: Role, owner: str) -> str:
        if owner and role is Role.VISITOR:
            # From elsewhere it would only overhear the people in front of the cell.
            raise RefusedError(self._cell.sentences.wording.text("explain.talk_there"))
        return self._ears.listen()

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

    async def _plain(self, command: str, role: Role, owner: str) -> str:
        """A button. Who stands before the cell is asked first whether the object is taken along."""
        if command in _PRESSED:
            return await self._conversation.press(_PRESSED[command], role, owner)
        if command == "hand_over" and role is Role.VISITOR:
            return await self._conversation.press(Input.HAND_OVER, role, owner)
        return await self._commands.take(command, role, owner)

    async def _hear(self, name: str, wav: bytes, role: Role, owner: str) -> str:
        if self._cell.controller.state == "idle":
            await self._cell.controller.command(
                Event.HEAR, lambda: self._cell.begin_audio(name, wav, role, owner)
            )
            return self._cell.sentences.wording.text("reply.listening")
        if len(self._overhearing) >= _OVERHEARING_LIMIT:
            raise RefusedError("Too many recordings wait to be heard.", "Try again in a moment.")
        with audio_file(wav) as path:
            samples = await asyncio.to_thread(read_wav, path, OVERHEARD_S)
        who, answers = (role, owner), self._conversation.asked
        task = asyncio.create_task(
            self._overhear(name, samples.tobytes(), who, answers), name="overhear"
        )
        self._overhearing.add(task)
        task.add_done_callback(self._overhearing.discard)
        return "I am busy; I listen for stop and the like only."

    async def _overhear(self, name: str, pcm: bytes, who: tuple[Role, str], answers: str) -> None:
        """While a job is under way only the words of command count; a yes is for what was asked
        when the recording came."""
        try:
            utterance = await self._hearing.hear_samples(pcm)
            self._publish(SpeechData(utterance=utterance), self._cell.controller.state)
            if self._conversation.phrasebook.read(utterance.text).said is not Input.SENTENCE:
                await self._conversation.take(utterance, *who, answers=answers)
        except CellctlError as error:
            log.info("heard while busy", name=name, reason=str(error))
        except Exception:
            log.exception("heard in vain", name=name)

    async def close(self) -> None:
        """End what is still being listened to."""
        for task in list(self._overhearing):
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task


def _file(attachment: bytes | None, name: str) -> bytes:
    if not attachment:
        raise UsageError(f"{name}: the request carries no file, or an empty one.")
    return attachment
