"""Keeps one microphone at work: notices what goes wrong with it, and opens it again.

Runs in the ears' own process. ``Supervisor.step`` does one short piece of work, so that the process
can tell all the time that it is alive; PortAudio may hang all the same, and then the daemon ends
the process.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from cellctl.errors import HearingError
from cellctl.listening.ears import sound_server
from cellctl.listening.ears.events import Condition, EarsEvent, Segment
from cellctl.listening.ears.microphone import Microphone
from cellctl.listening.ears.pipeline import Pipeline
from cellctl.listening.ears.sound_server import Source
from cellctl.messages import EarsCondition

STEP_S = 0.1
"""Longest wait for sound in one step (wall time)."""
SILENCE_S = 1.0
"""A microphone that delivers nothing for so long is lost (wall time); it delivers 31 times a
second."""
FIRST_SOUND_S = 4.0
"""The same for a stream that was just opened: sound servers wake up slowly."""
ZEROS_S = 1.5
"""Nothing but zeros for so long is no quiet room: real microphones have noise."""
REOPEN_SILENT_S = 10.0
"""A microphone that stays at zeros is opened anew so often: some recover only so."""
HELD_UP_S = 1.0
"""A step that comes so late (wall time) has lost sound: the libraries below keep little, and do not
say what they threw away."""
SLOW_SHOWN_S = 2.0
"""How long it is told that sound was lost."""
BACK_OFF_S = (0.25, 0.5, 1.0, 2.0)
"""Waits between attempts to open the microphone; the last one for ever (wall time)."""
SOURCE_EVERY_S = 0.7
"""How often the sound server is asked what is recorded (wall time)."""


class Supervisor:
    """One microphone and the pipeline behind it.

    Args:
        wanted: ``hearing.microphone``.
        pipeline: takes the sound.
        tell: gets every event.
    """

    def __init__(self, wanted: str, pipeline: Pipeline, tell: Callable[[EarsEvent], None]) -> None:
        self._wanted = wanted
        self._pipeline = pipeline
        self._tell = tell
        self._told: Condition | None = None
        self._microphone: Microphone | None = None
        self._watch: _SourceWatch | None = None
        self._muted = False
        self._trouble = ""
        self._attempts = 0
        self._next_attempt_s = 0.0
        self._zeros_since_s: float | None = None
        self._slow_until_s = 0.0
        self._lost_before_s = 0.0
        self._stepped_s = 0.0

    def mute(self, muted: bool) -> None:
        """Close the microphone, or let it be opened again."""
        self._muted = muted
        if muted:
            self._close()
            self._trouble = ""
        self._attempts, self._next_attempt_s = 0, 0.0

    def step(self) -> None:
        """Take in a little sound, or try to get a microphone; ends within some 0.1 s unless
        PortAudio hangs."""
        if self._microphone is None and not self._muted:
            self._open_if_due()
        microphone = self._microphone
        if microphone is None:
            threading.Event().wait(STEP_S)
        else:
            self._listen(microphone)
        self._tell_condition()

    def close(self) -> None:
        """Let go of the microphone."""
        self._close()

    def _open_if_due(self) -> None:
        if time.monotonic() < self._next_attempt_s:
            return
        try:
            self._microphone = Microphone(self._wanted)
        except HearingError as error:
            self._lose(str(error))
            return
        self._watch = _SourceWatch()
        self._zeros_since_s = None
        self._lost_before_s, self._stepped_s = 0.0, time.monotonic()

    def _listen(self, microphone: Microphone) -> None:
        sound = microphone.read(STEP_S)
        now_s = time.monotonic()
        if sound:
            self._check_zeros(sound, now_s)
        held_up = now_s - self._stepped_s > HELD_UP_S
        self._stepped_s = now_s
        if held_up or microphone.lost_s > self._lost_before_s:
            # What was thrown away is gone; the rest is old, and does not belong together.
            microphone.drain()
            self._lost_before_s = microphone.lost_s
            self._slow_until_s = now_s + SLOW_SHOWN_S
            self._pipeline.forget()
            return
        source = self._source()
        limit_s = SILENCE_S if microphone.heard_s is not None else FIRST_SOUND_S
        if microphone.finished:
            self._lose("The microphone's stream has ended.")
        elif microphone.silent_for_s > limit_s:
            self._lose("The microphone delivers no sound: it was unplugged or suspended.")
        elif source is not None and self._is_another(microphone, source):
            self._lose(f"The microphone is gone; {source.description} took its place.")
        elif self._zeros_since_s is not None and now_s - self._zeros_since_s > REOPEN_SILENT_S:
            self._close()
        elif sound:
            self._trouble = ""
            if now_s - microphone.opened_s > 2.0 * SILENCE_S:
                self._attempts = 0
            self._feed(sound)

    def _feed(self, sound: bytes) -> None:
        for event in self._pipeline.feed(sound):
            if isinstance(event, Segment):
                # The pipeline counts sound; the daemon wants to know when that was.
                ago_s = self._pipeline.now_s - event.speech_end_s
                ended_s = time.monotonic() - ago_s
                self._tell(event.model_copy(update={"speech_end_s": ended_s}))
            else:
                self._tell(event)

    def _check_zeros(self, sound: bytes, now_s: float) -> None:
        if any(sound):
            self._zeros_since_s = None
        elif self._zeros_since_s is None:
            self._zeros_since_s = now_s

    def _is_another(self, microphone: Microphone, source: Source) -> bool:
        """Any real microphone may follow another where the configuration names none."""
        return source.monitor or microphone.source not in ("", source.name)

    def _source(self) -> Source | None:
        if self._watch is None:
            return None
        return self._watch.source

    def _lose(self, why: str) -> None:
        self._close()
        self._trouble = why
        wait_s = BACK_OFF_S[min(self._attempts, len(BACK_OFF_S) - 1)]
        self._attempts += 1
        self._next_attempt_s = time.monotonic() + wait_s

    def _close(self) -> None:
        watch, self._watch = self._watch, None
        if watch is not None:
            watch.end()
        microphone, self._microphone = self._microphone, None
        if microphone is not None:
            self._pipeline.forget()
            microphone.close()

    def _tell_condition(self) -> None:
        condition = self._condition()
        if condition != self._told:
            self._told = condition
            self._tell(condition)

    def _condition(self) -> Condition:
        if self._muted:
            return Condition(state="muted", sentence="The microphone is off.")
        if self._trouble:
            return Condition(state="lost", sentence=self._trouble)
        microphone = self._microphone
        if microphone is None or microphone.heard_s is None:
            if self._told is not None and self._told.state != "muted":
                return self._told
            return Condition(state="starting", sentence="The microphone is opened.")
        source = self._source()
        device = source.description if source is not None else microphone.name
        state, sentence = self._hearing(source is not None and source.muted)
        return Condition(state=state, device=device, sentence=sentence)

    def _hearing(self, muted_elsewhere: bool) -> tuple[EarsCondition, str]:
        """How an open microphone is."""
        now_s = time.monotonic()
        if self._zeros_since_s is not None and now_s - self._zeros_since_s > ZEROS_S:
            why = "it is muted in the sound settings" if muted_elsewhere else "is its switch off?"
            return "silent", f"The microphone is silent: {why}"
        if now_s < self._slow_until_s:
            return "slow", "I missed something; the computer is too busy."
        if self._pipeline.recording:
            return "recording", "I am listening."
        if self._pipeline.open_to_all:
            return "listening", "Say what you would like."
        return "waiting", self._pipeline.how_to_begin


class _SourceWatch:
    """Asks the sound server in a thread of its own, for it may take its time."""

    def __init__(self) -> None:
        self.source: Source | None = None
        """What is recorded; None when nobody can tell."""
        self._ended = threading.Event()
        threading.Thread(target=self._run, name="source watch", daemon=True).start()

    def end(self) -> None:
        """Ask no more; the thread ends after the present question."""
        self._ended.set()

    def _run(self) -> None:
        while not self._ended.is_set():
            self.source = sound_server.recorded_source()
            self._ended.wait(SOURCE_EVERY_S)
