"""One microphone, opened through PortAudio.

The callback does nothing but put the sound into a queue of limited length. A stream in trouble is
aborted, never stopped: ``stop`` waits for sound that may not come any more. PortAudio learns of
devices only when it is started anew, so it is, before each opening.
"""

from __future__ import annotations

import contextlib
import os
import queue
import time
from typing import TYPE_CHECKING, Any

from cellctl.listening.ears.detectors import CHUNK_BYTES, CHUNK_SAMPLES
from cellctl.listening.recogniser import SAMPLE_RATE_HZ
from cellctl.sound import server
from cellctl.sound.portaudio import SERVER_DEVICES, DeviceError, devices, portaudio, restart

if TYPE_CHECKING:
    import sounddevice

QUEUE_S = 1.5
"""Sound that may wait to be looked at; when more has come in, all of it is thrown away."""


class Microphone:
    """An open microphone; made by opening it.

    Args:
        wanted: ``hearing.microphone``: empty, or a part of a device's or a source's name.

    Raises:
        HearingError: there is none of that name, or it cannot be opened.
    """

    def __init__(self, wanted: str) -> None:
        library = portaudio()
        restart(library)
        device, self.name, self.source = _find(library, wanted)
        self.opened_s = time.monotonic()
        self.heard_s: float | None = None
        """When the newest sound came in (monotonic); None before the first."""
        self.finished = False
        """PortAudio has ended the stream by itself."""
        self.lost_s = 0.0
        """Sound that was thrown away because nobody took it in time."""
        self._queue: queue.Queue[bytes] = queue.Queue(int(QUEUE_S * SAMPLE_RATE_HZ / CHUNK_SAMPLES))
        try:
            self._stream: sounddevice.RawInputStream = library.RawInputStream(
                device=device,
                samplerate=SAMPLE_RATE_HZ,
                channels=1,
                dtype="int16",
                blocksize=CHUNK_SAMPLES,
                latency="low",
                callback=self._take,
                finished_callback=self._finish,
            )
            self._stream.start()
        except (library.PortAudioError, ValueError) as error:
            raise DeviceError(f"{self.name}: cannot be opened: {error}.") from error

    def read(self, timeout_s: float) -> bytes:
        """The next piece of sound; empty when none comes in time (wall time)."""
        with contextlib.suppress(queue.Empty):
            return self._queue.get(timeout=timeout_s)
        return b""

    @property
    def silent_for_s(self) -> float:
        """How long no sound has come in, zeros included (wall time)."""
        last_s = self.heard_s if self.heard_s is not None else self.opened_s
        return time.monotonic() - last_s

    def close(self) -> None:
        """Let go of it at once."""
        self._stream.abort(ignore_errors=True)
        self._stream.close(ignore_errors=True)

    def _take(self, sound: Any, frames: int, timing: object, status: object) -> None:
        """PortAudio's callback, in its own thread."""
        del frames, timing, status
        self.heard_s = time.monotonic()
        try:
            self._queue.put_nowait(bytes(sound))
        except queue.Full:
            self.lost_s += len(sound) / CHUNK_BYTES * CHUNK_SAMPLES / SAMPLE_RATE_HZ

    def _finish(self) -> None:
        self.finished = True

    def drain(self) -> None:
        """Throw away what waits."""
        with contextlib.suppress(queue.Empty):
            while True:
                self._queue.get_nowait()


def _find(library: Any, wanted: str) -> tuple[int, str, str]:
    """The microphone that is meant: PortAudio's number, its name for people, and the sound server's
    name where it was chosen by that."""
    os.environ.pop("PULSE_SOURCE", None)
    inputs = devices(library, "input")
    if not inputs:
        raise DeviceError("There is no microphone.", "Plug one in.")
    servers = [n for n, name in inputs.items() if name in SERVER_DEVICES]
    if not wanted:
        default = int(library.default.device[0])
        # The server shares its microphones; ALSA's own default may not.
        number = servers[0] if servers and server.sources() else default
        number = number if number in inputs else next(iter(inputs))
        return number, inputs[number], ""
    for number, name in inputs.items():
        if wanted.lower() in name.lower():
            return number, name, ""
    for source in server.sources() if servers else []:
        known_as = f"{source.name}\n{source.description}".lower()
        if wanted.lower() in known_as and not source.monitor:
            # The sound server's library reads this when the stream is opened.
            os.environ["PULSE_SOURCE"] = source.name
            return servers[0], source.description, source.name
    raise DeviceError(
        f"There is no microphone {wanted!r}.",
        "`cellctl microphone` lists what is there.",
    )
