"""One loudspeaker, opened through PortAudio.

Its stream runs while something is said. The callback does nothing but hand out sound that is ready,
well ahead of time: a busy computer must not make the voice stutter. ``hush`` throws away what was
handed out, so that it is quiet at once all the same.
"""

from __future__ import annotations

import math
import os
import threading
import time
from typing import TYPE_CHECKING, Any

import numpy as np

from cellctl.sound import server
from cellctl.sound.portaudio import SERVER_DEVICES, DeviceError, devices, portaudio, restart
from cellctl.speaking.events import ENVELOPE_STEP_S
from cellctl.speaking.voices import Samples, Sound

if TYPE_CHECKING:
    import sounddevice

RATE_HZ = 48_000
AHEAD_S = 0.25
"""Sound that is handed out ahead of time."""
_CHANNELS = 2
_SILENCE = 0.003
"""Of the loudest moment: what is fainter is left out before the first and after the last word,
..."""
_BEFORE, _AFTER = RATE_HZ // 50, RATE_HZ // 5
"""... but for so many frames."""


class Loudspeaker:
    """An open loudspeaker; made by opening it.

    Args:
        wanted: ``voice.loudspeaker``: empty, or a part of a device's or a sink's name.

    Raises:
        HearingError: there is none of that name, or it cannot be opened.
    """

    def __init__(self, wanted: str) -> None:
        library = portaudio()
        restart(library)
        device, self.name, self.sink, self.served = _find(library, wanted)
        self.asked_s = 0.0
        """When it last began, or asked for sound (monotonic)."""
        self._sound: Samples = np.zeros(0, dtype=np.int16)
        self._place = 0
        self._ends_s = 0.0
        self._running = threading.Event()
        try:
            self._stream: sounddevice.RawOutputStream = library.RawOutputStream(
                device=device,
                samplerate=RATE_HZ,
                channels=_CHANNELS,
                dtype="int16",
                latency=AHEAD_S,
                callback=self._give,
                finished_callback=self._running.clear,
            )
        except (library.PortAudioError, ValueError) as error:
            raise DeviceError(f"{self.name}: cannot be opened: {error}.") from error
        self._error: type[Exception] = library.PortAudioError
        self._stop: type[Exception] = library.CallbackStop

    @property
    def playing(self) -> bool:
        """Whether something is heard, or about to be."""
        return self._running.is_set() or time.monotonic() < self._ends_s

    @property
    def broken(self) -> bool:
        """Whether PortAudio ended the stream before it had everything."""
        return self.playing and not self._running.is_set() and self._place < len(self._sound)

    @property
    def silent_for_s(self) -> float:
        """How long it has not asked for sound while it plays (wall time)."""
        return time.monotonic() - self.asked_s if self._running.is_set() else 0.0

    def play(self, samples: Samples) -> None:
        """Play mono sound at ``RATE_HZ``; nothing else may be playing.

        Raises:
            DeviceError: the loudspeaker takes no sound.
        """
        self._sound, self._place, self.asked_s = samples, 0, time.monotonic()
        try:
            self._stream.stop()  # it ended by itself, or never began
            self._running.set()
            self._stream.start()
        except self._error as error:
            self._running.clear()
            raise DeviceError(f"{self.name}: takes no sound: {error}.") from error
        self._ends_s = time.monotonic() + len(samples) / RATE_HZ

    def hush(self) -> None:
        """Be quiet at once."""
        self._ends_s = 0.0
        self._stream.abort(ignore_errors=True)
        self._running.clear()

    def close(self) -> None:
        """Let go of it at once."""
        self.hush()
        self._stream.close(ignore_errors=True)

    def _give(self, out: Any, frames: int, timing: object, status: object) -> None:
        """PortAudio's callback, in its own thread."""
        del timing, status
        self.asked_s = time.monotonic()
        piece = self._sound[self._place : self._place + frames]
        self._place += len(piece)
        block = np.zeros((frames, _CHANNELS), dtype=np.int16)
        block[: len(piece)] = piece[:, np.newaxis]
        out[:] = block.tobytes()
        if self._place >= len(self._sound):
            raise self._stop


def prepared(sound: Sound, volume: float) -> Samples:
    """Sound as ``Loudspeaker.play`` takes it: without the silence around it, and as loud as the
    volume says.

    Args:
        sound: of any level.
        volume: 0 to 1; the loudest moment gets this share of full scale.
    """
    from scipy.signal import resample_poly  # noqa: PLC0415 - slow to import

    divisor = math.gcd(sound.rate_hz, RATE_HZ)
    floats: Any = resample_poly(
        sound.samples.astype(np.float64), RATE_HZ // divisor, sound.rate_hz // divisor
    )
    loudest = float(np.abs(floats).max(initial=0.0)) or 1.0
    scaled: Samples = (floats / loudest * volume * 32_767.0).astype(np.int16)
    audible = np.flatnonzero(np.abs(floats) > _SILENCE * loudest)
    first, last = (int(audible[0]), int(audible[-1])) if len(audible) else (0, 0)
    return scaled[max(0, first - _BEFORE) : last + _AFTER]


def envelope(samples: Samples) -> tuple[float, ...]:
    """Root mean square of each ``ENVELOPE_STEP_S`` of sound at ``RATE_HZ``."""
    step = round(ENVELOPE_STEP_S * RATE_HZ)
    padded = np.zeros(-(-len(samples) // step) * step)
    padded[: len(samples)] = samples
    levels = np.sqrt(np.square(padded.reshape(-1, step)).mean(axis=1))
    return tuple(round(float(level), 1) for level in levels)


def _find(library: Any, wanted: str) -> tuple[int, str, str, bool]:
    """The loudspeaker that is meant: PortAudio's number, its name for people, the sound server's
    name where it was chosen by that, and whether it is behind the sound server."""
    os.environ.pop("PULSE_SINK", None)
    outputs = devices(library, "output")
    if not outputs:
        raise DeviceError("There is no loudspeaker.", "Plug one in.")
    servers = [n for n, name in outputs.items() if name in SERVER_DEVICES]
    if not wanted:
        default = int(library.default.device[1])
        # The server shares its loudspeakers; ALSA's own default may not.
        number = servers[0] if servers and server.sinks() else default
        number = number if number in outputs else next(iter(outputs))
        return number, outputs[number], "", number in servers
    for number, name in outputs.items():
        if wanted.lower() in name.lower():
            return number, name, "", number in servers
    for sink in server.sinks() if servers else []:
        if wanted.lower() in f"{sink.name}\n{sink.description}".lower():
            # The sound server's library reads this when the stream is opened.
            os.environ["PULSE_SINK"] = sink.name
            return servers[0], sink.description, sink.name, True
    raise DeviceError(
        f"There is no loudspeaker {wanted!r}.", "`cellctl voice devices` lists what is there."
    )
