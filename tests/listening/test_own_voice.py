"""The cell's own voice at its microphone: it is told from people's, by its level and its words."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cellctl.listening.ears.detectors import MicroWakeWordDetector, SileroDetector
from cellctl.listening.ears.events import OWN_VOICE_STEP_S, Draft, Heard, Segment, WakeWordHeard
from cellctl.listening.ears.pipeline import CHUNK_S, Pipeline
from cellctl.listening.own_words import OwnWords, of_others, says_stop
from cellctl.listening.recogniser import Recogniser
from cellctl.listening.wav import read_wav
from cellctl.sim import sounds
from cellctl.sim.sounds import Samples

SENTENCE = "A stool with four legs, thirty parts, about three minutes. Shall I build it?"
DELAY_S = 0.15

Say = Callable[[str], Samples]


@pytest.fixture
def say(speak: Callable[[str], Path]) -> Say:
    """Speaks a sentence, without the silence around it."""

    def said(text: str) -> Samples:
        samples = read_wav(speak(text), 30.0)
        loud = np.flatnonzero(np.abs(samples.astype(np.int32)) > 300)
        trimmed: Samples = samples[loud[0] : loud[-1] + 1]
        return trimmed

    return said


def levels(sound: Samples) -> tuple[float, ...]:
    """What the mouth tells of a sentence."""
    step = round(OWN_VOICE_STEP_S * 16_000)
    whole = sound[: len(sound) // step * step].astype(np.float64).reshape(-1, step)
    return tuple(float(level) for level in np.sqrt(np.square(whole).mean(axis=1)))


class Room:
    """A microphone that hears the cell speak, and people."""

    def __init__(self, pipeline: Pipeline, echo_db: float) -> None:
        self.pipeline = pipeline
        self.gain = 10.0 ** (echo_db / 20.0)

    def quiet(self, seconds: float) -> list[Heard]:
        """Nobody speaks."""
        return self._heard(sounds.noise(seconds, 1, 0.0006))

    def cell_speaks(self, own: Samples, person: Samples | None = None, at_s: float = 0.0,
                    *, wakes: bool = False) -> list[Heard]:  # fmt: skip
        """The cell says something, and somebody may talk over it ``at_s`` later."""
        self.pipeline.own_voice_began(self.pipeline.now_s, levels(own), wakes)
        sound = sounds.noise(len(own) / 16_000 + 1.0, 2, 0.0006).astype(np.float64)
        start = round(DELAY_S * 16_000)
        sound[start : start + len(own)] += self.gain * own
        if person is not None:
            start = round(at_s * 16_000)
            sound[start : start + len(person)] += person[: len(sound) - start]
        return self._heard(np.clip(sound, -32_768, 32_767).astype(np.int16))

    def _heard(self, sound: Samples) -> list[Heard]:
        return list(self.pipeline.feed(sound.tobytes()))


def pipeline(wake_word: str | None = None) -> Pipeline:
    """As while the cell asks."""
    made = Pipeline(
        SileroDetector(), MicroWakeWordDetector(wake_word) if wake_word is not None else None
    )
    made.expecting = "command"
    return made


def segments(events: list[Heard]) -> list[Segment]:
    return [event for event in events if isinstance(event, Segment)]


@pytest.mark.parametrize("echo_db", [-40.0, -6.0])
def test_the_cell_does_not_hear_itself(say: Say, echo_db: float) -> None:
    room = Room(pipeline(), echo_db)
    room.quiet(2.0)
    for _ in range(2):
        assert segments(room.cell_speaks(say(SENTENCE))) == []


@pytest.mark.parametrize(("word", "echo_db"), [("stop", -40.0), ("stop", -20.0), ("yes", -20.0)])
def test_a_word_is_cut_out_of_the_cells_own_sentence(
    say: Say, whisper: Recogniser, word: str, echo_db: float
) -> None:
    room = Room(pipeline(), echo_db)
    room.quiet(2.0)
    room.cell_speaks(say(SENTENCE))
    found = segments(room.cell_speaks(say(SENTENCE), say(word), 2.0))
    texts = [whisper.transcribe(each.samples).text.strip(" .!").lower() for each in found]
    assert [text for text in texts if of_others(text, SENTENCE)] == [word]


def test_people_are_heard_again_as_soon_as_the_cell_is_silent(say: Say) -> None:
    room = Room(pipeline(), -12.0)
    room.quiet(2.0)
    room.cell_speaks(say(SENTENCE))
    room.quiet(0.5)
    yes = say("yes")
    word = np.concatenate([yes, sounds.noise(0.5, 3, 0.0006)])
    (found,) = segments(list(room.pipeline.feed(word.tobytes())))
    # When it began tells which question it answers.
    assert found.speech_s == pytest.approx(len(yes) / 16_000, abs=0.2)


def test_the_cell_does_not_wake_itself(say: Say) -> None:
    room = Room(pipeline("hey_mycroft"), -12.0)
    hint = say("Say hey mycroft")
    room.quiet(2.0)
    assert not [e for e in room.cell_speaks(hint, wakes=True) if isinstance(e, WakeWordHeard)]
    # Of a sentence that does not say it, a person's does wake.
    room.quiet(2.0)
    heard = room.cell_speaks(say(SENTENCE), say("hey mycroft"), 1.5)
    assert [event for event in heard if isinstance(event, WakeWordHeard)]


def test_a_request_is_drafted_before_the_silence_that_ends_it(say: Say) -> None:
    made = Pipeline(SileroDetector(), open_to_all=True)
    sound = np.concatenate(
        [sounds.noise(1.5, 1, 0.0006), say("I want"), sounds.noise(0.42, 1, 0.0006),
         say("a simple stool"), sounds.noise(1.0, 1, 0.0006)]
    )  # fmt: skip
    events = list(made.feed(sound.tobytes()))
    *drafts, whole = events
    assert [type(each) for each in events] == [Draft, Draft, Segment]
    assert isinstance(whole, Segment)
    assert [isinstance(each, Draft) and each.mark == whole.mark for each in drafts] == [False, True]
    assert CHUNK_S < 0.04


@pytest.mark.parametrize(
    ("heard", "others"),
    [
        ("A stool with four legs, thirty parts, about three minutes.", ""),
        ("Shall I build it?", ""),
        ("shall i built it", ""),
        ("Stop!", "Stop!"),
        ("Yes.", "Yes."),
        ("about three minutes stop stop please", "stop stop please"),
        ("I want a bench instead", "I want a bench instead"),
        ("", ""),
    ],
)
def test_what_the_cell_says_itself_is_left_out(heard: str, others: str) -> None:
    assert of_others(heard, SENTENCE) == others


def test_a_command_is_anybodys_but_in_the_cells_very_words() -> None:
    own = "7 parts stand here. Take the object along, or have it taken apart."
    assert of_others("The letter L.", "The letter T. Letter T, 7 parts.") == "The letter L."
    assert of_others("Take it apart.", own, command=True) == "Take it apart."
    assert of_others("Take it apart.", "Shall I take it apart?", command=True) == ""


def test_its_own_yes_is_no_answer() -> None:
    own = "Say yes, no, or what to change."
    assert of_others("yes", own) == ""
    assert of_others("Yes no", own) == ""
    assert of_others("yes", "") == "yes"
    assert says_stop("Say stop to stop me.")
    assert not says_stop(own)


def test_words_are_remembered_with_their_time() -> None:
    words = OwnWords()
    words.began(1, "one", 10.0)
    assert not words.ended(2, 10.5)
    assert words.during(11.0, 12.0) == "one"
    assert words.ended(1, 11.0)
    words.began(3, "", 12.0)
    words.began(4, "two", 13.0)
    assert words.during(9.0, 9.9) == ""
    assert words.during(11.2, 12.5) == "one"
    assert words.during(12.0, 14.0) == "two"
    assert words.during(11.3, 13.5) == "one two"
