"""The first choice: Vosk, small, quick and with partial results."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from cellctl.errors import HearingError
from cellctl.listening.recogniser import SAMPLE_RATE_HZ, Samples, Transcript

_CHUNK = SAMPLE_RATE_HZ // 4
_REQUIRED = (("am/final.mdl",), ("conf/model.conf",), ("graph/HCLG.fst", "graph/HCLr.fst"))
"""Files of a Vosk model; of each tuple one must be there."""


def missing_files(folder: Path) -> list[str]:
    """What a folder lacks to be a Vosk model, as relative paths; empty when it is one.

    Asked before Vosk is: a wrong path makes it raise a bare ``Exception`` and log to stderr.
    """
    return [
        " or ".join(names)
        for names in _REQUIRED
        if not any((folder / name).is_file() for name in names)
    ]


class VoskRecogniser:
    """Recognises utterances with one Vosk model.

    Args:
        folder: the model, unpacked.
        name: what it is called, for people.

    Raises:
        HearingError: vosk is not installed, or the folder holds no model that it can load.
    """

    def __init__(self, folder: Path, name: str) -> None:
        if lacking := missing_files(folder):
            raise HearingError(
                f"{folder}: is not a Vosk model folder: {', '.join(lacking)} missing.",
                "Unpack a model there, so that am/, conf/ and graph/ stand in the folder itself.",
            )
        try:
            import vosk  # noqa: PLC0415 - loads a 25 MB library
        except ImportError as error:
            raise HearingError(
                "vosk is not installed.", "Install it with pip install 'cellctl[speech]'."
            ) from error
        vosk.SetLogLevel(-1)
        # Only ever by path: a model looked up by name reaches for the network, checks no hash, and
        # ends the process when the name is unknown.
        try:
            # It raises nothing more precise than Exception.
            self._model = vosk.Model(model_path=str(folder.resolve()))
        except Exception as error:
            raise HearingError(
                f"{folder}: the Vosk model cannot be loaded ({error}).",
                "Unpack it again from the archive it came in.",
            ) from error
        self._new_recognizer = vosk.KaldiRecognizer
        self.name = name

    def transcribe(self, samples: Samples) -> Transcript:
        """Recognise one utterance; silence and noise give an empty text."""
        recognizer = self._new_recognizer(self._model, SAMPLE_RATE_HZ)
        recognizer.SetWords(True)
        words: list[dict[str, Any]] = []
        for start in range(0, len(samples), _CHUNK):
            if recognizer.AcceptWaveform(samples[start : start + _CHUNK].tobytes()):
                words += json.loads(recognizer.Result()).get("result", [])
        words += json.loads(recognizer.FinalResult()).get("result", [])
        spoken = [word for word in words if word["word"] != "[unk]"]
        if not spoken:
            return Transcript(text="", confidence=0.0)
        confidence = sum(float(word["conf"]) for word in spoken) / len(spoken)
        return Transcript(
            text=" ".join(str(word["word"]) for word in spoken),
            confidence=min(1.0, max(0.0, confidence)),
        )
