"""The gripper's board in the daemon: looked after, shown, asked and calibrated.

Its serial port is optional, and losing it stops nothing: a notice tells, and it is looked for
again. A reset of the board is a matter for the cell, which may have a part in the latch.
"""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Final, Literal

import structlog

from cellctl.assembling.gripper_board import RANGES, GripperBoard
from cellctl.boards.constants import Command, GripperFault, Register, ResetCause, SelfTest
from cellctl.boards.session import BoardLostError, BoardMismatchError
from cellctl.errors import CellctlError, CellFault, RefusedError, UsageError
from cellctl.messages import BoardData, GripperCommand, GripperData
from cellctl.notices import NOTICES, Notice

log = structlog.get_logger(__name__)

_LOOK_EVERY_S: Final = 1.0
"""How often the board is asked (wall time)."""
Holding = Literal["nothing", "part", "latching", "releasing", "gripped"]


class GripperWatch:
    """Looks after the gripper's board. Belongs to one event loop.

    Args:
        make_board: makes the board's driver, which calls its argument at each reset; None where it
            has no serial port.
        on_change: called when ``view`` would show something else.
        on_reset: what the cell does when the board was reset; gets its cause if one was told.
    """

    def __init__(
        self,
        make_board: Callable[[Callable[[ResetCause | None], None]], GripperBoard] | None,
        on_change: Callable[[], None],
        on_reset: Callable[[ResetCause | None], Awaitable[None]],
    ) -> None:
        self.board = make_board(self._was_reset) if make_board is not None else None
        self._on_change = on_change
        self._on_reset = on_reset
        self._resets: asyncio.Queue[ResetCause | None] = asyncio.Queue()
        self._identity: BoardData | None = None
        self._registers: dict[str, int] = {}
        self._stale = False
        """It was reset since it told its registers."""
        self._notice: Notice | None = None

    def view(self, holding: Holding) -> GripperData:
        """As the bus shows it; never asks the board."""
        return GripperData(
            holding=holding,
            board=self._identity,
            resets=self.board.resets if self.board is not None else 0,
            registers=self._registers,
            notice=self._notice,
        )

    async def verify(self) -> None:
        """See that the board on the port is the gripper's; one that is away does no harm.

        Raises:
            CellFault: ``gripper_mismatch``.
        """
        if self.board is None:
            return
        try:
            await self._meet()
        except BoardMismatchError as error:
            raise CellFault("gripper_mismatch", str(error)) from error
        except CellctlError as error:
            log.warning("the gripper's board is not connected", reason=str(error))

    async def run(self) -> None:
        """Look after the board until cancelled."""
        if self.board is None:
            return
        while True:
            await self._look()
            try:
                async with asyncio.timeout(_LOOK_EVERY_S):
                    cause = await self._resets.get()
            except TimeoutError:
                continue
            self._on_change()
            await self._on_reset(cause)

    async def take(self, said: GripperCommand) -> str:
        """Do what an operator asks of the board; returns what it says, for people.

        Raises:
            UsageError: the board has no port here, or a value is out of its range.
            RefusedError: the board does not answer, or the latch moves.
        """
        board = self.board
        if board is None:
            raise UsageError(
                "The gripper's board has no serial port in this cell.",
                "Connect it and set gripper.port; the gripper works without it too.",
            )
        try:
            return await self._do(board, said)
        except (BoardLostError, BoardMismatchError) as error:
            raise RefusedError(error.message, "See `cellctl doctor`.") from error

    async def close(self) -> None:
        """Let go of the port."""
        if self.board is not None:
            await self.board.close()

    async def _do(self, board: GripperBoard, said: GripperCommand) -> str:
        match said.do:
            case "show":
                await self._ask_all(board)
                return "\n".join(_shown(self._registers))
            case "test":
                found = await board.self_test()
                await self._ask_all(board)
                return _tested(found)
            case "keep":
                await board.keep()
                await self._ask_all(board)
                return "The calibration is kept; it outlives power."
            case "clear":
                await board.clear()
                await self._ask_all(board)
                return "The gripper's fault is cleared."
            case "set":
                wanted = {
                    Command.LATCH_PULSE: said.latch_pulse_us,
                    Command.UNLATCH_PULSE: said.unlatch_pulse_us,
                    Command.TRAVEL: said.travel_ms,
                }
                given = {setting: value for setting, value in wanted.items() if value is not None}
                if not given:
                    raise UsageError("Say what to set: a pulse or the travel time.")
                for setting, value in given.items():
                    await board.calibrate(setting, value)
                await self._ask_all(board)
                return (
                    "Set; it counts from the next time the latch moves. "
                    "`cellctl gripper keep` makes it outlive power."
                )

    async def _look(self) -> None:
        assert self.board is not None, "looked after only where there is one"
        before = (self._identity, self._notice)
        try:
            if self._identity is None or self._stale:
                await self._meet()
            state = await self.board.state()
            self._notice = NOTICES["gripper_uncalibrated"] if state.default_calibration else None
        except BoardMismatchError as error:
            self._away("gripper_board_mismatch", error)
        except CellctlError as error:
            self._away("gripper_board_lost", error)
        if (self._identity, self._notice) != before:
            self._on_change()

    def _away(self, notice: str, error: CellctlError) -> None:
        if self._notice is not NOTICES[notice]:
            log.warning("the gripper's board is not connected", reason=str(error))
        self._identity, self._notice = None, NOTICES[notice]

    async def _meet(self) -> None:
        assert self.board is not None, "met only where there is one"
        found = await self.board.connect()
        self._identity = BoardData(
            port=self.board.port,
            serial_number=found.serial_number,
            protocol_version=found.protocol_version,
            firmware_version=found.firmware_version,
        )
        await self._ask_all(self.board)

    async def _ask_all(self, board: GripperBoard) -> None:
        told = await board.registers()
        self._stale = False
        self._registers = {register.name.lower(): value for register, value in told.items()}
        self._on_change()

    def _was_reset(self, cause: ResetCause | None) -> None:
        self._stale = True
        self._resets.put_nowait(cause)


def _shown(registers: dict[str, int]) -> list[str]:
    units = {Register.SUPPLY: " mV", Register.STACK_LEFT: " bytes"}
    units |= {Register.LATCH_PULSE: " us", Register.UNLATCH_PULSE: " us", Register.TRAVEL: " ms"}
    lines = []
    for register in Register:
        value = registers[register.name.lower()]
        text = f"{value}{units.get(register, '')}"
        if register is Register.FAULT:
            known = value in set(GripperFault)
            text = GripperFault(value).name.lower() if known else f"number {value}"
        setting = next((s for s in RANGES if s.name == register.name), None)
        if setting is not None:
            least, most, _ = RANGES[setting]
            text += f" ({least} to {most})"
        lines.append(f"{register.name.lower().replace('_', ' ')}: {text}")
    return lines


def _tested(found: SelfTest) -> str:
    if not found:
        return "The self-test found nothing wrong."
    names = ", ".join(str(bit.name).lower().replace("_", " ") for bit in SelfTest if bit in found)
    return f"The self-test found wrong: {names}."
