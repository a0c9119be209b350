"""``cellctl inventory``: where the parts are, from the daemon or, when none runs, from its file."""

from __future__ import annotations

import json as json_module
from pathlib import Path

import typer

from cellctl.assembly import Role
from cellctl.cli.options import client, configuration
from cellctl.feeding.inventory import Counts


def show_inventory(config: Path | None, key: Path | None, json: bool) -> None:
    """Print the counts.

    Args:
        config: the cell's configuration, if it is named.
        key: as for other commands to a daemon.
        json: print them for programs.

    Raises:
        NoDaemonError: a daemon has the journal and does not answer.
        CellFault: ``journal_damaged``, ``journal_failed``.
    """
    from cellctl.control.journal_lock import JournalLock  # noqa: PLC0415 - heavy
    from cellctl.control.journal_reader import JournalReader  # noqa: PLC0415 - heavy

    path = Path(configuration(config).journal.path)
    if JournalLock(path).holder() is not None or not path.exists():
        with client(config, Role.VISITOR, key) as cell:
            counts = Counts.model_validate(cell.snapshot().inventory)
        source = "by the running daemon"
    else:
        with JournalReader(path) as journal:
            counts = journal.ledger().counts
        source = "by the journal; no daemon runs"
    if json:
        typer.echo(json_module.dumps({**counts.model_dump(), "total": counts.total}, indent=2))
        return
    for place, number in counts.model_dump().items():
        typer.echo(f"{place.replace('_', ' '):<12}{number:>5}")
    typer.echo(f"{'all':<12}{counts.total:>5}   {source}")
