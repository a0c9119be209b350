"""``cellctl demo``: a spoken wish, built by the emulated cell."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from cellctl.cli.job_commands import read_file
from cellctl.cli.options import (
    ConfigOption,
    FirmwareFolderOption,
    FirmwareOption,
    with_boards,
)
from cellctl.config import ENVIRONMENT_VARIABLE, CellConfig, load_config
from cellctl.errors import ConfigError, UsageError

DEFAULT_WISH = "I want a simple stool"
EMULATED_CONFIG = Path(__file__).parents[2] / "config" / "sim.toml"


def demo_config(explicit: Path | None) -> Path:
    """The configuration of the emulated cell to demonstrate on.

    Raises:
        ConfigError: neither the option nor the environment names one, and the project's own is
            not beside the program.
    """
    if explicit is not None:
        return explicit
    if from_environment := os.environ.get(ENVIRONMENT_VARIABLE):
        return Path(from_environment)
    if EMULATED_CONFIG.exists():
        return EMULATED_CONFIG
    raise ConfigError(
        f"{EMULATED_CONFIG}: the emulated cell's configuration is not there.",
        "Name one with --config.",
    )


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def demo(
        say: Annotated[
            str | None, typer.Option(help=f'What to wish for; "{DEFAULT_WISH}" by default.')
        ] = None,
        wav: Annotated[Path | None, typer.Option(help="A recorded wish instead.")] = None,
        config: ConfigOption = None,
        speed: Annotated[
            float | None,
            typer.Option(min=0.1, max=100.0, help="Cell seconds per second of your time."),
        ] = None,
        firmware: FirmwareOption = None,
        firmware_folder: FirmwareFolderOption = None,
        picture: Annotated[
            Path | None, typer.Option(help="Draw what stands at the end into this PNG file.")
        ] = None,
        report: Annotated[
            Path | None, typer.Option(help="Write what happened into this JSON file.")
        ] = None,
        page: Annotated[
            bool, typer.Option("--page", help="Serve a page to watch it on, and begin when told.")
        ] = False,
    ) -> None:
        """Speak a wish to the emulated cell and watch it build."""
        from cellctl.cli import demo as show  # noqa: PLC0415 - heavy, and only this command's

        if say is not None and wav is not None:
            raise UsageError("Give either --say TEXT or --wav FILE.")
        if wav is not None:
            read_file(wav)
        console = Console(highlight=False)
        settings = with_boards(
            _waived(load_config(demo_config(config))), firmware, firmware_folder, speed
        )
        console.print(
            f"[bold]{settings.cell.name}[/]: a {settings.robot.model} at "
            f"{settings.cell.clock_rate:g} times real speed. "
            "The question before building is waived: this cell is emulated."
        )
        wish = show.Wish(text=say or DEFAULT_WISH, wav=wav)
        status, facts, truth = show.demonstrate(settings, wish, console, page=page)
        if report is not None:
            show.write_report(facts, report)
        if picture is not None:
            show.draw(facts, truth, settings, picture)
        show.summarise(console, facts, picture, report)
        raise typer.Exit(int(status))


def _waived(config: CellConfig) -> CellConfig:
    policy = config.policy.model_copy(update={"confirmation": "waived"})
    return config.model_copy(update={"policy": policy})
