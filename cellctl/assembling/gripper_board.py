"""The gripper's board on its serial port: what it tells beside its two lines, and its calibration.

Optional: the lines on the robot's controller command the latch and confirm it, with this port or
without. What the port adds is who the board is, why it was reset, how often, and what it makes of
its lines. No command on it moves the latch.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Final

from cellctl.assembly import Value
from cellctl.boards.constants import (
    PULSE_MAX_US,
    PULSE_MIN_US,
    TRAVEL_MAX_MS,
    TRAVEL_MIN_MS,
    BoardRole,
    Command,
    ErrorCode,
    GripperFlag,
    Register,
    ResetCause,
    SelfTest,
)
from cellctl.boards.line import Identity
from cellctl.boards.session import Board, BoardPort, BoardRefusedError
from cellctl.config import GripperSection
from cellctl.errors import RefusedError, UsageError

RANGES: Final = {
    Command.LATCH_PULSE: (PULSE_MIN_US, PULSE_MAX_US, "us"),
    Command.UNLATCH_PULSE: (PULSE_MIN_US, PULSE_MAX_US, "us"),
    Command.TRAVEL: (TRAVEL_MIN_MS, TRAVEL_MAX_MS, "ms"),
}
"""What each part of the calibration may be: least, most, and the unit."""
LEAST_TURN_US: Final = 200
"""Least difference of the two pulses; a latch that hardly turns would be confirmed all the same."""
_OTHER_PULSE: Final = {
    Command.LATCH_PULSE: Register.UNLATCH_PULSE,
    Command.UNLATCH_PULSE: Register.LATCH_PULSE,
}


class LatchState(Value):
    """What the gripper's board says of its latch."""

    confirmed: bool
    """A latch was completed, and nothing changed since."""
    told_open: bool
    """Its command line is high."""
    moving: bool
    fault: bool
    """It has latched a fault of its own."""
    part: bool
    """Its sensor sees a part, or the servo's load."""
    default_calibration: bool
    """Its record in the EEPROM is damaged or empty."""
    cycles: int
    """Latches completed in its life, modulo 65536."""


class GripperBoard:
    """The board of one gripper. Connects by itself when used, and again after a loss.

    Every method raises ``BoardLostError`` and ``BoardMismatchError`` besides what it says.

    Args:
        settings: the ``[gripper]`` table, with a port.
        on_reset: called in the event loop when a reset was noticed, with its cause if one was told.
    """

    def __init__(
        self, settings: GripperSection, on_reset: Callable[[ResetCause | None], None]
    ) -> None:
        assert settings.port is not None, "without a port there is no board to talk to"
        self.port = settings.port
        self._board = Board(
            BoardPort(
                role=BoardRole.GRIPPER,
                port=settings.port,
                baud=settings.baud,
                reply_timeout_s=settings.reply_timeout_s,
                serial_number=settings.serial_number,
                table="gripper",
            ),
            on_reset,
        )
        self._busy = asyncio.Lock()

    @property
    def resets(self) -> int:
        """How many resets were noticed since this object was made."""
        return self._board.resets

    async def connect(self) -> Identity:
        """See who answers."""
        async with self._busy:
            return await self._board.connect()

    async def state(self) -> LatchState:
        """What it says of its latch."""
        async with self._busy:
            status = await self._board.carry_out(Command.STATUS)
        flags = GripperFlag(status.flags)
        return LatchState(
            confirmed=GripperFlag.CONFIRMED in flags,
            told_open=GripperFlag.TOLD_OPEN in flags,
            moving=GripperFlag.MOVING in flags,
            fault=GripperFlag.LATCHED in flags,
            part=GripperFlag.PART in flags,
            default_calibration=GripperFlag.DEFAULT in flags,
            cycles=status.value,
        )

    async def registers(self) -> dict[Register, int]:
        """All that it can tell."""
        async with self._busy:
            return {
                register: (await self._board.carry_out(Command.READ, register)).value
                for register in Register
            }

    async def calibrate(self, setting: Command, value: int) -> None:
        """Change one part of the calibration; it counts from the next time the latch moves.

        Args:
            setting: a key of ``RANGES``.
            value: in the unit of its range.

        Raises:
            UsageError: it is out of its range, or too close to the other pulse.
            RefusedError: the latch moves.
        """
        least, most, unit = RANGES[setting]
        if not least <= value <= most:
            raise UsageError(
                f"{setting.name.lower()} = {value} {unit}: must be {least} to {most} {unit}."
            )
        if setting in _OTHER_PULSE:
            other = await self._carry_out(Command.READ, _OTHER_PULSE[setting])
            if abs(value - other) < LEAST_TURN_US:
                raise UsageError(
                    f"{setting.name.lower()} = {value} us: the other pulse is {other} us, and with "
                    f"less than {LEAST_TURN_US} us between them the latch would not turn.",
                    "To swap the two, set one of them far from both first.",
                )
        await self._carry_out(setting, value)

    async def keep(self) -> None:
        """Write the calibration into the EEPROM.

        Raises:
            RefusedError: the latch moves.
        """
        await self._carry_out(Command.KEEP)

    async def clear(self) -> None:
        """Forget a latched fault."""
        await self._carry_out(Command.CLEAR)

    async def self_test(self) -> SelfTest:
        """Test what can be tested without moving anything; what is wrong."""
        return SelfTest(await self._carry_out(Command.SELF_TEST))

    async def close(self) -> None:
        """Let go of the port."""
        async with self._busy:
            self._board.drop()

    async def _carry_out(self, command: Command, argument: int | None = None) -> int:
        async with self._busy:
            try:
                return (await self._board.carry_out(command, argument)).value
            except BoardRefusedError as error:
                if error.code is ErrorCode.MOVING:
                    raise RefusedError("The latch moves.", "Try again when it rests.") from error
                raise
