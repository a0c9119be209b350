from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path

import pytest

from cellctl.errors import HearingError
from cellctl.listening.wav import duration_s, is_silent, read_wav
from cellctl.speaking.voices import speak_to_wav


def hide_hibari(monkeypatch: pytest.MonkeyPatch) -> None:
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "hibari" else found(name)
    )


def test_the_packaged_voice_speaks_and_repeats_itself(tmp_path: Path) -> None:
    once, again = tmp_path / "once.wav", tmp_path / "again.wav"
    assert speak_to_wav("a simple stool", once) == "hibari heart"
    speak_to_wav("a simple stool", again)
    samples = read_wav(once, 30.0)
    assert 0.5 < duration_s(samples) < 4.0
    assert not is_silent(samples)
    assert once.read_bytes() == again.read_bytes()
    assert {path.name for path in tmp_path.iterdir()} == {"once.wav", "again.wav"}


def test_espeak_is_the_fallback(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if shutil.which("espeak-ng") is None:
        pytest.skip("espeak-ng is not installed")
    hide_hibari(monkeypatch)
    path = tmp_path / "speech.wav"
    assert speak_to_wav("-v is no option here", path) == "espeak-ng en-us"
    assert not is_silent(read_wav(path, 30.0))


def test_without_a_voice_the_ways_to_get_one_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hide_hibari(monkeypatch)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(HearingError, match="No voice for 'en'") as caught:
        speak_to_wav("hello", tmp_path / "speech.wav")
    assert "espeak-ng" in caught.value.hint


def test_nothing_to_say_and_nowhere_to_write(tmp_path: Path) -> None:
    with pytest.raises(HearingError, match="nothing to say"):
        speak_to_wav("  ", tmp_path / "speech.wav")
    with pytest.raises(HearingError, match="cannot be written"):
        speak_to_wav("hello", tmp_path / "no" / "folder" / "speech.wav")
