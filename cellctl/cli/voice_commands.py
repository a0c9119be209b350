"""``cellctl voice``: the loudspeakers that there are, and what the cell sounds like."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from cellctl.cli.options import ConfigOption
from cellctl.config import VoiceSection, find_config, load_config
from cellctl.errors import CellctlError, ConfigError
from cellctl.wording import load_wording

_PATIENCE_S = 5.0
"""How long a loudspeaker may take to ask for sound (wall time)."""

TextOption = Annotated[str | None, typer.Option(help="What to say; else what it always asks.")]
DeviceOption = Annotated[
    str | None, typer.Option(help="A part of its name; else voice.loudspeaker.")
]
VolumeOption = Annotated[
    float | None, typer.Option(min=0.01, max=1.0, help="0 to 1; else voice.volume.")
]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    group = typer.Typer(help="Try the cell's voice; no daemon is needed.", no_args_is_help=True)
    app.add_typer(group, name="voice")

    @group.command()
    def devices() -> None:
        """List the loudspeakers of this computer."""
        from cellctl.sound import portaudio, server  # noqa: PLC0415 - only this command

        for name in portaudio.listed("output"):
            typer.echo(f"device  {name}")
        for sink in server.sinks():
            note = " (muted)" if sink.muted else ""
            typer.echo(f"sink    {sink.name}: {sink.description}{note}")

    @group.command()
    def test(
        config: ConfigOption = None,
        text: TextOption = None,
        device: DeviceOption = None,
        volume: VolumeOption = None,
    ) -> None:
        """Say something through the loudspeaker, and tell how loud and how fast that was."""
        voice, language, sentence = _configured(config)
        wanted = voice.loudspeaker if device is None else device
        _speak(
            "" if wanted == "none" else wanted,
            voice.voice,
            volume if volume is not None else voice.volume,
            sentence if text is None else text,
            language,
        )


def _configured(explicit: Path | None) -> tuple[VoiceSection, str, str]:
    """The voice, its language and what it always asks; the defaults where there is no
    configuration yet."""
    try:
        config = load_config(find_config(explicit))
    except ConfigError:
        if explicit is not None:
            raise
        return VoiceSection(), "en", load_wording("en").text("state.idle")
    wording = load_wording(config.dialogue.language, config.dialogue.messages_folder)
    return config.voice, wording.language, wording.text("state.idle")


def _speak(wanted: str, voice: str, volume: float, text: str, language: str) -> None:
    from cellctl.speaking.loudspeaker import (  # noqa: PLC0415 - starts PortAudio
        RATE_HZ,
        Loudspeaker,
    )
    from cellctl.speaking.repertoire import Repertoire  # noqa: PLC0415 - loads scipy

    loudspeaker = Loudspeaker(wanted)
    try:
        repertoire = Repertoire(voice, volume, language)
        repertoire.ready.wait()
        samples = repertoire.sound(text, language)
        deadline_s = time.monotonic() + _PATIENCE_S + len(samples) / RATE_HZ
        loudspeaker.play(samples)
        while loudspeaker.playing:
            if time.monotonic() > deadline_s:
                raise CellctlError(
                    f"{loudspeaker.name} takes no sound.", "Is it plugged in, and not suspended?"
                )
            time.sleep(0.02)
    finally:
        loudspeaker.close()
    typer.echo(
        f"{repertoire.voice} said {text!r} on {loudspeaker.name} in {len(samples) / RATE_HZ:.1f} s."
    )
