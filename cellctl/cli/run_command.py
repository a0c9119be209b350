"""``cellctl run``: the daemon in the foreground."""

from __future__ import annotations

import asyncio
from typing import Annotated, Literal

import typer

from cellctl import logs
from cellctl.cli.options import ConfigOption, configuration


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def run(
        config: ConfigOption = None,
        log_level: Annotated[
            Literal["debug", "info", "warning", "error"], typer.Option(help="How much to log.")
        ] = "info",
    ) -> None:
        """Run the cell's daemon until it is told to end (SIGTERM or Ctrl-C)."""
        from cellctl.control.daemon import Daemon  # noqa: PLC0415 - only this command needs it

        logs.configure(log_level)
        asyncio.run(_run(Daemon, configuration(config)))


async def _run(daemon: type, settings: object) -> None:
    await daemon(settings).run()
