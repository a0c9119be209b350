"""The emulated board of the gripper, as far as its serial port goes: it tells, and is calibrated.

The latch itself is ``latch.Latch``, which the robot's lines command; no line on the port moves it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final, Literal

from cellctl.assembly import Value
from cellctl.boards.constants import (
    COMMANDS,
    COUNTER_COUNT,
    LATCH_PULSE_US,
    PULSE_MAX_US,
    PULSE_MIN_US,
    TRAVEL_MAX_MS,
    TRAVEL_MIN_MS,
    TRAVEL_MS,
    UNLATCH_PULSE_US,
    BoardRole,
    Command,
    ErrorCode,
    GripperFault,
    GripperFlag,
    Register,
    ReplyKind,
    ResetCause,
    SelfTest,
)
from cellctl.boards.line import CommandLine, Reply, Status
from cellctl.config import CellConfig
from cellctl.sim.board import BoardEmulator, error_reply
from cellctl.sim.board_faults import BOARD_FAULTS
from cellctl.sim.latch import Latch

SERIAL_NUMBER: Final = "1E922353494D00000001"
_SUPPLY_MV: Final = 5000
_STACK_LEFT: Final = 60
"""What a firmware of this size leaves, in bytes."""
_DEFAULTS: Final = {
    Register.LATCH_PULSE: LATCH_PULSE_US,
    Register.UNLATCH_PULSE: UNLATCH_PULSE_US,
    Register.TRAVEL: TRAVEL_MS,
}
_SETS: Final = {
    Command.LATCH_PULSE: (Register.LATCH_PULSE, PULSE_MIN_US, PULSE_MAX_US),
    Command.UNLATCH_PULSE: (Register.UNLATCH_PULSE, PULSE_MIN_US, PULSE_MAX_US),
    Command.TRAVEL: (Register.TRAVEL, TRAVEL_MIN_MS, TRAVEL_MAX_MS),
}


class Reset(Value):
    """The board starts anew, once; the latch stays where it is, unconfirmed."""

    cause: ResetCause = ResetCause.WATCHDOG
    when: Literal["now", "opening", "closing"] = "now"
    """It waits until the latch does so."""


class StoreDamaged(Value):
    """The record in the EEPROM is damaged, once; the board finds out when it starts."""


FAULTS: Final[dict[str, type[Value]]] = {
    **BOARD_FAULTS,
    "reset": Reset,
    "store_damaged": StoreDamaged,
}


class GripperBoardEmulator(BoardEmulator):
    """The gripper's board on its serial port.

    Args:
        latch: what it runs.
        config: an emulated cell; ``gripper.port`` is where the port appears.
    """

    def __init__(self, latch: Latch, config: CellConfig) -> None:
        assert config.emulation is not None, "an emulated cell has an [emulation] table"
        assert config.gripper.port is not None, "without a port there is no board to talk to"
        self._latch = latch
        self._kept: dict[Register, int] | None = dict(_DEFAULTS)
        """The calibration in the EEPROM; None: there is none, or it is damaged."""
        self._causes: dict[ResetCause, int] = {}
        super().__init__(
            BoardRole.GRIPPER,
            serial_number=SERIAL_NUMBER,
            port=Path(config.gripper.port),
            option="gripper.port",
            kinds=FAULTS,
            seed=config.emulation.seed,
        )

    def advance(self, dt_s: float) -> None:
        """Hear what has arrived. Never waits."""
        pending = self._faults.get(Reset)
        doing = "opening" if self._latch.told_open else "closing"
        if pending is not None and self._latch.moving and pending.when == doing:
            self._faults.end(Reset)
            self.reset(pending.cause)
        self._cable.advance(dt_s)
        self._receive()

    def reset(self, cause: ResetCause) -> None:
        self._causes[cause] = self._causes.get(cause, 0) + 1
        self._latch.reboot()
        super().reset(cause)

    def truth(self) -> dict[str, Any]:
        """What is really so, for judges and tests."""
        return {
            "calibration": {register.name.lower(): self._set[register] for register in _DEFAULTS},
            "kept": self._kept is not None,
            "resets": self._resets,
            "lines": self._lines,
            "faults": self._faults.names(),
        }

    def _struck(self, fault: Value) -> None:
        match fault:
            case Reset(cause=cause, when="now"):
                self._faults.end(Reset)
                self.reset(cause)
            case StoreDamaged():
                self._faults.end(StoreDamaged)
                self._kept = None

    def _forget(self) -> None:
        super()._forget()
        self._set = dict(self._kept or _DEFAULTS)
        """The calibration that holds."""
        self._default = self._kept is None
        self._latch.travel_s = self._set[Register.TRAVEL] / 1000.0

    def _begin_session(self) -> None:
        """Nothing of an earlier session is remembered."""

    def _act(self, line: CommandLine) -> Reply:
        self._last = line.sequence
        for setting, (register, least, most) in _SETS.items():
            if line.command == setting:
                return self._calibrate(line, register, range(least, most + 1))
        if line.command == Command.READ:
            if line.argument is None or line.argument not in set(Register):
                return error_reply(line, ErrorCode.ARGUMENT)
            return self._reply(line, self._register(Register(line.argument)))
        if line.argument is not None:
            return error_reply(line, ErrorCode.ARGUMENT)
        if line.command not in COMMANDS[BoardRole.GRIPPER]:
            return error_reply(line, ErrorCode.COMMAND)
        return self._act_plainly(line)

    def _calibrate(self, line: CommandLine, register: Register, allowed: range) -> Reply:
        if line.argument is None or line.argument not in allowed:
            return error_reply(line, ErrorCode.ARGUMENT)
        if self._latch.moving:
            return error_reply(line, ErrorCode.MOVING)
        self._set[register] = line.argument
        self._latch.travel_s = self._set[Register.TRAVEL] / 1000.0
        return self._reply(line, line.argument)

    def _act_plainly(self, line: CommandLine) -> Reply:
        match line.command:
            case Command.STATUS | Command.CLEAR:
                pass  # a fault of the latch lasts as long as its cause
            case Command.KEEP:
                if self._latch.moving:
                    return error_reply(line, ErrorCode.MOVING)
                self._kept, self._default = dict(self._set), False
            case Command.SELF_TEST:
                return self._reply(line, SelfTest.RECORD if self._kept is None else 0)
        return self._reply(line, self._latch.cycles % COUNTER_COUNT)

    def _register(self, register: Register) -> int:
        match register:
            case Register.CYCLES:
                value = self._latch.cycles
            case Register.WATCHDOG_RESETS:
                value = self._causes.get(ResetCause.WATCHDOG, 0)
            case Register.BROWNOUT_RESETS:
                value = self._causes.get(ResetCause.BROWNOUT, 0)
            case Register.DAMAGED_LINES:
                value = self._damaged
            case Register.SUPPLY:
                value = _SUPPLY_MV
            case Register.FAULT:
                value = GripperFault.SUPPLY if self._latch.faulty else GripperFault.NONE
            case Register.STACK_LEFT:
                value = _STACK_LEFT
            case _:
                value = self._set[register]
        return value % COUNTER_COUNT

    def _reply(self, line: CommandLine, value: int) -> Reply:
        latch, flags = self._latch, GripperFlag(0)
        for holds, flag in (
            (latch.moving, GripperFlag.MOVING),
            (latch.faulty, GripperFlag.LATCHED),
            (latch.confirmed, GripperFlag.CONFIRMED),
            (latch.told_open, GripperFlag.TOLD_OPEN),
            (latch.holds_part, GripperFlag.PART),
            (self._default, GripperFlag.DEFAULT),
        ):
            if holds:
                flags |= flag
        return Reply(line.sequence, ReplyKind.OK, Status(flags, value))
