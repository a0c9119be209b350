"""A voice made on the spot, offline: for the demonstration and for tests of hearing."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from cellctl.errors import HearingError
from cellctl.listening.privacy import keep_libraries_offline

if TYPE_CHECKING:
    from hibari import Hibari

_NOISE_SEED = 1
"""Fixes the voice's noise component: the same text gives the same file."""
_ESPEAK_TIMEOUT_S = 30.0
_ESPEAK_VOICES = {"en": "en-us", "ko": "ko"}


def speak_to_wav(text: str, path: Path, language: str = "en") -> str:
    """Speak a sentence into a wav file (mono, 16 bit).

    The packaged voice ``hibari-tts`` speaks English; ``espeak-ng`` is used where it is missing and
    for other languages. Blocks for up to some seconds.

    Args:
        text: what to say.
        path: the file to write; it appears complete or not at all.
        language: ``en`` or ``ko``.

    Returns:
        The voice's name.

    Raises:
        HearingError: there is nothing to say, no voice, or the file cannot be written.
    """
    if not text.strip():
        raise HearingError("There is nothing to say.", "Give a sentence.")
    if language == "en" and importlib.util.find_spec("hibari") is not None:
        voice, speak = "hibari heart", _speak_hibari
    elif (program := shutil.which("espeak-ng")) is not None:
        voice = f"espeak-ng {_ESPEAK_VOICES[language]}"

        def speak(text: str, path: Path) -> None:
            _speak_espeak(program, _ESPEAK_VOICES[language], text, path)

    else:
        raise HearingError(
            f"No voice for {language!r}: tried hibari-tts (English only) and espeak-ng.",
            "Install one: pip install 'cellctl[demo]', or apt install espeak-ng.",
        )
    try:
        with tempfile.TemporaryDirectory(prefix=".speech-", dir=path.parent) as scratch:
            spoken = Path(scratch) / "speech.wav"
            speak(text, spoken)
            spoken.replace(path)
    except OSError as error:
        raise HearingError(
            f"{path}: the speech cannot be written: {error.strerror or error}.",
            "Name a file in a folder that exists and is writable.",
        ) from error
    return voice


def _speak_hibari(text: str, path: Path) -> None:
    _hibari().save(text, str(path), seed=_NOISE_SEED)


@cache
def _hibari() -> Hibari:
    """The voice, loaded once: that takes a second, and speaking then a few milliseconds."""
    keep_libraries_offline()
    from hibari import Hibari  # noqa: PLC0415 - loads onnxruntime, only where it is used

    return Hibari()


def _speak_espeak(program: str, voice: str, text: str, path: Path) -> None:
    # The text goes in by standard input: it may start with a dash.
    try:
        subprocess.run(  # noqa: S603 - a fixed program with fixed arguments
            [program, "-v", voice, "-w", str(path), "--stdin"],
            input=text.encode(),
            capture_output=True,
            timeout=_ESPEAK_TIMEOUT_S,
            check=True,
        )
    except subprocess.CalledProcessError as error:
        detail = error.stderr.decode(errors="replace").strip()
        raise HearingError(f"espeak-ng failed with status {error.returncode}: {detail}") from error
    except subprocess.TimeoutExpired as error:
        raise HearingError(f"espeak-ng did not finish in {_ESPEAK_TIMEOUT_S:g} s.") from error
