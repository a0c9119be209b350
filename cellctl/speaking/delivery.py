"""What the mouth's process does: says one thing after the other, and keeps a loudspeaker at work.

``Delivery.step`` does one short piece of work, so that the process can tell all the time that it is
alive; PortAudio may hang all the same, and then the daemon ends the process. What cannot be said
aloud is not waited for: it stands on the screen.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from cellctl.errors import HearingError
from cellctl.messages import VoiceCondition
from cellctl.sound import server
from cellctl.sound.back_off import BackOff
from cellctl.sound.server import ServerWatch, Sink
from cellctl.speaking.chimes import chime
from cellctl.speaking.events import (
    Began,
    Condition,
    Ended,
    MouthEvent,
    MouthSettings,
    Order,
    Prepare,
    Ring,
    Say,
)
from cellctl.speaking.loudspeaker import Loudspeaker, envelope, prepared
from cellctl.speaking.repertoire import Repertoire
from cellctl.speaking.voices import Samples

STEP_S = 0.02
"""Longest wait in one step while something is said (wall time) ..."""
IDLE_STEP_S = 0.2
"""... and otherwise."""
WATCH_EVERY_S = 2.0
"""How often the sound server is asked about its loudspeakers (wall time)."""
SILENCE_S = 2.0
"""A loudspeaker that asks for nothing for so long while it plays is lost (wall time)."""
WAITING_LIMIT = 4
"""Things that wait to be said; of more the oldest is left to the screen."""
_MUTED = "The loudspeaker is muted in the sound settings."


class Delivery:
    """One loudspeaker, and what is said through it.

    Args:
        settings: how to speak.
        tell: gets every event; called from the thread of ``step``.
    """

    def __init__(self, settings: MouthSettings, tell: Callable[[MouthEvent], None]) -> None:
        voice = settings.voice
        self._wanted = voice.loudspeaker
        self._volume = voice.volume
        self._repertoire = Repertoire(voice.voice, voice.volume, settings.language)
        self._tell = tell
        self._told: Condition | None = None
        self._loudspeaker: Loudspeaker | None = None
        self._watch: ServerWatch[_Served] | None = None
        self._back_off = BackOff()
        self._trouble = ""
        self._voiceless = ""
        """Why the last text was not said, if there was no voice for it."""
        self._refused = ""
        """Why the loudspeaker did not take the last sound."""
        self._lock = threading.Lock()
        self._waiting: deque[Say | Ring] = deque()
        self._made: dict[int, Samples | HearingError] = {}
        """What was made of what waits, by number."""
        self._speaking: int | None = None
        """Number of what is being said."""
        self._hushed = False
        """``hush`` came since it began."""
        self._arrived = threading.Event()

    def take(self, order: Order) -> None:
        """Take an order; safe from any thread. ``Hush`` is obeyed before this returns."""
        match order:
            case Prepare():
                for text in order.texts:
                    self._repertoire.prepare(text, order.language)
            case Say():
                with self._lock:
                    self._waiting.append(order)
                made = partial(self._put, order.number)
                self._repertoire.order(order.text, order.language, made)
            case Ring():
                with self._lock:
                    self._waiting.append(order)
                self._put(order.number, prepared(chime(order.chime), self._volume / 2.0))
            case _:
                self._hush()
        self._arrived.set()

    def step(self) -> None:
        """Do what is next; ends within some 0.1 s unless PortAudio hangs."""
        if self._loudspeaker is None:
            self._open_if_due()
        else:
            self._look_after(self._loudspeaker)
        self._end_what_has_ended()
        self._leave_out_too_much()
        if not self._begin_next():
            self._arrived.wait(STEP_S if self._speaking is not None else IDLE_STEP_S)
            self._arrived.clear()
        self._tell_condition()

    def close(self) -> None:
        """Let go of the loudspeaker."""
        watch, self._watch = self._watch, None
        if watch is not None:
            watch.end()
        loudspeaker, self._loudspeaker = self._loudspeaker, None
        if loudspeaker is not None:
            loudspeaker.close()

    def _hush(self) -> None:
        with self._lock:
            dropped = [order.number for order in self._waiting]
            self._waiting.clear()
            self._made.clear()
            self._hushed = True
            if self._loudspeaker is not None and self._speaking is not None:
                self._loudspeaker.hush()
        for number in dropped:
            self._leave_out(number)

    def _open_if_due(self) -> None:
        # Loading a voice keeps the interpreter busy, and would make it stutter.
        if not self._repertoire.ready.is_set() or not self._back_off.due:
            return
        try:
            self._loudspeaker = Loudspeaker(self._wanted)
        except HearingError as error:
            self._lose(str(error))
            return
        self._trouble = ""
        self._watch = ServerWatch(_look, WATCH_EVERY_S)

    def _look_after(self, loudspeaker: Loudspeaker) -> None:
        seen = self._watch.answer if self._watch is not None else None
        if loudspeaker.broken:
            self._lose("The loudspeaker's stream has ended.")
        elif loudspeaker.silent_for_s > SILENCE_S:
            self._lose("The loudspeaker takes no sound: it was unplugged or suspended.")
        elif seen is None or not loudspeaker.served:
            return
        elif not seen.sinks:
            self._lose("The sound server has ended, or has no loudspeaker.")
        elif loudspeaker.sink and loudspeaker.sink not in seen.sinks:
            self._lose(f"The loudspeaker is gone: {loudspeaker.name}.")
        elif loudspeaker.sink and seen.used is not None and seen.used.name != loudspeaker.sink:
            self._lose(f"The loudspeaker is gone; {seen.used.description} took its place.")
        else:
            self._back_off.worked()

    def _lose(self, why: str) -> None:
        with self._lock:
            self.close()
        self._trouble = why
        self._back_off.failed()

    def _end_what_has_ended(self) -> None:
        number, loudspeaker = self._speaking, self._loudspeaker
        if number is None or (loudspeaker is not None and loudspeaker.playing):
            return
        self._speaking = None
        complete = loudspeaker is not None and not self._hushed
        self._tell(Ended(number=number, at_s=time.monotonic(), complete=complete))

    def _leave_out_too_much(self) -> None:
        with self._lock:
            surplus = max(0, len(self._waiting) - WAITING_LIMIT)
            dropped = [self._waiting.popleft().number for _ in range(surplus)]
            for number in dropped:
                self._made.pop(number, None)
        for number in dropped:
            self._leave_out(number)

    def _begin_next(self) -> bool:
        """Begin what waits, if nothing is being said; whether there was anything."""
        if self._speaking is not None:
            return False
        with self._lock:
            if not self._waiting:
                return False
            number, loudspeaker = self._waiting[0].number, self._loudspeaker
            made = self._made.pop(number, None)
            if made is None and loudspeaker is not None:
                return False
            self._waiting.popleft()
            self._hushed = False
            began: Began | None = None
            if loudspeaker is not None and isinstance(made, np.ndarray):
                began = self._play(loudspeaker, number, made)
        if self._refused:
            self._lose(self._refused)
            self._refused = ""
        if began is not None:
            self._voiceless = ""
            self._tell(began)
        else:
            self._voiceless = str(made) if isinstance(made, HearingError) else self._voiceless
            self._leave_out(number)
        return True

    def _play(self, loudspeaker: Loudspeaker, number: int, samples: Samples) -> Began | None:
        """Begin it; None when the loudspeaker takes no sound."""
        try:
            loudspeaker.play(samples)
        except HearingError as error:
            self._refused = str(error)
            return None
        self._speaking = number
        return Began(number=number, at_s=time.monotonic(), envelope=envelope(samples))

    def _put(self, number: int, made: Samples | HearingError) -> None:
        """A sound is ready, if it is still wanted."""
        with self._lock:
            if any(order.number == number for order in self._waiting):
                self._made[number] = made
        self._arrived.set()

    def _leave_out(self, number: int) -> None:
        self._tell(Ended(number=number, at_s=time.monotonic(), complete=False))

    def _tell_condition(self) -> None:
        condition = self._condition()
        if condition != self._told:
            self._told = condition
            self._tell(condition)

    def _condition(self) -> Condition:
        if trouble := self._trouble or self._voiceless:
            return Condition(state="lost", sentence=trouble)
        loudspeaker = self._loudspeaker
        if loudspeaker is None:
            return self._told or Condition(state="starting", sentence="The loudspeaker is opened.")
        sink = self._watch.answer.used if self._watch is not None and self._watch.answer else None
        muted = sink is not None and sink.muted
        state: VoiceCondition = "speaking" if self._speaking is not None else "quiet"
        return Condition(
            state="silent" if muted else state,
            device=sink.description if sink is not None else loudspeaker.name,
            voice=self._repertoire.voice,
            sentence=_MUTED if muted else "",
        )


@dataclass(frozen=True)
class _Served:
    """What the sound server tells of loudspeakers."""

    sinks: frozenset[str]
    """Names of all; none without a server."""
    used: Sink | None
    """The one that this process plays on; None when nobody can tell."""


def _look() -> _Served | None:
    sinks = server.sinks_if_told()
    if sinks is None:
        return None
    return _Served(frozenset(sink.name for sink in sinks), server.played_sink())
