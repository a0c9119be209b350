"""The doctor's look at microphone and loudspeaker."""

from __future__ import annotations

import json
import subprocess
import sys
from typing import Literal

from cellctl.cli.findings import Finding, ok, problem, warning
from cellctl.config import CellConfig
from cellctl.errors import HearingError
from cellctl.messages import Snapshot
from cellctl.speaking.voices import open_voice

_LIST_DEVICES = (
    "import json, sys; from cellctl.sound.portaudio import listed; "
    "from cellctl.sound.server import sinks, sources; "
    "served = sources() if sys.argv[1] == 'input' else sinks(); "
    "print(json.dumps([*listed(sys.argv[1]), *(f'{s.description} ({s.name})' for s in served)]))"
)
_TIMEOUT_S = 15.0


def microphone(config: CellConfig, daemon: Snapshot | None) -> list[Finding]:
    """Whether the microphone is there. A daemon that listens is asked, and left in peace."""
    wanted = config.hearing.microphone
    if wanted == "none":
        return [ok("microphone", "none is configured (hearing.microphone)")]
    if daemon is None:
        return [_listed("microphone", wanted, "input", "hearing.microphone")]
    ears = daemon.ears
    if ears.state in {"lost", "silent", "slow", "off"}:
        advice = "Plug it in, or look at its volume and at the sound server."
        return [problem("microphone", f"the daemon says {ears.state}: {ears.sentence}", advice)]
    return [ok("microphone", f"the daemon listens to {ears.device or 'it'} ({ears.state})")]


def loudspeaker(config: CellConfig, daemon: Snapshot | None) -> list[Finding]:
    """Whether there is a loudspeaker, and a voice for the cell's language."""
    wanted = config.voice.loudspeaker
    if wanted == "none":
        return [ok("loudspeaker", "none is configured (voice.loudspeaker)")]
    found = [_voice(config)]
    if daemon is None:
        return [*found, _listed("loudspeaker", wanted, "output", "voice.loudspeaker")]
    voice = daemon.voice
    if voice.state in {"lost", "silent", "off"}:
        advice = "Plug it in, or look at its volume and at the sound server."
        text = f"the daemon says {voice.state}: {voice.sentence}"
        return [*found, warning("loudspeaker", text, advice)]
    return [*found, ok("loudspeaker", f"the daemon speaks on {voice.device or 'it'}")]


def _voice(config: CellConfig) -> Finding:
    try:
        voice = open_voice(config.dialogue.language, config.voice.voice)
        voice.speak("1")
    except HearingError as error:
        return warning("voice", error.message, error.hint)
    return ok("voice", f"{voice.name} speaks {config.dialogue.language}")


def _listed(topic: str, wanted: str, direction: Literal["input", "output"], option: str) -> Finding:
    """Whether the sound system has a device of that name, or any for an empty one."""
    try:
        # A sound library may print, hang or crash, so it is asked in a process of its own.
        done = subprocess.run(  # noqa: S603 - this very interpreter and package
            [sys.executable, "-c", _LIST_DEVICES, direction],
            capture_output=True,
            text=True,
            timeout=_TIMEOUT_S,
            check=False,
        )
    except subprocess.TimeoutExpired:
        text = f"the sound system does not answer within {_TIMEOUT_S:.0f} s"
        return problem(topic, text, "Restart the sound server.")
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or ["no reason given"]
        return problem(topic, f"cannot be looked for: {last[0]}", "Install PortAudio.")
    names = json.loads(done.stdout.splitlines()[-1])
    listed = f"there are: {', '.join(names)}" if names else f"there is no {direction} device at all"
    if not names or (wanted and not any(wanted.lower() in name.lower() for name in names)):
        text = f"{wanted or 'the default one'!r} is not there; {listed}"
        return problem(topic, text, f"Plug it in, or correct {option}.")
    return ok(topic, f"{wanted or 'the default one'} is there ({listed})")
