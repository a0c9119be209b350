"""What the sound server really records and plays for us, asked of PulseAudio or PipeWire.

PortAudio sees only "pulse" or "default". When the device behind that is unplugged, the server may
move the stream to another one, such as the loudspeaker's monitor, without a word: only the server
knows.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import threading
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from cellctl.assembly import Value

T = TypeVar("T")

_TIMEOUT_S = 2.0
ASK_EVERY_S = 0.7
"""How often the sound server is asked what is recorded or played (wall time)."""


class Source(Value):
    """One microphone, as the sound server knows it."""

    name: str
    """Stable: it names the device and its place."""
    description: str
    """For people."""
    monitor: bool
    """Not a microphone: what a loudspeaker plays."""
    muted: bool


class Sink(Value):
    """One loudspeaker, as the sound server knows it."""

    name: str
    """Stable: it names the device and its place."""
    description: str
    """For people."""
    muted: bool


def recorded_source() -> Source | None:
    """What this process records from; None when it does not, or when nobody can tell.

    Blocks for up to ``2 * _TIMEOUT_S``.
    """
    listed = _used("source-outputs", "source", "sources")
    return _source(listed) if listed is not None else None


def played_sink() -> Sink | None:
    """What this process plays on; None when it does not, or when nobody can tell.

    Blocks for up to ``2 * _TIMEOUT_S``.
    """
    listed = _used("sink-inputs", "sink", "sinks")
    return _sink(listed) if listed is not None else None


def sources() -> list[Source]:
    """Every source that there is; none without a sound server."""
    return [_source(source) for source in _listed("sources")]


def sinks() -> list[Sink]:
    """Every loudspeaker that there is; none without a sound server."""
    return sinks_if_told() or []


def sinks_if_told() -> list[Sink] | None:
    """The same; None where the server takes too long to tell."""
    listed = _asked("sinks")
    return [_sink(sink) for sink in listed] if listed is not None else None


class ServerWatch(Generic[T]):
    """Asks the sound server again and again, in a thread of its own, for it may take its time.

    Args:
        ask: what to ask.
        every_s: how often (wall time).
    """

    def __init__(self, ask: Callable[[], T | None], every_s: float = ASK_EVERY_S) -> None:
        self.answer: T | None = None
        """The newest; None when nobody can tell."""
        self._ask = ask
        self._every_s = every_s
        self._ended = threading.Event()
        threading.Thread(target=self._run, name="sound server watch", daemon=True).start()

    def end(self) -> None:
        """Ask no more; the thread ends after the present question."""
        self._ended.set()

    def _run(self) -> None:
        while not self._ended.is_set():
            self.answer = self._ask()
            self._ended.wait(self._every_s)


def _used(streams: str, device: str, kind: str) -> dict[str, Any] | None:
    """The device behind this process's newest stream."""
    ours = str(os.getpid())
    used = [
        stream
        for stream in _listed(streams)
        if stream.get("properties", {}).get("application.process.id") == ours
    ]
    if not used:
        return None
    index = used[-1].get(device)
    return next((each for each in _listed(kind) if each.get("index") == index), None)


def _source(listed: dict[str, Any]) -> Source:
    name = str(listed["name"])
    return Source(
        name=name,
        description=str(listed.get("description") or name),
        monitor=name.endswith(".monitor"),
        muted=bool(listed.get("mute")),
    )


def _sink(listed: dict[str, Any]) -> Sink:
    name = str(listed["name"])
    description = str(listed.get("description") or name)
    return Sink(name=name, description=description, muted=bool(listed.get("mute")))


def _listed(what: str) -> list[dict[str, Any]]:
    return _asked(what) or []


def _asked(what: str) -> list[dict[str, Any]] | None:
    """What there is of one kind; none where no server answers, None where it takes too long."""
    program = shutil.which("pactl")
    if program is None:
        return []
    try:
        done = subprocess.run(  # noqa: S603 - a fixed program with fixed arguments
            [program, "--format=json", "list", what],
            # Numbers with decimal commas would make it invalid JSON.
            env={**os.environ, "LC_ALL": "C.UTF-8"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_TIMEOUT_S,
            check=True,
        )
        listed: list[dict[str, Any]] = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        return None
    except (subprocess.SubprocessError, OSError, ValueError):
        return []
    return listed
