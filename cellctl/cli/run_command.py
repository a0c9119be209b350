"""``cellctl run``: the daemon in the foreground."""

from __future__ import annotations

import asyncio
from typing import Annotated, Literal

import typer

from cellctl import logs
from cellctl.cli.options import ConfigOption, configuration
from cellctl.config import CellConfig


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
        logs.configure(log_level)
        asyncio.run(_run(configuration(config), log_level))


async def _run(config: CellConfig, log_level: str) -> None:
    from cellctl.control.daemon import Daemon  # noqa: PLC0415 - only this command needs it

    daemon = Daemon(config)
    logs.configure(log_level, forward=daemon.publish_log)
    await daemon.run()
