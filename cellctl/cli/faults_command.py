"""``cellctl faults``: the catalogue of faults, the same as on the bus and in the docs."""

from __future__ import annotations

import difflib
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table
from rich.text import Text

from cellctl.cli.options import JsonOption
from cellctl.errors import CATALOGUE, FaultEntry, UsageError


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def faults(
        code: Annotated[str | None, typer.Argument(help="Show this one in full.")] = None,
        json: JsonOption = False,
    ) -> None:
        """Say what can go wrong, and the way out of it."""
        entries = list(CATALOGUE.values()) if code is None else [_entry(code)]
        if json:
            for entry in entries:
                typer.echo(entry.model_dump_json())
            return
        console = Console(highlight=False)
        if code is None:
            table = Table.grid(padding=(0, 2))
            for entry in entries:
                table.add_row(f"[bold]{entry.code}[/]", Text(entry.title))
            console.print(table)
        else:
            console.print(_in_full(entries[0]))


def _entry(code: str) -> FaultEntry:
    if code in CATALOGUE:
        return CATALOGUE[code]
    near = difflib.get_close_matches(code, CATALOGUE, n=1)
    hint = f"Did you mean {near[0]}?" if near else "`cellctl faults` lists them all."
    raise UsageError(f"There is no fault {code!r}.", hint)


def _in_full(entry: FaultEntry) -> Table:
    table = Table.grid(padding=(0, 2))
    rows = (
        ("what happened", entry.title),
        ("likely causes", "\n".join(entry.causes)),
        ("what to do", entry.remedy),
        ("who may clear it", entry.cleared_by.value),
        ("policy", entry.policy.value),
        ("leads to", f"{entry.leads_to.replace('_', ': ')}; after a reset to paused"),
    )
    for name, text in rows:
        table.add_row(f"[bold]{name}[/]", Text(text))
    return table
