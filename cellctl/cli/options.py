"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from cellctl.assembly import Role
from cellctl.client import CellClient
from cellctl.config import CellConfig, find_config, load_config

ConfigOption = Annotated[
    Path | None,
    typer.Option(
        "--config",
        help="The cell's configuration; else $CELLCTL_CONFIG, else /etc/cellctl/cell.toml.",
    ),
]
RoleOption = Annotated[Role, typer.Option("--role", help="Whose door of the cell to knock at.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for other programs.")]


def configuration(path: Path | None) -> CellConfig:
    """The configuration that the option, the environment or /etc names."""
    return load_config(find_config(path))


def client(path: Path | None, role: Role = Role.OPERATOR) -> CellClient:
    """A client for the daemon of that cell, at that role's door."""
    return CellClient.for_role(configuration(path), role)
