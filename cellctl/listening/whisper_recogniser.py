"""The packaged fallback: Whisper tiny.en through faster-whisper, on the CPU, offline."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cellctl.errors import HearingError
from cellctl.listening.commands import spoken_command
from cellctl.listening.recogniser import Samples, Transcript
from cellctl.sound.privacy import keep_libraries_offline

if TYPE_CHECKING:
    from faster_whisper import WhisperModel

CPU_THREADS = 2
BEAM_SIZE = 5
MIN_AVG_LOGPROB = -0.7
MAX_NO_SPEECH = 0.6
"""Measured gate: with both, none of 24 clips of music and noise came out as words. A doubtful
"stop" passes all the same: a stop too many does no harm."""

_GLANCE_FRAMES = 400
"""How much sound the first look for "stop" takes in, in frames of 10 ms. Whisper pads everything to
3000; with so few it stutters ("Stop. Stop. Stop."), and takes a tenth of the time."""
_GLANCE_TOKENS = 8
_STOPS = frozenset({"stop", "halt"})
_BESIDE_STOP = frozenset({"it", "now", "please", "that", "everything"})

PROMPT = (
    "Build me a stool with four legs, a shelf with two tiers, a table with one leg, the letter T, "
    "a chair with a back, a simple stool, a bench, a box, a tower."
)
"""Primes the decoder with the kiosk's words. Yes, no and stop must stay out of it: with them in,
silence is decoded as "No."."""


class WhisperRecogniser:
    """Recognises whole utterances; gives no partial results.

    Args:
        folder: a CTranslate2 conversion with ``model.bin`` and ``tokenizer.json``.
        name: what it is called, for people.

    Raises:
        HearingError: faster-whisper is not installed, or the model cannot be loaded.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self.name = name
        self._model = _load(folder)

    def transcribe(self, samples: Samples) -> Transcript:
        """Recognise one utterance; silence, music and noise give an empty text."""
        audio = samples.astype(np.float32) / 32768.0
        segments, _ = self._model.transcribe(
            audio,
            language="en",
            beam_size=BEAM_SIZE,
            temperature=0.0,
            initial_prompt=PROMPT,
            condition_on_previous_text=False,
            without_timestamps=True,
        )
        kept = [
            segment
            for segment in segments
            if segment.no_speech_prob < MAX_NO_SPEECH
            and (segment.avg_logprob > MIN_AVG_LOGPROB or spoken_command(segment.text) == "stop")
        ]
        text = " ".join(segment.text.strip() for segment in kept).strip()
        if not text:
            return Transcript(text="", confidence=0.0)
        logprob = sum(segment.avg_logprob for segment in kept) / len(kept)
        return Transcript(text=text, confidence=min(1.0, math.exp(logprob)))

    def says_stop(self, samples: Samples) -> bool:
        """A first look, ten times as quick as ``transcribe``: is this "stop", and nothing else?

        Hears it where it is said clearly; what it misses, ``transcribe`` may still hear.

        Args:
            samples: one utterance; of a longer one than 4 s the end.
        """
        from faster_whisper.tokenizer import Tokenizer  # noqa: PLC0415 - loaded by now

        model = self._model
        end = samples[-_GLANCE_FRAMES * 160 :].astype(np.float32) / 32768.0
        features = model.feature_extractor(end)[:, :_GLANCE_FRAMES]
        features = np.pad(features, ((0, 0), (0, _GLANCE_FRAMES - features.shape[1])))
        tokenizer = Tokenizer(
            model.hf_tokenizer, model.model.is_multilingual, task="transcribe", language="en"
        )
        prompt = model.get_prompt(tokenizer, [], without_timestamps=True)
        found = model.model.generate(
            model.encode(features),
            [prompt],
            beam_size=1,
            max_length=len(prompt) + _GLANCE_TOKENS,
            return_no_speech_prob=True,
        )[0]
        words = re.findall("[a-z]+", tokenizer.decode(found.sequences_ids[0]).lower())
        only_stop = bool(_STOPS & set(words)) and set(words) <= _STOPS | _BESIDE_STOP
        return only_stop and found.no_speech_prob < MAX_NO_SPEECH


def _load(folder: Path) -> WhisperModel:
    keep_libraries_offline()
    try:
        from faster_whisper import WhisperModel  # noqa: PLC0415 - heavy, only where it is used
        from tqdm import tqdm  # noqa: PLC0415 - comes with faster-whisper
    except ImportError as error:
        raise HearingError(
            "faster-whisper is not installed.", "Install it with pip install 'cellctl[speech]'."
        ) from error
    # faster-whisper makes a progress bar for each utterance; no thread shall watch over it.
    tqdm.monitor_interval = 0
    try:
        return WhisperModel(
            str(folder),
            device="cpu",
            compute_type="int8",
            cpu_threads=CPU_THREADS,
            local_files_only=True,
        )
    except (RuntimeError, ValueError, OSError) as error:
        raise HearingError(
            f"{folder}: the Whisper model cannot be loaded: {error}.",
            "Reinstall it with pip install --force-reinstall 'cellctl[speech]'.",
        ) from error
