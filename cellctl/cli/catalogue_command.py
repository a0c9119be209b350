"""``cellctl catalogue``: what furniture can be retrieved, by whom, under which licence."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from cellctl.cli.options import ConfigOption, configuration
from cellctl.errors import UsageError


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def catalogue(
        word: Annotated[str, typer.Argument(help="Only those whose name has this in it.")] = "",
        build: Annotated[
            Path | None,
            typer.Option("--build", metavar="FOLDER", help="Make one of a folder of .sh3f files."),
        ] = None,
        output: Annotated[
            Path | None, typer.Option("--output", metavar="FILE.json.gz", help="Where to write it.")
        ] = None,
        config: ConfigOption = None,
    ) -> None:
        """List the catalogue of real furniture with its authors, or make another one."""
        from cellctl.generating.catalogue import load_catalogue, write_catalogue  # noqa: PLC0415

        screen = Console(highlight=False, soft_wrap=True)
        if (build is None) != (output is None):
            raise UsageError("--build and --output go together.", "Name a folder and a file.")
        if build is not None and output is not None:
            from cellctl.cli.catalogue_build import build_catalogue  # noqa: PLC0415 - heavy

            if not output.absolute().parent.is_dir():
                raise UsageError(f"{output}: there is no folder {output.absolute().parent}.")
            aside = Console(stderr=True, highlight=False, soft_wrap=True)
            made = build_catalogue(
                build, lambda line: aside.print(f"left out  {line}", markup=False)
            )
            try:
                write_catalogue(made, output)
            except OSError as error:
                raise UsageError(f"{output}: cannot be written: {error.strerror}.") from error
            screen.print(f"{len(made.entries)} objects in {output}", markup=False)
            return
        found = load_catalogue(configuration(config).generating.catalogue)
        for entry in found.entries:
            if word.lower() in entry.name:
                size = " x ".join(f"{edge * 100:.0f}" for edge in entry.size_m)
                screen.print(
                    f"{entry.name:32} {entry.parts:4} parts  {size:>15} cm  by {entry.creator}, "
                    f"{entry.licence}",
                    markup=False,
                )
        screen.print(f"{found.source}", markup=False)
