"""``cellctl models``: what this cell hears with, and fetching the pinned model."""

from __future__ import annotations

from pathlib import Path

import typer

from cellctl.cli.options import ConfigOption, configuration
from cellctl.errors import UsageError
from cellctl.listening.download import VOSK_SMALL_ENGLISH, fetch
from cellctl.listening.models import find_model
from cellctl.listening.vosk_recogniser import missing_files


def register(app: typer.Typer) -> None:
    """Add the commands."""
    group = typer.Typer(help="Models for the recognition of speech.", no_args_is_help=True)
    app.add_typer(group, name="models")

    @group.command()
    def show(config: ConfigOption = None) -> None:
        """Say which model this cell would hear with now, without fetching anything."""
        hearing = configuration(config).hearing.model_copy(update={"allow_download": False})
        found = find_model(hearing)
        typer.echo(f"{found.name} in {found.folder}")

    @group.command("fetch")
    def fetch_model(config: ConfigOption = None) -> None:
        """Fetch the pinned English model into the cell's model folder, if it is not there.

        This reaches the network, which the daemon does not do unless it is told to. Size and sha256
        of what comes are checked before anything is unpacked.
        """
        parent = Path(configuration(config).hearing.model_folder)
        folder = parent / VOSK_SMALL_ENGLISH.folder
        if folder.is_dir():
            if lacking := missing_files(folder):
                raise UsageError(
                    f"{folder}: is incomplete, {', '.join(lacking)} missing.",
                    "Remove the folder, then fetch again.",
                )
            typer.echo(f"{folder}: is there already.")
            return
        typer.echo(f"fetching {VOSK_SMALL_ENGLISH.url} ({VOSK_SMALL_ENGLISH.size_bytes} bytes)")
        typer.echo(f"{fetch(VOSK_SMALL_ENGLISH, parent)}: fetched and checked.")
