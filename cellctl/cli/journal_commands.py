"""``cellctl journal``: is it sound, and the way out when it is not."""

from __future__ import annotations

import asyncio
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from cellctl import logs
from cellctl.cli.options import ConfigOption, configuration
from cellctl.config import CellConfig
from cellctl.errors import CellFault, UsageError
from cellctl.feeding.inventory import Counts, Place

YesOption = Annotated[bool, typer.Option("--yes", help="Do not ask.")]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    group = typer.Typer(help="Look after the journal's file.", no_args_is_help=True)
    app.add_typer(group, name="journal")

    @group.command()
    def check(config: ConfigOption = None) -> None:
        """Look at every page, act and job; works beside a running daemon."""
        from cellctl.control.journal_reader import JournalReader  # noqa: PLC0415 - heavy

        path = _path(configuration(config))
        with JournalReader(path) as journal:
            found = journal.check()
        typer.echo(
            f"{path}: sound. {found.jobs} jobs, {found.acts} acts, "
            f"{described(found.ledger.counts)}."
        )

    @group.command()
    def new(
        config: ConfigOption = None,
        forget: Annotated[
            bool, typer.Option("--forget", help="Save nothing: begin as a new cell does.")
        ] = False,
        yes: YesOption = False,
    ) -> None:
        """Set a damaged journal aside and save what can be read of it into a new one."""
        from cellctl.control import journal_rescue  # noqa: PLC0415 - heavy

        settings = configuration(config)
        path = _path(settings)
        if not forget:
            _refuse_sound(path)
        if not yes:
            typer.confirm(
                f"Set {path} aside and begin {'with nothing' if forget else 'anew'}?", abort=True
            )
        first, now = _first_counts(settings), datetime.now(UTC)
        if forget:
            aside = journal_rescue.start_anew(path, first, now)
            typer.echo(f"The old journal is now {aside}. The new one believes: {described(first)}.")
            return
        done = journal_rescue.renew(path, first, now)
        typer.echo(f"The damaged journal is now {done.aside}.")
        typer.echo(f"Saved: {done.jobs} jobs, {done.acts} acts, {described(done.ledger.counts)}.")
        for line in done.lost:
            typer.echo(f"Lost: {line}.")
        if not done.complete:
            typer.echo(
                "Where the parts are could not be saved. Take out what stands in the workspace and "
                "in the gripper, count, and tell it with `cellctl inventory set`."
            )

    @group.command()
    def prune(config: ConfigOption = None) -> None:
        """Let go of what is older than [journal] says; a running daemon does so by itself."""
        logs.configure("warning")
        typer.echo(f"{asyncio.run(_prune(configuration(config)))} jobs and acts were removed.")


async def _prune(settings: CellConfig) -> int:
    from cellctl.clock import SystemClock  # noqa: PLC0415 - heavy
    from cellctl.control.journal_store import SqliteJournal  # noqa: PLC0415 - heavy

    path = _path(settings)
    if not path.exists():
        raise UsageError(f"{path}: there is no journal yet.", "The daemon makes it when it starts.")
    clock = SystemClock()
    journal = await SqliteJournal.open(path, clock, _first_counts(settings))
    try:
        return await journal.prune(settings.journal.keep_days, settings.journal.keep_jobs)
    finally:
        await journal.close()


def _refuse_sound(path: Path) -> None:
    from cellctl.control.journal_reader import JournalReader  # noqa: PLC0415 - heavy

    try:
        with JournalReader(path) as journal:
            journal.check()
    except CellFault as fault:
        if fault.code != "journal_damaged":
            raise
    except UsageError:
        return  # the file is gone; what is left of it decides
    else:
        raise UsageError(
            f"{path}: is sound; there is nothing to save.",
            "To begin as a new cell does, with what is known set aside: "
            "`cellctl journal new --forget`.",
        )


def _path(settings: CellConfig) -> Path:
    return Path(settings.journal.path)


def _first_counts(settings: CellConfig) -> Counts:
    return Counts.at_first(settings.limits.inventory_parts, settings.feeder.capacity_parts)


def described(counts: Counts) -> str:
    """Counts in words: those that are not 0."""
    held = [
        f"{number} {place.value.replace('_', ' ')}"
        for place in Place
        if (number := getattr(counts, place))
    ]
    return f"{counts.total} parts ({', '.join(held)})" if held else "no parts"
