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
from cellctl.listening.ears.events import Condition, EarsEvent, OwnVoiceBegan, Segment
from cellctl.listening.ears.microphone import Microphone
from cellctl.listening.ears.pipeline import Pipeline
from cellctl.messages import EarsCondition
from cellctl.sound import server
from cellctl.sound.back_off import BackOff
from cellctl.sound.server import ServerWatch, Source

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
_DRIFT_S = 0.0005
"""What the two clocks may drift apart in one piece of sound."""
SLOW_SHOWN_S = 2.0
"""How long it is told that sound was lost."""


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
        self._watch: ServerWatch[Source] | None = None
        self._muted = False
        self._trouble = ""
        self._back_off = BackOff()
        self._zeros_since_s: float | None = None
        self._slow_until_s = 0.0
        self._lost_before_s = 0.0
        self._stepped_s = 0.0
        self._lag_s: float | None = None
        """How much later than the pipeline's this machine's clock is."""

    def mute(self, muted: bool) -> None:
        """Close the microphone, or let it be opened again."""
        self._muted = muted
        if muted:
            self._close()
            self._trouble = ""
        self._back_off.begin_anew()

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

    def own_voice_began(self, began: OwnVoiceBegan) -> None:
        """The cell itself begins to speak."""
        self._pipeline.own_voice_began(self._heard_at_s(began.at_s), began.levels, began.wakes)

    def own_voice_ended(self, at_s: float) -> None:
        """It is silent again."""
        self._pipeline.own_voice.ended(self._heard_at_s(at_s))

    def close(self) -> None:
        """Let go of the microphone."""
        self._close()

    def _open_if_due(self) -> None:
        if not self._back_off.due:
            return
        try:
            self._microphone = Microphone(self._wanted)
        except HearingError as error:
            self._lose(str(error))
            return
        self._watch = ServerWatch(server.recorded_source)
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
            self._lag_s = None
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
                self._back_off.worked()
            self._feed(sound)

    def _heard_at_s(self, at_s: float) -> float:
        """The pipeline's time at a moment of this machine's monotonic clock."""
        lag_s = self._lag_s if self._lag_s is not None else time.monotonic() - self._pipeline.now_s
        return at_s - lag_s

    def _feed(self, sound: bytes) -> None:
        # Sound comes late or in time, never early; the two clocks drift apart slowly.
        lag_s = time.monotonic() - self._pipeline.now_s
        self._lag_s = lag_s if self._lag_s is None else min(lag_s, self._lag_s + _DRIFT_S)
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
        return self._watch.answer if self._watch is not None else None

    def _lose(self, why: str) -> None:
        self._close()
        self._trouble = why
        self._back_off.failed()

    def _close(self) -> None:
        watch, self._watch = self._watch, None
        if watch is not None:
            watch.end()
        microphone, self._microphone = self._microphone, None
        if microphone is not None:
            self._pipeline.forget()
            self._lag_s = None
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
