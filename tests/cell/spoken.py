"""People for tests: they speak into the cell's microphone, and hear what it says."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cellctl.listening.wav import read_wav
from cellctl.messages import VoiceData
from cellctl.sim.microphone import VirtualMicrophone
from cellctl.speaking.voices import speak_to_wav
from tests.cell.harness import RunningCell
from tests.virtual_sound import virtual_sound

WAKE_WORD = "hey_mycroft"
"""The packaged voice is understood by this one."""
ECHO_DB = -20.0
"""How much fainter the microphone hears the loudspeaker than it plays: a room without any echo
cancellation, with the loudspeaker turned down to what people can talk over."""


@dataclass
class People:
    """People in front of the cell."""

    microphone: VirtualMicrophone
    folder: Path

    def prepare(self, *texts: str) -> None:
        """Think of what to say; nobody hears it."""
        for text in texts:
            self._spoken(text)

    def say(self, text: str) -> float:
        """Say something to its end; returns the monotonic time of its last sound."""
        path = self._spoken(text)
        samples = read_wav(path, 30.0).astype(np.int32)
        last_s = float(np.flatnonzero(np.abs(samples) > 300)[-1]) / 16_000
        return self.microphone.speak(path) + last_s

    def _spoken(self, text: str) -> Path:
        path = self.folder / f"{text.replace(' ', '_')}.wav"
        if not path.exists():
            speak_to_wav(text, path)
        return path


@contextmanager
def people(*, echo_db: float | None = None) -> Iterator[People]:
    """People, and a sound server that every process started meanwhile uses.

    Args:
        echo_db: how loud the microphone hears the loudspeaker; None for not at all.
    """
    with (
        tempfile.TemporaryDirectory(prefix="voice-") as voice,
        virtual_sound() as microphone,
    ):
        if echo_db is not None:
            microphone.loudspeaker.echo(echo_db)
        yield People(microphone, Path(voice))


def hearing(activation: str, speed: float, *, loudspeaker: str = "none") -> dict[str, Any]:
    """Settings of a cell that is spoken to, by section.

    Args:
        activation: ``hearing.activation``.
        speed: cell seconds per wall second.
        loudspeaker: ``voice.loudspeaker``.
    """
    return {
        # Cell time, which passes quickly here.
        "policy": {"confirmation": "ask", "confirmation_timeout_s": 60.0 * speed},
        "hearing": {"microphone": "", "activation": activation, "wake_word": WAKE_WORD},
        "voice": {"loudspeaker": loudspeaker},
    }


def wait_for_ears(cell: RunningCell) -> None:
    """Wait until the cell hears, and would understand."""
    cell.wait("ears", lambda now: now.ears.state in {"waiting", "listening"})
    cell.wait("a recogniser", lambda now: "not loaded" not in now.recogniser)


def said(cell: RunningCell) -> list[str]:
    """What the cell said aloud, as far as its messages were taken in."""
    payloads = [message.payload() for message in cell.seen if message.topic == "voice"]
    texts = [data.saying for data in payloads if isinstance(data, VoiceData)]
    return [text for text in texts if text]
