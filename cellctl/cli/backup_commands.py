"""``cellctl backup`` and ``cellctl restore``: one file from which a cell can be set up again."""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from cellctl.cli.options import ConfigOption
from cellctl.config import DEFAULT_PATH, find_config
from cellctl.control.backup import restore_backup, write_backup


def register(app: typer.Typer) -> None:
    """Add the commands."""

    @app.command()
    def backup(
        file: Annotated[Path, typer.Argument(help="The archive to write (tar.gz).")],
        config: ConfigOption = None,
    ) -> None:
        """Write configuration, journal and keys to one archive; the daemon may run meanwhile.

        The archive holds the operator's keys: it is readable for its owner only. Keep it so.
        """
        manifest = write_backup(find_config(config), file, datetime.now(UTC))
        names = ", ".join(entry.name for entry in manifest.files)
        typer.echo(f"{file}: {manifest.cell}, cellctl {manifest.version}: {names}.")

    @app.command()
    def restore(
        file: Annotated[Path, typer.Argument(help="An archive that `cellctl backup` wrote.")],
        config: ConfigOption = None,
    ) -> None:
        """Check an archive and put its files in place; refused while a daemon runs.

        What stood there is kept beside it, with .before-restore at the end of its name.
        """
        target = config if config is not None else DEFAULT_PATH
        manifest, kept = restore_backup(file, target)
        for path in kept:
            typer.echo(f"kept {path}")
        typer.echo(
            f"{manifest.cell} is as it was at {manifest.made_at:%Y-%m-%d %H:%M} UTC "
            f"(cellctl {manifest.version}). Look at the cell before you start its daemon: what "
            "happened since is not known to it."
        )
