"""Speech made on the spot, once for the whole folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import wavfile

from cellctl.config import HearingSection
from cellctl.listening.models import open_recogniser
from cellctl.listening.recogniser import Recogniser
from cellctl.speaking.voices import speak_to_wav

Speak = Callable[[str], Path]


@pytest.fixture(scope="session")
def speak(tmp_path_factory: pytest.TempPathFactory) -> Speak:
    """Speaks a sentence in the packaged voice; returns the wav file, the same for the same text."""
    folder = tmp_path_factory.mktemp("speech")

    def say(text: str) -> Path:
        path = folder / f"{text.replace(' ', '_')}.wav"
        if not path.exists():
            speak_to_wav(text, path)
        return path

    return say


@pytest.fixture
def no_models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home and a model folder without any Vosk model; returns the model folder."""
    home, models = tmp_path / "home", tmp_path / "models"
    home.mkdir()
    models.mkdir()
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.delenv("VOSK_MODEL_PATH", raising=False)
    return models


@pytest.fixture(scope="session")
def whisper(tmp_path_factory: pytest.TempPathFactory) -> Recogniser:
    """The packaged Whisper model, loaded."""
    folder = tmp_path_factory.mktemp("no-models")
    return open_recogniser(HearingSection(model_folder=str(folder)))


@pytest.fixture
def silent_wav(tmp_path: Path) -> Path:
    """Two seconds of a quiet sound card's noise."""
    path = tmp_path / "silent.wav"
    noise = np.random.default_rng(1).normal(0.0, 20.0, 32_000).astype(np.int16)
    wavfile.write(path, 16_000, noise)
    return path
