from __future__ import annotations

import shutil

import numpy as np
import pytest

from cellctl.errors import HearingError
from cellctl.speaking.chimes import chime
from cellctl.speaking.events import Chime
from cellctl.speaking.loudspeaker import RATE_HZ, envelope, prepared
from cellctl.speaking.reading import read_aloud
from cellctl.speaking.voices import Sound, open_voice


@pytest.mark.parametrize(
    ("shown", "language", "read"),
    [
        ("Stool, 30 x 30 x 40 cm.", "en", "Stool, 30 by 30 by 40 cm."),
        ("Hocker, 30 x 30 x 40 cm.", "de", "Hocker, 30 mal 30 mal 40 cm."),
        (
            "Say “Okay Nabu”, or use `cellctl refill`.",
            "en",
            "Say Okay Nabu, or use cellctl refill.",
        ),
        ("The letter x stands.", "en", "The letter x stands."),
    ],
)
def test_signs_are_read_as_words(shown: str, language: str, read: str) -> None:
    assert read_aloud(shown, language) == read


def test_numbers_are_spoken_as_words() -> None:
    voice = open_voice("en")
    figures = voice.speak("30 parts, about 3 minutes.").samples
    words = voice.speak("thirty parts, about three minutes.").samples
    assert np.array_equal(figures, words)


def test_other_languages_are_spoken_by_espeak() -> None:
    if shutil.which("espeak-ng") is None:
        pytest.skip("espeak-ng is not installed")
    voice = open_voice("de")
    assert voice.name == "espeak-ng de"
    samples, rate_hz = voice.speak("Soll ich es bauen?")
    assert 0.5 < len(samples) / rate_hz < 4.0
    with pytest.raises(HearingError, match="espeak-ng failed"):
        open_voice("de", "martian").speak("Hallo.")


def test_sound_is_as_loud_as_the_volume_says_and_begins_at_once() -> None:
    silence = np.zeros(24_000)
    tone = 3_000 * np.sin(np.arange(24_000) / 8.0)
    sound = Sound(np.concatenate([silence, tone, silence]).astype(np.int16), 24_000)
    samples = prepared(sound, 0.5)
    assert np.abs(samples).max() == pytest.approx(16_384, rel=0.01)
    assert len(samples) / RATE_HZ == pytest.approx(1.22, abs=0.02)
    levels = envelope(samples)
    assert len(levels) == pytest.approx(1.22 / 0.032, abs=1.5)
    assert levels[5] == pytest.approx(16_384 / np.sqrt(2), rel=0.02)


def test_silence_stays_silence() -> None:
    assert not prepared(Sound(np.zeros(100, dtype=np.int16), 24_000), 1.0).any()


@pytest.mark.parametrize("name", ["listening", "heard"])
def test_a_chime_is_short_and_fades(name: Chime) -> None:
    samples, rate_hz = chime(name)
    assert 0.2 < len(samples) / rate_hz < 0.6
    assert np.abs(samples[-100:].astype(int)).max() < 1_000 < np.abs(samples.astype(int)).max()
