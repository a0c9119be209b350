"""Which microphone the sound server really records for us, asked of PulseAudio or PipeWire.

PortAudio sees only "pulse" or "default". When the microphone behind that is unplugged, the server
may move the recording to another source, such as the loudspeaker's monitor, without a word: only
the server knows.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from typing import Any

from cellctl.assembly import Value

_TIMEOUT_S = 1.0


class Source(Value):
    """One microphone, as the sound server knows it."""

    name: str
    """Stable: it names the device and its place."""
    description: str
    """For people."""
    monitor: bool
    """Not a microphone: what a loudspeaker plays."""
    muted: bool


def recorded_source() -> Source | None:
    """What this process records from; None when it does not, or when nobody can tell.

    Blocks for up to ``2 * _TIMEOUT_S``.
    """
    ours = str(os.getpid())
    outputs = [
        output
        for output in _listed("source-outputs")
        if output.get("properties", {}).get("application.process.id") == ours
    ]
    if not outputs:
        return None
    for source in _listed("sources"):
        if source.get("index") == outputs[-1].get("source"):
            return _source(source)
    return None


def sources() -> list[Source]:
    """Every source that there is; none without a sound server."""
    return [_source(source) for source in _listed("sources")]


def _source(listed: dict[str, Any]) -> Source:
    name = str(listed["name"])
    return Source(
        name=name,
        description=str(listed.get("description") or name),
        monitor=name.endswith(".monitor"),
        muted=bool(listed.get("mute")),
    )


def _listed(what: str) -> list[dict[str, Any]]:
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
    except (subprocess.SubprocessError, OSError, ValueError):
        return []
    return listed
