"""``cellctl config``: is this file right?"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cellctl.config import load_config
from cellctl.keys import require_server_key
from cellctl.wording import load_wording


def register(app: typer.Typer) -> None:
    """Add the commands."""
    group = typer.Typer(help="Look at configuration files.", no_args_is_help=True)
    app.add_typer(group, name="config")

    @group.command()
    def check(file: Annotated[Path, typer.Argument(help="A cell.toml.")]) -> None:
        """Say whether a configuration is right, and what is wrong with it if not."""
        config = load_config(file)
        require_server_key(config.bus.endpoints, Path(config.bus.keys))
        load_wording(config.dialogue.language, config.dialogue.messages_folder)
        nx, ny, nz = config.grid
        typer.echo(
            f"{file}: right. {config.cell.name} ({config.cell.kind}), {config.robot.model}, "
            f"{nx} x {ny} x {nz} cells of {config.voxel.pitch_m * 100:g} cm, "
            f"{config.limits.inventory_parts} parts."
        )
