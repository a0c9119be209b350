"""From sound to utterances, faster than real time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cellctl.errors import HearingError
from cellctl.listening.ears.detectors import MicroWakeWordDetector, SileroDetector
from cellctl.listening.ears.events import Draft, Heard, NoSpeech, Segment, WakeWordHeard
from cellctl.listening.ears.pipeline import NO_SPEECH_S, REQUEST_LONGEST_S, Pipeline
from cellctl.listening.ears.words import overheard_command
from cellctl.listening.recogniser import Recogniser
from cellctl.listening.wav import read_wav
from cellctl.sim import sounds
from cellctl.sim.sounds import Samples

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


def quiet(seconds: float) -> Samples:
    """A quiet room."""
    return sounds.noise(seconds, 1, 0.0006)


def heard(pipeline: Pipeline, *sound: Samples) -> list[Heard]:
    """What comes out of all that sound."""
    return list(pipeline.feed(np.concatenate(sound).tobytes()))


def segments(events: list[Heard]) -> list[Segment]:
    return [event for event in events if isinstance(event, Segment)]


def test_an_utterance_is_cut_out_with_its_beginning_and_end(say: Say) -> None:
    wish = say("I want a simple stool")
    (segment,) = heard(Pipeline(SileroDetector()), quiet(2.0), wish, quiet(2.0))
    assert isinstance(segment, Segment)
    assert segment.after == ""
    spoken_s = len(wish) / 16_000
    assert segment.speech_end_s == pytest.approx(2.0 + spoken_s, abs=0.25)
    assert spoken_s < len(segment.samples) / 16_000 < spoken_s + 1.3


def test_sound_may_come_in_pieces_of_any_length(say: Say) -> None:
    sound = np.concatenate([quiet(1.0), say("yes"), quiet(1.0)]).tobytes()
    pipeline = Pipeline(SileroDetector())
    by_pieces = [
        event
        for start in range(0, len(sound), 700)
        for event in pipeline.feed(sound[start : start + 700])
    ]
    assert by_pieces == list(Pipeline(SileroDetector()).feed(sound))
    assert by_pieces


def test_a_request_outlasts_a_pause_that_ends_a_command(say: Say) -> None:
    sound = (quiet(1.0), say("I want"), quiet(0.42), say("a simple stool"), quiet(1.0))
    requests = Pipeline(SileroDetector(), open_to_all=True)
    (whole,) = segments(heard(requests, *sound))
    assert whole.after == "open"
    commands = Pipeline(SileroDetector(), open_to_all=True)
    commands.expecting = "command"
    assert [part.after for part in segments(heard(commands, *sound))] == ["", ""]


def test_a_command_comes_out_soon_after_its_end(say: Say) -> None:
    pipeline = Pipeline(SileroDetector())
    pipeline.expecting = "command"
    word = say("stop")
    assert heard(pipeline, quiet(1.0), word) == []
    end_s = pipeline.now_s
    for _ in range(20):
        if heard(pipeline, quiet(0.032)):
            break
    assert pipeline.now_s - end_s < 0.45


def test_a_command_is_cut_out_of_fainter_talk_before_and_after_it(
    say: Say, whisper: Recogniser
) -> None:
    talk = (say("it moves quite fast and I like this one") * 0.08).astype(np.int16)
    word = say("please stop")
    pipeline = Pipeline(SileroDetector())
    pipeline.expecting = "command"
    heard(pipeline, quiet(1.0))
    found = segments(heard(pipeline, talk, word, talk, quiet(1.0)))
    commands = [overheard_command(whisper.transcribe(part.samples).text) for part in found]
    assert commands.count("stop") == 1
    stop = found[commands.index("stop")]
    assert len(stop.samples) / 16_000 < len(word) / 16_000 + 0.9
    assert stop.speech_end_s == pytest.approx(1.0 + (len(talk) + len(word)) / 16_000, abs=0.3)


@pytest.mark.parametrize("pause_s", [0.0, 0.5])
def test_what_follows_the_wake_word_is_a_request(
    say: Say, whisper: Recogniser, pause_s: float
) -> None:
    pipeline = Pipeline(SileroDetector(), MicroWakeWordDetector("hey_mycroft"))
    sound = (say("hey mycroft"), quiet(pause_s), say("I want a simple stool"), quiet(1.5))
    woken, *drafts, segment = heard(pipeline, quiet(1.0), *sound)
    assert all(isinstance(each, Draft) for each in drafts)
    assert isinstance(woken, WakeWordHeard)
    assert isinstance(segment, Segment)
    assert segment.after == "wake_word"
    assert pipeline.recording == ""
    text = whisper.transcribe(segment.samples).text.lower()
    assert "simple stool" in text
    assert "mycroft" not in text


def test_without_the_wake_word_speech_is_passed_on_as_nobodys(say: Say) -> None:
    pipeline = Pipeline(SileroDetector(), MicroWakeWordDetector("hey_mycroft"))
    (segment,) = heard(pipeline, quiet(1.0), say("I want a simple stool"), quiet(1.0))
    assert isinstance(segment, Segment)
    assert segment.after == ""


def test_the_button_waits_six_seconds_for_speech(say: Say) -> None:
    pipeline = Pipeline(SileroDetector())
    pipeline.listen()
    assert pipeline.recording
    assert heard(pipeline, quiet(NO_SPEECH_S + 0.1)) == [NoSpeech()]
    pipeline.listen()
    (segment,) = segments(heard(pipeline, quiet(4.0), say("the letter T"), quiet(1.0)))
    assert segment.after == "push_to_talk"


def test_a_request_without_end_is_cut_off(say: Say) -> None:
    pipeline = Pipeline(SileroDetector())
    pipeline.listen()
    endless = np.tile(np.concatenate([say("I want a simple stool"), quiet(0.1)]), 12)
    first = segments(heard(pipeline, endless))[0]
    assert first.after == "push_to_talk"
    assert REQUEST_LONGEST_S - 1.0 < len(first.samples) / 16_000 < REQUEST_LONGEST_S + 0.5


def test_of_long_talk_to_others_only_the_end_is_passed_on(say: Say) -> None:
    pipeline = Pipeline(SileroDetector())
    talk = np.tile(np.concatenate([say("where is the coffee"), quiet(0.05)]), 10)
    (segment,) = segments(heard(pipeline, quiet(0.5), talk, quiet(1.0)))
    assert len(talk) / 16_000 > 8.0
    assert len(segment.samples) / 16_000 < 4.0


@pytest.mark.parametrize(
    "sound", [sounds.noise(20.0, 3), sounds.music(20.0, 3)], ids=["noise", "music"]
)
def test_noise_and_music_are_no_speech(sound: Samples) -> None:
    pipeline = Pipeline(SileroDetector(), MicroWakeWordDetector("hey_mycroft"))
    assert heard(pipeline, sound) == []


def test_sound_that_was_lost_is_not_glued_over(say: Say) -> None:
    pipeline = Pipeline(SileroDetector())
    assert heard(pipeline, quiet(1.0), say("I want")) == []
    pipeline.forget()
    assert heard(pipeline, quiet(1.0)) == []


def test_an_unknown_wake_word_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(HearingError, match="no wake word") as caught:
        MicroWakeWordDetector("open sesame")
    assert "hey_mycroft" in caught.value.hint


@pytest.mark.parametrize(
    ("text", "command"),
    [
        ("Stop!", "stop"),
        ("oh god, stop", "stop"),
        ("Stop, it is falling", "stop"),
        ("don't stop", None),
        ("never stop building it", None),
        ("we made a stop at the coffee bar and then we went on", None),
        ("where is the bus stop near the old town hall", None),
        ("yes please", "yes"),
        ("yes I saw that", None),
        ("", None),
    ],
)
def test_words_that_nobody_was_asked_for(text: str, command: str | None) -> None:
    assert overheard_command(text) == command
