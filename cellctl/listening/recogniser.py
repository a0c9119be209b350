"""What a recogniser is: sound in, words out."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Value

Samples = npt.NDArray[np.int16]
"""Mono audio, 16 bit, at ``SAMPLE_RATE_HZ``."""
SAMPLE_RATE_HZ = 16_000


class Transcript(Value):
    """What a recogniser made of some audio; empty text when it heard no speech."""

    text: str
    confidence: float


class Recogniser(Protocol):
    """Turns audio into words. Loading happens in the constructor, which raises HearingError."""

    name: str
    """Back end and model, for people: ``vosk vosk-model-small-en-us-0.15``."""

    def transcribe(self, samples: Samples) -> Transcript:
        """Recognise one utterance; silence and noise give an empty text."""
        ...


@runtime_checkable
class QuickStop(Protocol):
    """What a slow recogniser may have besides: a quick way to hear the word that matters most."""

    def says_stop(self, samples: Samples) -> bool:
        """Whether one utterance is "stop" and nothing else."""
        ...
