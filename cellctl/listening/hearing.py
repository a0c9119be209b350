"""Hearing as a service: sound or text in, an Utterance out, in every state of the cell.

The recogniser lives in a process of its own. It can be slow, large or crash, and the daemon's loop
neither waits for it nor dies with it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Self, TypeVar

from cellctl.assembly import Utterance
from cellctl.config import HearingSection
from cellctl.errors import HearingError
from cellctl.listening import transcription
from cellctl.listening.recogniser import SAMPLE_RATE_HZ
from cellctl.worker import WorkerError, WorkerProcess

T = TypeVar("T")

LOAD_TIMEOUT_S = 120.0
"""For starting the process and loading a large model from a slow disk."""
DOWNLOAD_TIMEOUT_S = 330.0
"""More than a download may take; only where one is allowed."""
RECOGNITION_S = 5.0
"""On top of that, for whatever else the machine is doing."""
RECOGNITION_FACTOR = 4.0
"""A machine slower than this many seconds for one second of audio is not fit to listen."""
MAX_TEXT_CHARACTERS = 500


class Hearing:
    """Hears wav files, sound from the microphone and typed text; one utterance at a time.

    Args:
        settings: the ``[hearing]`` table of the configuration.
    """

    def __init__(self, settings: HearingSection) -> None:
        self._settings = settings
        self._worker = WorkerProcess("recogniser")
        self._loaded_pid: int | None = None
        """The process that has the model; another one has to load it first."""

    async def warm_up(self) -> str:
        """Load the model now, so that the first utterance is heard without delay.

        Returns:
            The recogniser's name, for people.

        Raises:
            HearingError: there is no model, or its process failed.
        """
        return await self._call(transcription.load, (self._settings,), self._load_timeout_s)

    async def hear_wav(self, path: Path) -> Utterance:
        """Recognise the speech in a file; the text is empty when there is none.

        Raises:
            HearingError: the file cannot be used, there is no model, or its process failed. The
                process is started anew by the next call.
        """
        timeout_s = self._patience_s(self._settings.max_audio_s)
        return await self._call(transcription.transcribe_wav, (self._settings, path), timeout_s)

    async def hear_samples(self, pcm: bytes) -> Utterance:
        """Recognise sound from the microphone, which never touches the disk.

        Args:
            pcm: 16 kHz mono 16 bit.

        Raises:
            HearingError: there is no model, or its process failed. The process is started anew by
                the next call.
        """
        timeout_s = self._patience_s(_duration_s(pcm))
        return await self._call(transcription.transcribe_pcm, (self._settings, pcm), timeout_s)

    async def says_stop(self, pcm: bytes) -> bool:
        """Look quickly whether sound from the microphone is "stop" and nothing else.

        False does not mean that it is not: ``hear_samples`` looks closer.

        Raises:
            HearingError: there is no model, or its process failed.
        """
        timeout_s = self._patience_s(_duration_s(pcm))
        return await self._call(transcription.says_stop, (self._settings, pcm), timeout_s)

    def hear_text(self, text: str) -> Utterance:
        """Take a typed sentence as if it had been spoken.

        Raises:
            HearingError: it is longer than any sentence.
        """
        if len(text) > MAX_TEXT_CHARACTERS:
            raise HearingError(
                f"The text has {len(text)} characters; {MAX_TEXT_CHARACTERS} are read at most.",
                "Say it in one sentence.",
            )
        return Utterance(text=" ".join(text.split()), source="text")

    async def close(self) -> None:
        """End the recogniser's process; safe to repeat."""
        await self._worker.close()

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        await self.close()

    @property
    def worker_pid(self) -> int | None:
        """Process id of the recogniser, while it runs."""
        return self._worker.pid

    def _patience_s(self, audio_s: float) -> float:
        """Longest wait for so much sound: a process that hangs must not keep *stop* waiting."""
        loaded = self._worker.pid is not None and self._worker.pid == self._loaded_pid
        recognition_s = RECOGNITION_S + RECOGNITION_FACTOR * audio_s
        return recognition_s if loaded else self._load_timeout_s + recognition_s

    @property
    def _load_timeout_s(self) -> float:
        return LOAD_TIMEOUT_S + (DOWNLOAD_TIMEOUT_S if self._settings.allow_download else 0.0)

    async def _call(
        self, function: Callable[..., T], arguments: tuple[object, ...], timeout_s: float
    ) -> T:
        try:
            result = await self._worker.call(function, *arguments, timeout_s=timeout_s)
        except WorkerError as error:
            raise HearingError(
                f"Speech could not be recognised: {error.message}",
                "Say it again; the recogniser is started anew.",
            ) from error
        self._loaded_pid = self._worker.pid
        return result


def _duration_s(pcm: bytes) -> float:
    return len(pcm) / (2 * SAMPLE_RATE_HZ)
