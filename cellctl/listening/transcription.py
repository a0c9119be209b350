"""What the recogniser's own process runs: a file in, words out.

The loaded model is kept between calls for as long as the process lives. Importing this module
loads no recogniser.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np

from cellctl.assembly import Utterance
from cellctl.config import HearingSection
from cellctl.listening.models import open_recogniser
from cellctl.listening.recogniser import QuickStop, Recogniser, Samples
from cellctl.listening.wav import duration_s, is_silent, read_wav

_loaded: dict[HearingSection, Recogniser] = {}


def load(settings: HearingSection) -> str:
    """Load the model, unless it is already; returns the recogniser's name.

    Raises:
        HearingError: there is no model, or it does not load.
    """
    return _recogniser(settings).name


def transcribe_wav(settings: HearingSection, path: Path) -> Utterance:
    """Recognise one file; silence gives an empty text without a model being run.

    Raises:
        HearingError: the file cannot be used, or there is no model.
    """
    return _transcribe(settings, read_wav(path, settings.max_audio_s), "wav")


def transcribe_pcm(settings: HearingSection, pcm: bytes) -> Utterance:
    """Recognise sound from the microphone: 16 kHz mono 16 bit, in memory only.

    Raises:
        HearingError: there is no model.
    """
    return _transcribe(settings, np.frombuffer(pcm, dtype=np.int16), "microphone")


def says_stop(settings: HearingSection, pcm: bytes) -> bool:
    """A quick look whether this is "stop" and nothing else; False where the recogniser has no
    quicker way than to recognise everything.

    Raises:
        HearingError: there is no model.
    """
    recogniser = _recogniser(settings)
    samples = np.frombuffer(pcm, dtype=np.int16)
    return (
        isinstance(recogniser, QuickStop)
        and not is_silent(samples)
        and recogniser.says_stop(samples)
    )


def _transcribe(
    settings: HearingSection, samples: Samples, source: Literal["wav", "microphone"]
) -> Utterance:
    if is_silent(samples):
        return Utterance(text="", source=source, confidence=1.0, audio_s=duration_s(samples))
    recogniser = _recogniser(settings)
    transcript = recogniser.transcribe(samples)
    return Utterance(
        text=transcript.text,
        source=source,
        recogniser=recogniser.name,
        confidence=transcript.confidence,
        audio_s=duration_s(samples),
    )


def _recogniser(settings: HearingSection) -> Recogniser:
    if settings not in _loaded:
        _loaded[settings] = open_recogniser(settings)
    return _loaded[settings]
