"""``cellctl listen``, ``mute``, ``unmute`` and ``microphone``: the cell's live ears."""

from __future__ import annotations

import time
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.live import Live
from rich.text import Text

from cellctl.assembly import Role
from cellctl.cli.options import ConfigOption, RoleOption, client
from cellctl.config import find_config, load_config
from cellctl.errors import CellctlError, ConfigError
from cellctl.messages import ListenCommand, MuteCommand

_QUIETEST_DB = -72.0
_BAR_WIDTH = 48
_REFRESH_S = 0.1
_CLIPPED_DB = -1.0
_FAINT_DB = -40.0
"""Speech that stays below this is too far away, or the microphone's gain too low."""

SecondsOption = Annotated[
    float, typer.Option(min=0.0, max=600.0, help="How long to show the level; 0 only lists.")
]
DeviceOption = Annotated[
    str | None, typer.Option(help="A part of its name; else hearing.microphone.")
]


def register(app: typer.Typer) -> None:
    """Add the commands."""

    @app.command()
    def listen(config: ConfigOption = None, role: RoleOption = Role.VISITOR) -> None:
        """Press the button: what is said into the cell's microphone next is a request."""
        with client(config, role) as cell:
            typer.echo(cell.request(ListenCommand()).message)

    @app.command()
    def mute(config: ConfigOption = None, role: RoleOption = Role.VISITOR) -> None:
        """Close the cell's microphone. It hears nothing then, "stop" included."""
        with client(config, role) as cell:
            typer.echo(cell.request(MuteCommand(command="mute")).message)

    @app.command()
    def unmute(config: ConfigOption = None, role: RoleOption = Role.OPERATOR) -> None:
        """Open the cell's microphone again."""
        with client(config, role) as cell:
            typer.echo(cell.request(MuteCommand(command="unmute")).message)

    @app.command()
    def microphone(
        config: ConfigOption = None, device: DeviceOption = None, seconds: SecondsOption = 5.0
    ) -> None:
        """List the microphones of this computer, and show how loud one hears."""
        from cellctl.sound import portaudio, server  # noqa: PLC0415 - only this command

        for name in portaudio.listed("input"):
            typer.echo(f"device  {name}")
        for source in server.sources():
            if not source.monitor:
                note = " (muted)" if source.muted else ""
                typer.echo(f"source  {source.name}: {source.description}{note}")
        if seconds > 0.0:
            _show_level(_configured(config) if device is None else device, seconds)


def _configured(config: ConfigOption) -> str:
    """The configured microphone; the system's own where there is no configuration yet."""
    try:
        wanted = load_config(find_config(config)).hearing.microphone
    except ConfigError:
        if config is not None:
            raise
        return ""
    return "" if wanted == "none" else wanted


def _show_level(wanted: str, seconds: float) -> None:
    from cellctl.listening.ears.microphone import Microphone  # noqa: PLC0415 - starts PortAudio

    microphone = Microphone(wanted)
    loudest_db = _QUIETEST_DB
    heard = b""
    try:
        with Live(console=Console(highlight=False), refresh_per_second=10) as live:
            deadline_s = time.monotonic() + seconds
            while time.monotonic() < deadline_s:
                shown_s = time.monotonic() + _REFRESH_S
                piece = b""
                while time.monotonic() < shown_s:
                    piece += microphone.read(_REFRESH_S)
                level_db = _level_db(piece)
                loudest_db, heard = max(loudest_db, level_db), heard or piece
                live.update(_bar(microphone.name, level_db))
    finally:
        microphone.close()
    if not heard:
        raise CellctlError(
            f"{microphone.name} delivered no sound.", "Is it plugged in, and not suspended?"
        )
    typer.echo(
        f"{microphone.name}: at most {loudest_db:.0f} dB of full scale. {_advice(loudest_db)}"
    )


def _level_db(sound: bytes) -> float:
    """Mean level in dB of full scale, at least ``_QUIETEST_DB``."""
    samples = np.frombuffer(sound, dtype=np.int16).astype(np.float64) / 32768.0
    power = float(np.square(samples).mean()) if len(samples) else 0.0
    return max(_QUIETEST_DB, 10.0 * float(np.log10(power))) if power > 0.0 else _QUIETEST_DB


def _bar(name: str, level_db: float) -> Text:
    full = round((level_db - _QUIETEST_DB) / -_QUIETEST_DB * _BAR_WIDTH)
    return Text(f"{name} {level_db:6.1f} dB |{'#' * full:<{_BAR_WIDTH}}|")


def _advice(loudest_db: float) -> str:
    if loudest_db <= _QUIETEST_DB:
        return "That is silence: look for a switch at the microphone, or a muted input."
    if loudest_db > _CLIPPED_DB:
        return "That is too loud: turn its gain down."
    if loudest_db < _FAINT_DB:
        return "If somebody spoke, that is faint: move it closer, or turn its gain up."
    return "That is good for speech."
