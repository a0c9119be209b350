"""Live ears in the daemon: what the microphone hears becomes a request, or a word of command.

Everything that comes from a microphone is a visitor's. After the wake word or the button it is a
request. Without them only *stop* counts, in every state; *pause* while something is under way; and
*yes* and *no* while the cell asks, and what changes that which it asks about. All other talk is
forgotten as soon as it has been recognised: it is neither published nor logged.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

import structlog

from cellctl.assembly import Utterance
from cellctl.config import HearingSection
from cellctl.control.drafts import Drafts
from cellctl.control.states import TRANSITIONS, Event
from cellctl.control.voice import LiveVoice
from cellctl.errors import CellctlError, HearingError, RefusedError
from cellctl.listening.commands import Sayings, is_praise
from cellctl.listening.ears.ears import Ears
from cellctl.listening.ears.events import Condition, Draft, NoSpeech, Segment, WakeWordHeard
from cellctl.listening.ears.words import overheard_command
from cellctl.listening.hearing import Hearing
from cellctl.listening.own_words import OwnWords, of_others, says_stop
from cellctl.listening.recogniser import SAMPLE_RATE_HZ
from cellctl.messages import EarsData, SpeechData, StatusData
from cellctl.notices import NOTICES
from cellctl.speaking.events import Began, Ended

log = structlog.get_logger(__name__)

Take = Callable[[Utterance, float], Awaitable[str]]
"""Does what somebody said, who began to at that moment (monotonic); raises CellctlError with the
reason why not."""

_WAITING_LIMIT = 4
"""Utterances that may wait for the recogniser; the oldest is dropped."""
_FOLLOW_EVERY_S = 0.05
"""How often the state is looked at (wall time)."""
_NOT_UNDERSTOOD = "I heard nothing that I could understand. Please say it again."
_DEAF = "I cannot make out spoken words at the moment. Please type them."
_CALLED = frozenset({"wake_word", "push_to_talk"})
"""After these somebody waits for an answer; other sound may be anything."""
_AT_ONCE = frozenset({"stop", "pause"})
"""Words that wait for nothing said before them, such as a wish that a language model reads."""


T = TypeVar("T")


def _put(queue: asyncio.Queue[T], item: T) -> None:
    if queue.full():
        log.warning("too much is said at once; the oldest is not recognised")
        queue.get_nowait()
    queue.put_nowait(item)


def _sources(event: Event) -> frozenset[str]:
    """The states in which an event does something."""
    rows = [row.sources for row in TRANSITIONS if row.event is event]
    return frozenset(state for sources in rows for state in sources)


_REQUEST_STATES = _sources(Event.SAY)


class LiveEars:
    """The microphone's way into the cell.

    Args:
        settings: the ``[hearing]`` table.
        hearing: the recogniser.
        state: the machine's present state.
        publish: sends a status message.
        voice: what the cell says itself, and what falls silent when somebody else speaks.
        asks: whether a yes or a no would be an answer now.
        changes: whether words change what the one in front is asked about.
        sayings: words of command in the cell's language.
        say: says a sentence to the people in front of the cell.
        translated: puts a sentence into that language.
    """

    def __init__(
        self,
        settings: HearingSection,
        hearing: Hearing,
        state: Callable[[], str],
        publish: Callable[[StatusData], None],
        *,
        voice: LiveVoice,
        asks: Callable[[], bool],
        changes: Callable[[str], Awaitable[bool]],
        sayings: Sayings,
        say: Callable[[str], None],
        translated: Callable[[str], str],
    ) -> None:
        self._settings = settings
        self._hearing = hearing
        self._state = state
        self._publish = publish
        self._voice = voice
        voice.heeded_by.append(self._heed)
        self._own = OwnWords()
        self._drafts = Drafts(hearing.hear_samples)
        self._asks = asks
        self._changes = changes
        self._sayings = sayings
        self._say = say
        self._translated = translated
        self._ears = Ears(settings) if settings.microphone != "none" else None
        self._segments: asyncio.Queue[Segment] = asyncio.Queue(_WAITING_LIMIT)
        self._heard: asyncio.Queue[tuple[Segment, str]] = asyncio.Queue(_WAITING_LIMIT)
        """What is no stop, with what the cell itself said meanwhile."""
        self._said: asyncio.Queue[tuple[Segment, Utterance, str]] = asyncio.Queue(_WAITING_LIMIT)
        """What was recognised, in its order: what is done about it may take its time."""
        self.data = EarsData(
            state="off" if self._ears is None else "starting",
            activation=settings.activation,
            sentence="No microphone is configured." if self._ears is None else "",
        )
        """What the bus shows."""

    async def run(self, take: Take) -> None:
        """Listen until cancelled; without a microphone there is nothing to do.

        Args:
            take: does what was said.
        """
        if self._ears is None:
            return
        try:
            async with asyncio.TaskGroup() as tasks:
                tasks.create_task(self._ears.run(), name="ears process")
                tasks.create_task(self._follow(self._ears), name="ears follow")
                tasks.create_task(self._events(self._ears), name="ears events")
                tasks.create_task(self._look_for_stops(take), name="ears stop")
                tasks.create_task(self._recognise(take), name="ears recognise")
                tasks.create_task(self._do_all(take), name="ears do")
        finally:
            await self._drafts.close()

    def listen(self) -> str:
        """Press the button; returns what happens now.

        Raises:
            RefusedError: there is no microphone that could hear anything.
        """
        ears = self._required()
        if self.data.state in {"muted", "lost", "starting"}:
            raise RefusedError(f"The microphone is not at work ({self.data.state}).")
        ears.listen()
        self._voice.listens()
        return "I am listening."

    def mute(self, muted: bool) -> str:
        """Close the microphone, or open it again; returns what happens now.

        Raises:
            RefusedError: no microphone is configured.
        """
        self._required().mute(muted)
        if muted:
            return "The microphone is off; I hear nothing, stop included."
        return "The microphone is on."

    def _required(self) -> Ears:
        if self._ears is None:
            raise RefusedError("No microphone is configured.", "Set hearing.microphone.")
        return self._ears

    async def _follow(self, ears: Ears) -> None:
        """Keep the ears told what may be said: a command ends after less silence."""
        while True:
            ears.expect("request" if self._may_be_a_request() else "command")
            await asyncio.sleep(_FOLLOW_EVERY_S)

    def _may_be_a_request(self) -> bool:
        """Whether a whole sentence may be said now. Where nothing has to come before it, that is
        also so while the cell asks: for a change."""
        state = self._state()
        open_to_all = self._settings.activation == "open"
        return state in _REQUEST_STATES or (open_to_all and self._asks())

    async def _events(self, ears: Ears) -> None:
        while True:
            match await ears.next_event():
                case Condition() as condition:
                    self._changed(condition)
                case WakeWordHeard(word=word):
                    log.info("wake word heard", word=word)
                    self._voice.listens()
                case Draft() as draft:
                    self._drafts.begin(draft)
                case NoSpeech():
                    self._tell("Nobody said anything.")
                case Segment() as segment:
                    if segment.after in {"wake_word", "push_to_talk"}:
                        self._voice.ring("heard")
                    _put(self._segments, segment)

    def _changed(self, condition: Condition) -> None:
        bad = condition.state in {"lost", "silent", "slow"}
        if condition.state != self.data.state or condition.device != self.data.device:
            tell = log.warning if bad else log.info
            tell("ears", state=condition.state, device=condition.device, why=condition.sentence)
        self.data = self.data.model_copy(
            update={
                "state": condition.state,
                "device": condition.device,
                "sentence": condition.sentence,
                "notice": NOTICES["microphone_lost"] if bad else None,
            }
        )
        self._publish(self.data)

    def _tell(self, sentence: str) -> None:
        """Say something to the people in the room, until the next change."""
        self._publish(self.data.model_copy(update={"sentence": self._translated(sentence)}))

    async def _look_for_stops(self, take: Take) -> None:
        """Nothing that takes its time, such as asking a language model, may be before a stop."""
        while True:
            segment = await self._segments.get()
            own = self._own_words(segment)
            with self._surviving(segment):
                if not await self._stopped_at_once(segment, own, take):
                    _put(self._heard, (segment, own))

    async def _recognise(self, take: Take) -> None:
        while True:
            segment, own = await self._heard.get()
            with self._surviving(segment):
                utterance = await self._drafts.result(segment)
                command = overheard_command(utterance.text)
                others = of_others(utterance.text, own, command=command is not None)
                if utterance.text and not others:
                    log.info("own voice heard")
                    continue
                said = utterance.model_copy(update={"text": others})
                if overheard_command(others, self._sayings) in _AT_ONCE:
                    await self._judge(segment, said, own, take)
                else:
                    _put(self._said, (segment, said, own))

    async def _do_all(self, take: Take) -> None:
        while True:
            segment, said, own = await self._said.get()
            with self._surviving(segment):
                await self._judge(segment, said, own, take)

    @contextmanager
    def _surviving(self, segment: Segment) -> Iterator[None]:
        """Tell what went wrong with what was heard, and go on: the next word may be "stop"."""
        try:
            yield
        except HearingError as error:
            log.warning("speech not recognised", reason=str(error))
            self._tell(str(error))
            if segment.after in _CALLED:
                self._say(self._translated(_DEAF))
        except CellctlError as error:
            log.info("not done", reason=str(error))
            self._tell(str(error))
        except Exception:
            log.exception("heard in vain")

    def _own_words(self, segment: Segment) -> str:
        """What the cell itself said while that was heard."""
        begun_s = segment.speech_end_s - len(segment.samples) / SAMPLE_RATE_HZ
        return self._own.during(begun_s, segment.speech_end_s)

    def _heed(self, event: Began | Ended, text: str) -> None:
        """The cell itself begins or ends to speak, or sounds a chime."""
        if self._ears is None:
            return
        if isinstance(event, Began):
            self._own.began(event.number, text, event.at_s)
            wakes = self._settings.wake_word.replace("_", " ") in text.lower()
            self._ears.own_voice_began(event.at_s, event.envelope, wakes=wakes)
        elif self._own.ended(event.number, event.at_s):
            self._ears.own_voice_ended(event.at_s)

    async def _stopped_at_once(self, segment: Segment, own: str, take: Take) -> bool:
        """Recognising a whole sentence takes time that "stop" has not got."""
        if self._state() in _REQUEST_STATES or says_stop(own):
            return False
        if not await self._hearing.says_stop(segment.pcm):
            return False
        await self._do(Utterance(text="stop", source="microphone"), segment, take)
        return True

    async def _judge(self, segment: Segment, utterance: Utterance, own: str, take: Take) -> None:
        word = overheard_command(utterance.text, self._sayings)
        if segment.after and not utterance.text:
            self._publish(SpeechData(utterance=utterance))
            self._tell(_NOT_UNDERSTOOD)
            if segment.after in _CALLED:
                self._say(self._translated(_NOT_UNDERSTOOD))
        elif segment.after or (word is not None and self._counts(word, utterance.text)):
            said = utterance if word != "stop" else utterance.model_copy(update={"text": word})
            await self._do(said, segment, take)
        elif word is None and not own and utterance.text and await self._changes(utterance.text):
            # Not while the cell itself speaks: half of its question may sound like a change.
            await self._do(utterance, segment, take)

    async def _do(self, utterance: Utterance, segment: Segment, take: Take) -> None:
        delay_s = round(time.monotonic() - segment.speech_end_s, 3)
        log.info("heard", after=segment.after or "nothing", delay_s=delay_s)
        self._voice.hush()
        self._publish(SpeechData(utterance=utterance))
        # Of long talk only the last seconds were kept: what counts began with them at the earliest.
        kept_s = min(segment.speech_s, len(segment.samples) / SAMPLE_RATE_HZ)
        await take(utterance, segment.speech_end_s - kept_s)

    def _counts(self, word: str, text: str) -> bool:
        """Whether a word counts that was said without the wake word or the button. People praise
        what they see to each other as well: that agrees to nothing."""
        state = self._state()
        if word == "yes" and is_praise(text):
            return False
        if word in {"yes", "no"}:
            return self._asks()
        if word == "pause":
            return state not in _REQUEST_STATES
        return word == "stop" or (word == "cancel" and self._settings.activation == "open")
