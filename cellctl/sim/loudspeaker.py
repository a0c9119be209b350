"""A loudspeaker where there is none: what the cell says can be recorded, and echoes if wanted.

It is a sink of the private sound server that ``VirtualMicrophone`` starts. What a room does, the
server's own modules do: a loopback carries what the loudspeaker plays into the microphone, so much
later and so much fainter.
"""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Protocol

SINK = "spk"
"""Name of the virtual loudspeaker in the sound server."""
RATE_HZ = 48_000
ECHO_DELAY_MS = 40
"""From the loudspeaker to the microphone: some metres of room, and the sound card's own."""
_START_TIMEOUT_S = 10.0
_POLL_S = 0.02


class _Run(Protocol):
    def __call__(self, *command: str) -> subprocess.Popen[bytes]: ...


class VirtualLoudspeaker:
    """The loudspeaker of one private sound server.

    Args:
        order: tells the server something by ``pactl``; returns its answer.
        run: starts a program that belongs to the server.
        end: ends it.
    """

    def __init__(
        self,
        order: Callable[..., str],
        run: _Run,
        end: Callable[[subprocess.Popen[bytes]], None],
    ) -> None:
        self._order = order
        self._run = run
        self._end = end
        self._module = ""
        self._echo = ""
        self._recorder: subprocess.Popen[bytes] | None = None

    def replug(self) -> None:
        """Put the loudspeaker in, as the default one."""
        self._module = self._order(
            *("load-module", "module-null-sink", f"sink_name={SINK}"),
            *(f"rate={RATE_HZ}", "channels=1"),
            "sink_properties=device.description=VirtualLoudspeaker",
        )
        self._order("set-default-sink", SINK)

    def unplug(self) -> None:
        """Take the loudspeaker out; what plays on it is moved to another sink, unasked."""
        self._order("unload-module", self._module)

    def suspend(self, suspended: bool) -> None:
        """Suspend the loudspeaker, or wake it: it takes no sound, and gives no error."""
        self._order("suspend-sink", SINK, str(int(suspended)))

    def mute(self, muted: bool) -> None:
        """Mute the loudspeaker in the sound settings, or end that."""
        self._order("set-sink-mute", SINK, str(int(muted)))

    def echo(self, level_db: float | None) -> None:
        """Let the microphone hear the loudspeaker, ``level_db`` fainter than it plays (negative);
        None ends that."""
        module, self._echo = self._echo, ""
        if module:
            self._order("unload-module", module)
        if level_db is None:
            return
        self._echo = self._order(
            *("load-module", "module-loopback", f"source={SINK}.monitor", "sink=vmic_sink"),
            *(f"latency_msec={ECHO_DELAY_MS}", "source_dont_move=true", "sink_dont_move=true"),
        )
        inputs = json.loads(self._order("--format=json", "list", "sink-inputs"))
        echo = next(each for each in inputs if str(each["owner_module"]) == self._echo)
        self._order("set-sink-input-volume", str(echo["index"]), f"{level_db:.1f}dB")

    def record(self, path: Path) -> None:
        """Record what it plays, as raw mono 16 bit samples at ``RATE_HZ``, until ``end``; returns
        when the recording has begun.

        Raises:
            TimeoutError: it does not begin.
        """
        self.end()
        path.unlink(missing_ok=True)
        self._recorder = self._run(
            *("pacat", "--record", "--raw", "--format=s16le", f"--rate={RATE_HZ}"),
            *("--channels=1", "--latency-msec=20", f"--device={SINK}.monitor", str(path)),
        )
        deadline_s = time.monotonic() + _START_TIMEOUT_S
        while not (path.is_file() and path.stat().st_size):
            if time.monotonic() > deadline_s:
                raise TimeoutError(f"{path}: nothing is recorded.")
            time.sleep(_POLL_S)

    def end(self) -> None:
        """End the recording; safe to repeat."""
        recorder, self._recorder = self._recorder, None
        if recorder is not None:
            self._end(recorder)
