"""Where the boards' compiled programs and the simulator are, and what each board's chip is."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Final, NamedTuple

from cellctl.boards.constants import BoardRole
from cellctl.errors import UsageError

FIRMWARE: Final = Path(__file__).parents[3] / "firmware"
"""Part of the source tree, and of no installation."""
SIMULATOR: Final = FIRMWARE / "simulator" / "board.py"
BINARIES: Final = FIRMWARE / "build"


class Chip(NamedTuple):
    """What a board's program is made for."""

    name: str
    frequency_hz: int
    serial: str
    """The pins of its serial line: the one it talks on, the one it listens on."""
    watched: tuple[str, ...]
    """Pins whose changes the cell must know; of those with a +, the rises."""
    serial_number: str
    """The chip's own, as the board tells it."""


CHIPS: Final = {
    BoardRole.GRIPPER: Chip(
        "attiny412", 10_000_000, "PA6,PA6", ("PA2", "PA3"), "1E922353494D00000001"
    ),
    BoardRole.CONVEYOR: Chip(
        "attiny1604", 10_000_000, "PB2,PB3", ("PA1+", "PA2", "PA3"), "1E942553494D00000001"
    ),
}


def program(role: BoardRole, folder: Path | None = None) -> Path:
    """A board's compiled program.

    Args:
        folder: where it is; by default where `make firmware` puts it.

    Raises:
        UsageError: it is not there.
    """
    path = (folder or BINARIES) / f"{role}.elf"
    if not path.is_file():
        raise UsageError(
            f"{path}: the {role}'s program is not there.",
            "Run `make firmware` in cellctl's source tree, or name the folder that holds "
            f"{role}.elf with --firmware-folder.",
        )
    return path


def simulator_packages() -> Path:
    """The folder of packages that the simulator's process needs.

    Raises:
        UsageError: the simulator is not there.
    """
    packages = Path(sys.prefix) / "simulator"
    if not SIMULATOR.is_file():
        raise UsageError(
            "The AVR simulator is not part of an installed cellctl.",
            "Run this from cellctl's source tree, or leave --firmware at plain.",
        )
    if not (packages / "built").is_file():
        raise UsageError(
            f"{packages}: the AVR simulator has not been built.",
            "Run `scripts/setup --test` in cellctl's source tree, or leave --firmware at plain.",
        )
    return packages
