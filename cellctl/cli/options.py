"""Options that several commands share."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from cellctl.assembly import Role
from cellctl.client import CellClient
from cellctl.config import CellConfig, find_config, load_config

KEY_VARIABLE = "CELLCTL_KEY"


class Firmware(StrEnum):
    """What runs on the emulated cell's boards."""

    PLAIN = "plain"
    ELF = "elf"


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
FirmwareOption = Annotated[
    Firmware | None,
    typer.Option(
        help="The boards: plain emulators, or the compiled programs in an AVR simulator (elf); "
        "else emulation.firmware."
    ),
]
FirmwareFolderOption = Annotated[
    Path | None,
    typer.Option(
        help="Where gripper.elf and conveyor.elf are; else where `make firmware` puts them."
    ),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON for other programs.")]


def configuration(path: Path | None) -> CellConfig:
    """The configuration that the option, the environment or /etc names."""
    return load_config(find_config(path))


def with_boards(
    config: CellConfig, firmware: Firmware | None, folder: Path | None, speed: float | None
) -> CellConfig:
    """An emulated cell with other boards or another speed; a real one is left alone.

    Raises:
        UsageError: compiled boards are asked for that are not there, or cannot run as fast.
    """
    from cellctl.sim.boards import check_boards  # noqa: PLC0415 - few commands need it

    if config.emulation is None:
        return config
    emulation = config.emulation.model_copy(
        update=({"firmware": firmware.value} if firmware is not None else {})
        | ({"firmware_folder": str(folder.resolve())} if folder is not None else {})
    )
    cell = config.cell.model_copy(update={"clock_rate": speed} if speed is not None else {})
    changed = config.model_copy(update={"emulation": emulation, "cell": cell})
    check_boards(changed)
    return changed


def client(path: Path | None, role: Role = Role.OPERATOR, key: Path | None = None) -> CellClient:
    """A client for the daemon of that cell, at that role's door."""
    return CellClient.for_role(configuration(path), role, key=named_key(key))


def named_key(explicit: Path | None) -> Path | None:
    """The key file that the option or the environment names; None where neither does."""
    if explicit is None and (named := os.environ.get(KEY_VARIABLE)):
        return Path(named)
    return explicit
