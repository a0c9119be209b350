"""What the compiled boards have in common: a program that runs, a cable, and faults."""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from cellctl.assembly import Value
from cellctl.boards.constants import REPLY_LIMIT, BoardRole, ResetCause
from cellctl.boards.line import BANNER_START, COMMAND_START, END, REPLY_START
from cellctl.config import CellConfig
from cellctl.errors import UsageError
from cellctl.sim.avr.simulator import RESETS, PinChange, Simulator
from cellctl.sim.board_faults import ActiveFaults, Hang, Silent, Unplugged
from cellctl.sim.cable import Cable

PLAIN_ONLY: Final = frozenset({"wrong_role", "wrong_protocol", "old_firmware"})
"""Faults that make a board say what a compiled one does not."""


class FirmwareBoard(ABC):
    """A board that runs its compiled program, at the end of a serial cable.

    Args:
        role: which board.
        config: an emulated cell; says where the programs are.
        port: where the port appears; None: nothing is plugged in.
        option: which option names the port, for messages.
        kinds: the faults it can have, by name.

    Raises:
        UsageError: the program or the simulator is not there.
    """

    def __init__(
        self,
        role: BoardRole,
        config: CellConfig,
        *,
        port: str | None,
        option: str,
        kinds: dict[str, type[Value]],
    ) -> None:
        assert config.emulation is not None, "an emulated cell has an [emulation] table"
        folder = config.emulation.firmware_folder
        self.simulator = Simulator(role, Path(folder) if folder is not None else None)
        self._role = role
        self._faults = ActiveFaults(role.value, kinds)
        chance = random.Random(f"{config.emulation.seed} {role}")  # noqa: S311 - repeatable
        self._cable = Cable(Path(port), option, self._faults, chance) if port is not None else None
        self._said = b""
        """What the board has said since its last whole line."""
        self._resets = self._lines = 0
        self._booted = False
        self._wired: dict[str, str] = {}
        """What its pins were wired to when it last ran."""
        self._owed_s = 0.0
        """Cell time that the program has not run yet; nothing has changed at its pins since."""

    def start(self) -> None:
        """Make the port and switch the board on.

        Raises:
            UsageError: the port's name is taken by something else, or cannot be made.
            BoardCrashedError: the program cannot be loaded.
        """
        if self._cable is not None:
            self._cable.plug_in()
        self.simulator.start()

    def stop(self) -> None:
        """Take the port away; safe to repeat."""
        if self._cable is not None:
            self._cable.unplug()
        self.simulator.stop()

    def inject(self, fault: str, **arguments: object) -> None:
        """Switch on one of the board's faults.

        Raises:
            UsageError: there is no such fault, or not with these arguments, or a compiled program
                cannot have it.
        """
        if fault in PLAIN_ONLY:
            raise UsageError(
                f"The {self._role}'s compiled program cannot have the fault {fault!r}: it says "
                "who it is.",
                "Run the emulated cell with --firmware plain.",
            )
        self._catch_up()
        injected = self._faults.inject(fault, arguments)
        match injected:
            case Unplugged():
                if self._cable is not None:
                    self._cable.unplug()
                self.simulator.unplug()
            case Hang(interrupts=interrupts):
                self._faults.end(Hang)
                self.simulator.hang(interrupts=interrupts)
            case _:
                self._struck(injected)

    def clear(self, fault: str) -> None:
        """Switch a fault off.

        Raises:
            UsageError: there is no such fault.
        """
        kind = self._faults.clear(fault)
        if kind is Unplugged and self._cable is not None and not self._cable.is_plugged_in:
            self._cable.plug_in()
            self.reset(ResetCause.POWER)
        self._mended(kind)

    def reset(self, cause: ResetCause) -> None:
        """Start the program anew.

        Raises:
            UsageError: no such reset can be asked for.
        """
        self._catch_up()
        if cause is ResetCause.WATCHDOG:
            self.simulator.hang(interrupts=False)
        elif cause in RESETS:
            self.simulator.reset(cause)
        else:
            raise UsageError(
                f"No reset by {cause} can be made to happen to a compiled program.",
                f"Take one of: {', '.join(sorted({*RESETS, ResetCause.WATCHDOG}))}.",
            )

    def fault_names(self) -> tuple[str, ...]:
        """The names of the faults that are active."""
        return self._faults.names()

    def advance(self, dt_s: float) -> None:
        """Let cell time pass.

        The program runs when something has changed at its pins, and otherwise in longer pieces:
        each costs two switches of process.

        Raises:
            BoardCrashedError: the program crashed.
        """
        serial = b""
        if self._cable is not None:
            self._cable.advance(dt_s)
            serial = self._cable.read()
            if self._faults.get(Silent):
                serial = b""
        if serial or self._wiring() != self._wired:
            self._catch_up()
            self._wired = self._wiring()
            self._run(dt_s, serial)
        else:
            self._owed_s += dt_s
            if self._owed_s >= self._longest_s - 1e-9:
                self._catch_up()

    def _catch_up(self) -> None:
        owed_s, self._owed_s = self._owed_s, 0.0
        if owed_s > 0.0:
            self._run(owed_s, b"")

    def _run(self, dt_s: float, serial: bytes) -> None:
        """Run the program; what it says goes to the host, what it does to the cell."""
        did = self.simulator.advance(dt_s, self._wired, serial)
        if did.serial:
            self._hear(did.serial)
        self._follow(did.changes)

    @property
    @abstractmethod
    def _longest_s(self) -> float:
        """How long the program may run at once now."""

    @abstractmethod
    def _wiring(self) -> dict[str, str]:
        """What the cell puts on the board's pins now, in the simulator's letters."""

    @abstractmethod
    def _follow(self, changes: Sequence[PinChange]) -> None:
        """Let what the board's pins did act on the cell."""

    @abstractmethod
    def _struck(self, fault: Value) -> None:
        """A fault was injected."""

    @abstractmethod
    def _mended(self, kind: type[Value]) -> None:
        """A fault was cleared."""

    def _hear(self, data: bytes) -> None:
        self._said += data
        *lines, self._said = self._said.split(END)
        for line in lines:
            self._say(line + END)
        if len(self._said) > REPLY_LIMIT:
            self._said, rest = b"", self._said
            self._say(rest)

    def _say(self, line: bytes) -> None:
        if line.startswith(BANNER_START):
            self._resets += self._booted
            self._booted = True
        elif line.startswith(REPLY_START):
            self._lines += 1
        if self._cable is None or not self._cable.is_plugged_in or self._faults.get(Silent):
            return
        if line.startswith(COMMAND_START):
            self._cable.echo(line)
        else:
            self._cable.write(line)
