"""One board's microcontroller in a process of its own, asked for slices of cell time.

The process is no part of the product and has a licence of its own; what is said to it is described
in ``firmware/simulator/README.md``.
"""

from __future__ import annotations

import json
import select
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import IO, Any, Final, NamedTuple

from cellctl.boards.constants import BoardRole, ResetCause
from cellctl.errors import CellctlError
from cellctl.sim.avr.programs import CHIPS, SIMULATOR, program, simulator_packages

ANSWER_TIMEOUT_S: Final = 60.0
"""For the process to answer (wall time); a slice takes it a millisecond."""
END_TIMEOUT_S: Final = 5.0
RESETS: Final = frozenset(
    {ResetCause.POWER, ResetCause.BROWNOUT, ResetCause.EXTERNAL, ResetCause.SOFTWARE}
)
"""Resets that can be asked for; a watchdog's comes of a hang."""


class BoardCrashedError(CellctlError):
    """A board's program did what no program may, or its simulator ended."""


class PinChange(NamedTuple):
    """A watched pin has changed its level."""

    time_s: float
    """Since power came on."""
    pin: str
    high: bool


class Slice(NamedTuple):
    """What a board did in a slice of time."""

    changes: tuple[PinChange, ...]
    """In order."""
    serial: bytes
    """What was on its serial line."""


class Memory(NamedTuple):
    """A microcontroller's memory, in bytes."""

    size: int
    static: int
    stack: int
    """The deepest that it ever was."""


class Simulator:
    """A board's program, running as far as it is told to. ``start`` it, ``stop`` it.

    Args:
        role: which board's.
        folder: where its program is; by default where `make firmware` puts it.

    Raises:
        UsageError: the program or the simulator is not there.
    """

    def __init__(self, role: BoardRole, folder: Path | None = None) -> None:
        self._role = role
        self._program = program(role, folder)
        self._packages = simulator_packages()
        self._process: subprocess.Popen[bytes] | None = None
        self._errors: IO[bytes] | None = None
        self.time_s = 0.0
        """How far it has run, since power first came on."""

    def start(self) -> None:
        """Start the process, and switch the board on.

        Raises:
            BoardCrashedError: the program cannot be loaded.
        """
        assert self._process is None, "it runs already"
        chip = CHIPS[self._role]
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115 - closed in stop()
        self._process = subprocess.Popen(  # noqa: S603 - this very interpreter, our program
            [
                *(sys.executable, "-s", str(SIMULATOR), "--chip", chip.name),
                *("--elf", str(self._program), "--frequency-hz", str(chip.frequency_hz)),
                *("--serial", chip.serial, "--watch", ",".join(chip.watched)),
                *("--serial-number", chip.serial_number),
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env={"PYTHONPATH": str(self._packages), "PYTHONDONTWRITEBYTECODE": "1"},
        )
        self._answer()

    def stop(self) -> None:
        """End the process; safe to repeat."""
        if self._process is None:
            return
        process, self._process = self._process, None
        assert process.stdin is not None
        assert process.stdout is not None
        with suppress(BrokenPipeError):
            process.stdin.close()
        try:
            process.wait(END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        process.stdout.close()
        if self._errors is not None:
            self._errors.close()

    def advance(self, dt_s: float, pins: dict[str, str], serial: bytes = b"") -> Slice:
        """Let time pass.

        Args:
            dt_s: how much.
            pins: levels that the cell puts on pins from now on, in the simulator's letters.
            serial: bytes that the adapter begins to send, after those still under way.

        Raises:
            BoardCrashedError: the program crashed, or the process ended.
        """
        self.time_s += dt_s
        answer = self._ask("advance", to_s=self.time_s, pins=pins, serial=serial.hex())
        changes = tuple(PinChange(time, pin, bool(high)) for time, pin, high in answer["events"])
        return Slice(changes, bytes.fromhex(answer["serial"]))

    def reset(self, cause: ResetCause) -> None:
        """Start the program anew for one of ``RESETS``."""
        assert cause in RESETS, f"no reset by {cause} can be asked for"
        self._ask("reset", cause=cause.value)

    def hang(self, *, interrupts: bool) -> None:
        """Catch the program in an endless loop, while interrupts go on or not."""
        self._ask("hang", interrupts=interrupts)

    def set_supply(self, volts: float) -> None:
        """Change the voltage of its supply."""
        self._ask("supply", volts=volts)

    def unplug(self) -> None:
        """What is still to be sent to the board is lost."""
        self._ask("unplug")

    def read_eeprom(self) -> bytes:
        """All that is kept."""
        return bytes.fromhex(self._ask("read_eeprom")["data"])

    def write_eeprom(self, address: int, data: bytes) -> None:
        """Change what is kept, behind the program's back."""
        self._ask("write_eeprom", address=address, data=data.hex())

    def memory(self) -> Memory:
        """How much memory is used."""
        answer = self._ask("memory")
        return Memory(answer["size"], answer["static"], answer["stack"])

    def _ask(self, do: str, **arguments: Any) -> dict[str, Any]:
        assert self._process is not None, "it does not run"
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps({"do": do, **arguments}).encode() + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            raise self._crashed("its simulator ended") from None
        return self._answer()

    def _answer(self) -> dict[str, Any]:
        assert self._process is not None
        assert self._process.stdout is not None
        if not select.select([self._process.stdout], [], [], ANSWER_TIMEOUT_S)[0]:
            raise self._crashed(f"its simulator did not answer within {ANSWER_TIMEOUT_S:g} s")
        line = self._process.stdout.readline()
        if not line:
            raise self._crashed("its simulator ended")
        answer: dict[str, Any] = json.loads(line)
        if not answer["ok"]:
            raise self._crashed(answer["error"])
        return answer

    def _crashed(self, why: str) -> BoardCrashedError:
        said = ""
        if self._errors is not None:
            self._errors.seek(0)
            said = self._errors.read()[-1000:].decode(errors="replace").strip()
        return BoardCrashedError(
            f"The {self._role}'s program in the AVR simulator: {why}."
            + (f"\n{said}" if said else ""),
            f"The program is {self._program}; the emulated cell cannot go on without it.",
        )
