"""Options that several commands share."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from cellctl.assembly import Role
from cellctl.client import CellClient
from cellctl.config import CellConfig, find_config, load_config

KEY_VARIABLE = "CELLCTL_KEY"

ConfigOption = Annotated[
    Path | None,
    typer.Option(
        "--config",
        help="The cell's configuration; else $CELLCTL_CONFIG, else /etc/cellctl/cell.toml.",
    ),
]
RoleOption = Annotated[Role, typer.Option("--role", help="Whose door of the cell to knock at.")]
KeyOption = Annotated[
    Path | None,
    typer.Option("--key", help="Your key file, for a cell that is elsewhere; else $CELLCTL_KEY."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for other programs.")]


def configuration(path: Path | None) -> CellConfig:
    """The configuration that the option, the environment or /etc names."""
    return load_config(find_config(path))


def client(path: Path | None, role: Role = Role.OPERATOR, key: Path | None = None) -> CellClient:
    """A client for the daemon of that cell, at that role's door."""
    return CellClient.for_role(configuration(path), role, key=named_key(key))


def named_key(explicit: Path | None) -> Path | None:
    """The key file that the option or the environment names; None where neither does."""
    if explicit is None and (named := os.environ.get(KEY_VARIABLE)):
        return Path(named)
    return explicit
