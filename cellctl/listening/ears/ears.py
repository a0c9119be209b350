"""``Ears``: the daemon's end of the process that owns the microphone."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import Iterable

import structlog

from cellctl.assembly import Value
from cellctl.config import HearingSection
from cellctl.listening.ears.events import (
    Condition,
    EarsEvent,
    Expect,
    Expecting,
    FromEars,
    Listen,
    Mute,
    OwnVoiceBegan,
    OwnVoiceEnded,
    Segment,
)
from cellctl.sound.process import SoundProcess

EVENTS_LIMIT = 50
"""Events that wait for the daemon; the oldest utterance is dropped first."""

log = structlog.get_logger(__name__)


class Ears:
    """Live ears: run ``run`` as a task, take events from ``next_event``.

    Args:
        settings: the ``[hearing]`` table; its microphone is not ``none``.
    """

    def __init__(self, settings: HearingSection) -> None:
        self._events: deque[EarsEvent] = deque()
        self._arrived = asyncio.Event()
        self._condition: Condition | None = None
        """The newest that the process told."""
        self._expecting: Expecting = "request"
        self._muted = False
        self._process = SoundProcess(
            "ears", "cellctl.listening.ears.child", settings.model_dump_json(), self
        )

    @property
    def pid(self) -> int | None:
        """Process id of the ears, while they run."""
        return self._process.pid

    def expect(self, what: Expecting) -> None:
        """Tell what may be said now: that decides how much silence ends an utterance."""
        if what != self._expecting:
            self._expecting = what
            self._process.send(Expect(what=what))

    def listen(self) -> None:
        """Take what is said next for a request, as after the wake word."""
        self._process.send(Listen())

    def mute(self, muted: bool) -> None:
        """Close the microphone until further notice, or open it again."""
        self._muted = muted
        self._process.send(Mute(muted=muted))

    def own_voice_began(self, at_s: float, levels: tuple[float, ...], *, wakes: bool) -> None:
        """The cell itself begins to speak: see ``OwnVoiceBegan``."""
        self._process.send(OwnVoiceBegan(at_s=at_s, levels=levels, wakes=wakes))

    def own_voice_ended(self, at_s: float) -> None:
        """It is silent again."""
        self._process.send(OwnVoiceEnded(at_s=at_s))

    async def next_event(self) -> EarsEvent:
        """Wait for the next event."""
        while not self._events:
            self._arrived.clear()
            await self._arrived.wait()
        return self._events.popleft()

    async def run(self) -> None:
        """Keep the process at work until cancelled."""
        await self._process.run()

    def started(self) -> Iterable[Value]:
        """See ``Owner``."""
        return Expect(what=self._expecting), Mute(muted=self._muted)

    def take(self, line: bytes) -> None:
        """See ``Owner``."""
        event = FromEars.validate_json(line)
        if isinstance(event, Condition):
            self._condition = event
        self._put(event)

    def lost(self, why: str) -> None:
        """See ``Owner``."""
        self._put(Condition(state="lost", sentence=why))

    def answers_again(self) -> None:
        """See ``Owner``."""
        if self._condition is not None:
            self._put(self._condition)

    def _put(self, event: EarsEvent) -> None:
        if len(self._events) >= EVENTS_LIMIT:
            log.warning("too much was said at once; the oldest is dropped")
            oldest = next((e for e in self._events if isinstance(e, Segment)), self._events[0])
            self._events.remove(oldest)
        self._events.append(event)
        self._arrived.set()
