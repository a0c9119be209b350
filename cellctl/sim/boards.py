"""The cell's boards, of either kind: plain emulators, or their compiled programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, NamedTuple, Protocol

from cellctl.boards.constants import BoardRole, ResetCause
from cellctl.config import CellConfig
from cellctl.errors import UsageError
from cellctl.sim.avr.conveyor import FirmwareConveyor
from cellctl.sim.avr.gripper import FirmwareGripper
from cellctl.sim.avr.programs import program, simulator_packages
from cellctl.sim.conveyor import ConveyorEmulator, ConveyorTruth
from cellctl.sim.gripper_board import GripperBoardEmulator
from cellctl.sim.latch import Latch, LatchFault
from cellctl.sim.wiring import WiredLatch
from cellctl.sim.world import World

FIRMWARE_RATE_MAX: Final = 3.0
"""Highest clock rate with compiled programs: a belt stops when no line came for 0.2 s of its own
time, which cannot be stretched, and the host answers in wall time."""


class GripperLatch(WiredLatch, Protocol):
    """The latch, and what can be wrong with it."""

    def advance(self, dt_s: float) -> None:
        """Let cell time pass."""

    def reboot(self) -> None:
        """Cut the power for a moment."""

    def inject(self, fault: LatchFault) -> None:
        """Break something."""

    def clear(self, fault: LatchFault) -> None:
        """Mend it."""

    def truth(self) -> dict[str, Any]:
        """The latch as it is, for the record."""
        ...


class Board(Protocol):
    """A board on a serial port, of either kind."""

    def start(self) -> None:
        """Make the port and switch the board on."""

    def stop(self) -> None:
        """Take the port away; safe to repeat."""

    def advance(self, dt_s: float) -> None:
        """Let cell time pass."""

    def inject(self, fault: str, **arguments: Any) -> None:
        """Switch on one of its faults."""

    def clear(self, fault: str) -> None:
        """Switch a fault off."""

    def reset(self, cause: ResetCause) -> None:
        """Start anew."""

    def fault_names(self) -> tuple[str, ...]:
        """The names of the faults that are active."""
        ...


class GripperBoard(Board, Protocol):
    """The gripper's."""

    def truth(self) -> dict[str, Any]:
        """What is really so, for judges and tests."""
        ...


class ConveyorBoard(Board, Protocol):
    """The conveyor's."""

    def truth(self) -> ConveyorTruth:
        """What is really so, for judges and tests."""
        ...


class Boards(NamedTuple):
    """The boards of one cell."""

    latch: GripperLatch
    gripper: GripperBoard | None
    """None: nobody talks to it, and it is no more than its latch."""
    conveyor: ConveyorBoard


def check_boards(config: CellConfig) -> None:
    """Make sure that the cell's boards can run as is asked for.

    Raises:
        UsageError: a program or the simulator is not there, or the cell is too fast for them.
    """
    if config.emulation is None or config.emulation.firmware == "plain":
        return
    folder = config.emulation.firmware_folder
    for role in BoardRole:
        program(role, Path(folder) if folder is not None else None)
    simulator_packages()
    rate = config.cell.clock_rate
    if rate > FIRMWARE_RATE_MAX:
        raise UsageError(
            f"Compiled programs cannot run {rate:g} times as fast as real: the belt stops when its "
            "host is silent for 0.2 s of the board's time, and the host needs real time to answer.",
            f"Take a --speed (cell.clock_rate) of at most {FIRMWARE_RATE_MAX:g}, or --firmware "
            "plain.",
        )


def make_boards(world: World, config: CellConfig) -> Boards:
    """The boards that an emulated cell asks for.

    Raises:
        UsageError: a program or the simulator is not there, or the cell is too fast for them.
    """
    assert config.emulation is not None, "an emulated cell has an [emulation] table"
    if config.emulation.firmware == "plain":
        latch = Latch(world)
        talks = config.gripper.port is not None
        gripper = GripperBoardEmulator(latch, config) if talks else None
        return Boards(latch, gripper, ConveyorEmulator(world, config))
    check_boards(config)
    compiled = FirmwareGripper(world, config)
    return Boards(compiled.latch, compiled, FirmwareConveyor(world, config))
