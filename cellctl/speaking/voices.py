"""Voices: text in, sound out, offline.

The packaged voice ``hibari-tts`` speaks English; ``espeak-ng`` speaks other languages, and English
where the packaged voice is missing. Both read numbers and units as words.
"""

from __future__ import annotations

import importlib.util
import io
import shutil
import subprocess
import tempfile
import wave
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from cellctl.errors import HearingError
from cellctl.sound.privacy import keep_libraries_offline

if TYPE_CHECKING:
    from hibari import Hibari

Samples = npt.NDArray[np.int16]

_NOISE_SEED = 1
"""Fixes the voice's noise component: the same text gives the same sound."""
_ESPEAK_TIMEOUT_S = 30.0
_ESPEAK_VOICES = {"en": "en-us"}
"""Where espeak-ng's name for a language is not its code."""
_FULL_SCALE = 32_767


class Sound(NamedTuple):
    """Mono sound."""

    samples: Samples
    rate_hz: int


class Voice(Protocol):
    """Speaks one language."""

    name: str
    """Of the engine and its voice, for people."""

    def speak(self, text: str) -> Sound:
        """What a text sounds like; blocks while it is made.

        Raises:
            HearingError: it cannot be made.
        """
        ...


def open_voice(language: str, wanted: str = "") -> Voice:
    """The voice for a language; may load a model, which takes a second or two.

    Args:
        language: its code, such as ``de``.
        wanted: one of espeak-ng's voices, such as ``en-gb+f3``; empty for the best there is.

    Raises:
        HearingError: there is none.
    """
    if not wanted and language == "en" and importlib.util.find_spec("hibari") is not None:
        return HibariVoice()
    if (program := shutil.which("espeak-ng")) is not None:
        return EspeakVoice(program, wanted or _ESPEAK_VOICES.get(language, language))
    raise HearingError(
        f"No voice for {language!r}: tried hibari-tts (English only) and espeak-ng.",
        "Install one: pip install 'cellctl[voice]', or apt install espeak-ng.",
    )


class HibariVoice:
    """The packaged English voice."""

    name = "hibari heart"

    def __init__(self) -> None:
        self._hibari = _hibari()

    def speak(self, text: str) -> Sound:
        """See ``Voice``."""
        sound = np.clip(self._hibari(text, seed=_NOISE_SEED), -1.0, 1.0)
        return Sound((sound * _FULL_SCALE).astype(np.int16), self._hibari.sample_rate)


class EspeakVoice:
    """One of espeak-ng's voices.

    Args:
        program: its path.
        voice: its name for the voice.
    """

    def __init__(self, program: str, voice: str) -> None:
        self.name = f"espeak-ng {voice}"
        self._command = [program, "-v", voice, "--stdin", "--stdout"]

    def speak(self, text: str) -> Sound:
        """See ``Voice``."""
        # The text goes in by standard input: it may start with a dash.
        try:
            done = subprocess.run(  # noqa: S603 - a fixed program with fixed arguments
                self._command,
                input=text.encode(),
                capture_output=True,
                timeout=_ESPEAK_TIMEOUT_S,
                check=True,
            )
        except subprocess.CalledProcessError as error:
            detail = error.stderr.decode(errors="replace").strip()
            raise HearingError(
                f"espeak-ng failed with status {error.returncode}: {detail}",
                "Look at voice.voice: `espeak-ng --voices` lists them.",
            ) from error
        except subprocess.TimeoutExpired as error:
            raise HearingError(f"espeak-ng did not finish in {_ESPEAK_TIMEOUT_S:g} s.") from error
        except OSError as error:
            raise HearingError(f"espeak-ng cannot be started: {error}.") from error
        # It writes the header before it knows the length.
        with wave.open(io.BytesIO(done.stdout)) as wav:
            rate_hz, start = wav.getframerate(), done.stdout.index(b"data") + 8
        whole = len(done.stdout) - (len(done.stdout) - start) % 2
        return Sound(np.frombuffer(done.stdout[start:whole], dtype="<i2"), rate_hz)


def speak_to_wav(text: str, path: Path, language: str = "en") -> str:
    """Speak a sentence into a wav file (mono, 16 bit). Blocks for up to some seconds.

    Args:
        text: what to say.
        path: the file to write; it appears complete or not at all.
        language: its code.

    Returns:
        The voice's name.

    Raises:
        HearingError: there is nothing to say, no voice, or the file cannot be written.
    """
    if not text.strip():
        raise HearingError("There is nothing to say.", "Give a sentence.")
    voice = open_voice(language)
    sound = voice.speak(text)
    try:
        with tempfile.TemporaryDirectory(prefix=".speech-", dir=path.parent) as scratch:
            spoken = Path(scratch) / "speech.wav"
            with wave.open(str(spoken), "wb") as wav:
                wav.setnchannels(1)
                wav.setsampwidth(2)
                wav.setframerate(sound.rate_hz)
                wav.writeframes(sound.samples.astype("<i2").tobytes())
            spoken.replace(path)
    except OSError as error:
        raise HearingError(
            f"{path}: the speech cannot be written: {error.strerror or error}.",
            "Name a file in a folder that exists and is writable.",
        ) from error
    return voice.name


@cache
def _hibari() -> Hibari:
    """The voice, loaded once: that takes a second, and speaking then a few milliseconds."""
    keep_libraries_offline()
    from hibari import Hibari  # noqa: PLC0415 - loads onnxruntime, only where it is used

    return Hibari()
