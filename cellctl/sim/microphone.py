"""A microphone where there is none: a private PulseAudio that programs record from and we speak to.

The server has a virtual microphone (``SOURCE``) and a virtual loudspeaker, no sound card and no
D-Bus, and a folder of its own for everything that it writes. Programs that are started with
``environment`` open both through ALSA and PortAudio as they open any other. A faint noise is always
in the microphone, as in any real one, until ``silence``.

Needs Debian's ``pulseaudio``, ``pulseaudio-utils`` and ``libasound2-plugins``.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, Self

from cellctl.errors import CellctlError, UsageError
from cellctl.sim.loudspeaker import VirtualLoudspeaker

SOURCE = "vmic"
"""Name of the virtual microphone in the sound server."""
OTHER_SOURCE = "spk.monitor"
"""What a stream silently moves to when the microphone is unplugged: the loudspeaker's monitor."""
_INPUT = "vmic_sink"
_SCRIPT = f"""
load-module module-native-protocol-unix socket={{socket}} auth-anonymous=1
load-module module-null-sink sink_name={_INPUT} rate=16000 channels=1
"""
_START_TIMEOUT_S = 15.0
_ORDER_TIMEOUT_S = 10.0
_END_TIMEOUT_S = 5.0
_POLL_S = 0.05
_LATENCY_MS = 30
"""Of the noise, and so of everything: the server works in pieces of the shortest one asked for."""
_NOISE_VOLUME = 7000
"""Of 65536 on PulseAudio's cubic scale: full-scale noise becomes about -63 dBFS."""


class MicrophoneFailedError(CellctlError):
    """The virtual microphone did not do what it was told."""


class VirtualMicrophone:
    """One private sound server with one microphone; use it in a ``with`` block.

    Args:
        folder: exists, empty, private (mode 700), and short enough for a socket's path.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._server: subprocess.Popen[bytes] | None = None
        self._noise: subprocess.Popen[bytes] | None = None
        self._speaking: list[subprocess.Popen[bytes]] = []
        self._module = ""
        self.loudspeaker = VirtualLoudspeaker(self.order, self.run, end)
        """What the cell's voice comes out of."""

    @property
    def environment(self) -> Mapping[str, str]:
        """The variables that make a program, such as the daemon, use this sound server."""
        folder = str(self._folder)
        return {
            "PULSE_SERVER": f"unix:{folder}/native",
            "PULSE_RUNTIME_PATH": folder,
            "XDG_RUNTIME_DIR": folder,
            "HOME": folder,
        }

    def start(self) -> None:
        """Start the server and plug the microphone in.

        Raises:
            UsageError: the sound server's programs are not installed.
            MicrophoneFailedError: it does not start.
        """
        for program in ("pulseaudio", "pactl", "pacat"):
            if shutil.which(program) is None:
                raise UsageError(
                    f"{program} is not installed.",
                    "Debian: apt install pulseaudio pulseaudio-utils libasound2-plugins",
                )
        script = self._folder / "start.pa"
        script.write_text(_SCRIPT.format(socket=self._folder / "native"), encoding="ascii")
        with (self._folder / "pulseaudio.log").open("wb") as log:
            self._server = self.run(
                *("pulseaudio", "-n", "-F", str(script), "--daemonize=no"),
                *("--exit-idle-time=-1", "--use-pid-file=no", "--disable-shm=yes"),
                log=log,
            )
        deadline_s = time.monotonic() + _START_TIMEOUT_S
        while not self._answers():
            if self._server.poll() is not None or time.monotonic() > deadline_s:
                log_text = (self._folder / "pulseaudio.log").read_text(errors="replace")
                raise MicrophoneFailedError(f"PulseAudio does not start.\n{log_text}")
            time.sleep(_POLL_S)
        self.loudspeaker.replug()
        self.replug()
        self.silence(False)

    def stop(self) -> None:
        """End the server and everything that plays on it; safe to repeat."""
        self.loudspeaker.end()
        processes = [*self._speaking, self._noise, self._server]
        self._speaking, self._noise, self._server = [], None, None
        for process in processes:
            if process is not None:
                end(process)

    def __enter__(self) -> Self:
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()

    def begin(self, wav: Path) -> float:
        """Begin to play a wav file into the microphone and return at once.

        Returns:
            The monotonic time at which it began; the sound itself begins some 50 ms later.
        """
        self._speaking = [process for process in self._speaking if process.poll() is None]
        began_s = time.monotonic()
        self._speaking.append(
            self.run(
                "pacat", "--file-format=wav", "--latency-msec=500", f"--device={_INPUT}", str(wav)
            )
        )
        return began_s

    def speak(self, wav: Path, timeout_s: float = 60.0) -> float:
        """Play a wav file into the microphone, to its end; returns as ``begin`` does.

        Raises:
            MicrophoneFailedError: it was not played within ``timeout_s``.
        """
        began_s = self.begin(wav)
        process = self._speaking[-1]
        try:
            status = process.wait(timeout_s)
        except subprocess.TimeoutExpired as error:
            raise MicrophoneFailedError(f"{wav} was not played in {timeout_s:g} s.") from error
        if status:
            raise MicrophoneFailedError(f"pacat ended with status {status} on {wav}.")
        return began_s

    def unplug(self) -> None:
        """Take the microphone out; what records from it is moved to another source, unasked."""
        self.order("unload-module", self._module)

    def replug(self) -> None:
        """Put the microphone in, as the default one."""
        self._module = self.order(
            *("load-module", "module-remap-source", f"master={_INPUT}.monitor"),
            *(f"source_name={SOURCE}", "source_properties=device.description=VirtualMicrophone"),
        )
        self.order("set-default-source", SOURCE)

    def suspend(self, suspended: bool) -> None:
        """Suspend the microphone, or wake it: what records from it hears nothing, and no error."""
        self.order("suspend-source", SOURCE, str(int(suspended)))

    def mute(self, muted: bool) -> None:
        """Mute the microphone in the sound settings, or end that."""
        self.order("set-source-mute", SOURCE, str(int(muted)))

    def silence(self, silent: bool) -> None:
        """Let the microphone deliver nothing but zeros, as behind a switch; or end that."""
        noise, self._noise = self._noise, None
        if noise is not None:
            end(noise)
        if not silent:
            with Path("/dev/urandom").open("rb") as noise_source:
                self._noise = self.run(
                    *("pacat", "--raw", "--format=u8", "--rate=16000", "--channels=1"),
                    f"--latency-msec={_LATENCY_MS}",
                    *(f"--volume={_NOISE_VOLUME}", f"--device={_INPUT}"),
                    stdin=noise_source,
                )

    def _answers(self) -> bool:
        command = ["pactl", "info"]
        return (
            subprocess.run(  # noqa: S603 - fixed programs with arguments of our own
                command, env=self._variables(), capture_output=True, timeout=_ORDER_TIMEOUT_S,
                check=False,
            ).returncode == 0
        )  # fmt: skip

    def order(self, *arguments: str) -> str:
        """Tell the server something by ``pactl``; returns its answer.

        Raises:
            MicrophoneFailedError: it refuses.
        """
        done = subprocess.run(  # noqa: S603 - fixed programs with arguments of our own
            ["pactl", *arguments],  # noqa: S607 - found by PATH, as the person's own
            env=self._variables(),
            capture_output=True,
            text=True,
            timeout=_ORDER_TIMEOUT_S,
            check=False,
        )
        if done.returncode:
            raise MicrophoneFailedError(f"pactl {' '.join(arguments)}: {done.stderr.strip()}")
        return done.stdout.strip()

    def run(
        self, *command: str, stdin: IO[bytes] | None = None, log: IO[bytes] | None = None
    ) -> subprocess.Popen[bytes]:
        """Start a program that belongs to this server."""
        return subprocess.Popen(  # noqa: S603 - fixed programs with arguments of our own
            command,
            env=self._variables(),
            stdin=stdin if stdin is not None else subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=log if log is not None else subprocess.DEVNULL,
        )

    def _variables(self) -> dict[str, str]:
        return {**os.environ, **self.environment}


def end(process: subprocess.Popen[bytes]) -> None:
    """End a program and wait for it."""
    process.terminate()
    try:
        process.wait(_END_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
