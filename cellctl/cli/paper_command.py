"""``cellctl paper``: the paper's tables beside what this project computes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from cellctl.cli.options import ConfigOption, configuration
from cellctl.errors import UsageError

if TYPE_CHECKING:
    from cellctl.validating.paper.report import Report

_WIDTH = 100
"""The tables are no wider; a terminal that is narrower wraps their text."""


def make_report(config: Path | None, table: str | None) -> Report:
    """All tables, or one, for the cell that a configuration describes.

    Raises:
        UsageError: there is no table of that name.
        ConfigError: there is no configuration, or a wrong one.
    """
    from cellctl.listening.request import read_request  # noqa: PLC0415
    from cellctl.listening.understanding.interpreter import Setting  # noqa: PLC0415
    from cellctl.validating.paper.comparing import TableName, compare  # noqa: PLC0415 - heavy

    if table is not None and table not in set(TableName):
        known = ", ".join(TableName)
        raise UsageError(f"There is no table {table!r}.", f"Known: {known}.")
    settings = configuration(config)
    names = tuple(TableName) if table is None else (TableName(table),)
    setting = Setting.of(settings)
    return compare(settings, lambda text: read_request(text, setting).phrase, names)


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def paper(
        config: ConfigOption = None,
        table: Annotated[
            str | None,
            typer.Option(
                help="Only this one: count, overhang, stack, ablation, order, volume, time, fdm, "
                "speed, requests or claims."
            ),
        ] = None,
        json: Annotated[
            Path | None,
            typer.Option(help="Write the report (JSON) to this file; - prints it instead."),
        ] = None,
    ) -> None:
        """Show the paper's tables beside what this project computes for the same objects."""
        from cellctl.cli.paper_view import show_report  # noqa: PLC0415 - heavy

        report = make_report(config, table)
        text = report.model_dump_json(indent=2)
        if json == Path("-"):
            typer.echo(text)
            return
        if json is not None:
            try:
                json.write_text(text + "\n", encoding="utf-8")
            except OSError as error:
                raise UsageError(f"{json}: cannot be written: {error.strerror}.") from error
        console = Console(highlight=False)
        # What is piped into a file or a pager has no width of its own.
        console.width = min(console.width, _WIDTH) if console.is_terminal else _WIDTH
        show_report(console, report)
