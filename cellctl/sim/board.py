"""What the plain emulators of the boards have in common: a cable, a session, and faults.

Each does what a small firmware does: one sequence number and one outcome remembered, everything in
``advance``, in cell time.
"""

from __future__ import annotations

import random
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

from cellctl.assembly import Value
from cellctl.boards.constants import (
    COMMAND_LIMIT,
    FIRMWARE_VERSION,
    PROTOCOL_VERSION,
    BoardRole,
    Command,
    ErrorCode,
    ReplyKind,
    ResetCause,
)
from cellctl.boards.line import (
    COMMAND_START,
    Banner,
    CommandLine,
    Identity,
    LineError,
    LineSplitter,
    Reply,
    decode_command,
    encode_banner,
    encode_reply,
    is_stale,
)
from cellctl.sim.board_faults import (
    ActiveFaults,
    Hang,
    OldFirmware,
    Silent,
    Unplugged,
    WrongProtocol,
    WrongRole,
)
from cellctl.sim.cable import Cable


class BoardEmulator(ABC):
    """A board at the end of a serial cable.

    Args:
        role: what it calls itself.
        serial_number: its own.
        port: where the port appears.
        option: which option names the port, for messages.
        kinds: the faults it can have, by name.
        seed: of everything that is left to chance.
    """

    def __init__(
        self,
        role: BoardRole,
        *,
        serial_number: str,
        port: Path,
        option: str,
        kinds: dict[str, type[Value]],
        seed: int,
    ) -> None:
        self._board = role
        self._serial_number = serial_number
        self._faults = ActiveFaults(role.value, kinds)
        chance = random.Random(f"{seed} {role}")  # noqa: S311 - repeatable chance
        self._cable = Cable(port, option, self._faults, chance)
        self._resets = self._lines = self._damaged = 0
        self._forget()

    def start(self) -> None:
        """Make the port and switch the board on.

        Raises:
            UsageError: the port's name is taken by something else, or cannot be made.
        """
        self._cable.plug_in()
        self._boot(ResetCause.POWER)

    def stop(self) -> None:
        """Take the port away; safe to repeat."""
        self._cable.unplug()

    def inject(self, fault: str, **arguments: Any) -> None:
        """Switch on one of the board's faults.

        Raises:
            UsageError: there is no such fault, or not with these arguments.
        """
        injected = self._faults.inject(fault, arguments)
        match injected:
            case Unplugged():
                self._cable.unplug()
            case Hang():
                self._faults.end(Hang)
                self.reset(ResetCause.WATCHDOG)
            case _:
                self._struck(injected)

    def clear(self, fault: str) -> None:
        """Switch a fault off.

        Raises:
            UsageError: there is no such fault.
        """
        if self._faults.clear(fault) is Unplugged and not self._cable.is_plugged_in:
            self._cable.plug_in()
            self.reset(ResetCause.POWER)

    def fault_names(self) -> tuple[str, ...]:
        """The names of the faults that are active."""
        return self._faults.names()

    def reset(self, cause: ResetCause) -> None:
        """Start anew."""
        self._resets += 1
        self._boot(cause)

    @abstractmethod
    def _struck(self, fault: Value) -> None:
        """A fault that may happen at once was injected."""

    @abstractmethod
    def _act(self, line: CommandLine) -> Reply:
        """Carry out a command of an identified host that is no old one."""

    @abstractmethod
    def _begin_session(self) -> None:
        """A host has identified the board."""

    def _forget(self) -> None:
        """What a reset wipes out."""
        self._identified = False
        self._last = 0
        """Sequence number of the newest command."""
        self._damaged = 0
        self._unheard_s = 0.0
        """How long no valid line has come."""
        self._splitter = LineSplitter((COMMAND_START,), COMMAND_LIMIT)

    def _boot(self, cause: ResetCause) -> None:
        self._forget()
        self._send(encode_banner(Banner(self._role(), self._protocol_version(), cause)))

    def _receive(self) -> None:
        data = self._cable.read()
        if self._faults.get(Silent):
            return
        for frame in self._splitter.feed(data):
            try:
                line = decode_command(frame)
            except LineError:
                self._damaged += 1
                continue
            self._lines += 1
            self._unheard_s = 0.0
            self._send(encode_reply(self._answer(line)))

    def _answer(self, line: CommandLine) -> Reply:
        if line.command == Command.IDENTIFY and line.argument is None:
            self._begin_session()
            self._identified, self._last = True, line.sequence
            return Reply(line.sequence, ReplyKind.OK, identity=self._identity())
        if not self._identified:
            return error_reply(line, ErrorCode.UNREADY)
        if is_stale(line.sequence, self._last):
            return error_reply(line, ErrorCode.STALE)
        return self._act(line)

    def _identity(self) -> Identity:
        old = self._faults.get(OldFirmware)
        firmware = FIRMWARE_VERSION[self._board] if old is None else old.version
        return Identity(self._role(), self._serial_number, self._protocol_version(), firmware)

    def _role(self) -> str:
        wrong = self._faults.get(WrongRole)
        return self._board if wrong is None else wrong.role

    def _protocol_version(self) -> int:
        wrong = self._faults.get(WrongProtocol)
        return PROTOCOL_VERSION if wrong is None else wrong.version

    def _send(self, frame: bytes) -> None:
        if self._cable.is_plugged_in and not self._faults.get(Silent):
            self._cable.write(frame)


def error_reply(line: CommandLine, error: ErrorCode) -> Reply:
    """The answer that a command was not carried out."""
    return Reply(line.sequence, ReplyKind.ERR, error=error)
