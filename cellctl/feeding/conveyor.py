"""The conveyor, over its serial port: the product's implementation of ``Belt``.

A lost command or reply costs time and never a second advance: see ``boards.session``. An index
under way is asked for by repeating its line; these repetitions are also the sign of life without
which the board stops the belt.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress

import structlog

from cellctl.boards.constants import (
    PITCH_UNIT_M,
    POLL_S,
    BoardRole,
    Command,
    ConveyorFlag,
    ErrorCode,
    ReplyKind,
)
from cellctl.boards.line import Identity, Reply, Status
from cellctl.boards.link import LinkLostError
from cellctl.boards.session import (
    SENDS,
    Board,
    BoardLostError,
    BoardMismatchError,
    BoardPort,
    BoardRefusedError,
    ResetNoticed,
)
from cellctl.clock import Clock
from cellctl.config import FeederSection
from cellctl.errors import CellFault
from cellctl.feeding.belt import BeltIdentity, BeltState

log = structlog.get_logger(__name__)

ROOM_PITCHES = 1.1
"""How far the belt goes backward for a part that comes back: parts may not quite follow it."""


class Conveyor:
    """One conveyor on one serial port. Connects by itself when used, and again after a loss.

    Args:
        settings: port, baud rate and time-outs.
        pitch_m: distance from part to part on the belt.
        clock: cell time, which indexes are measured in; replies are waited for in wall time.
    """

    def __init__(self, settings: FeederSection, pitch_m: float, clock: Clock) -> None:
        self._settings = settings
        self._pitch = round(pitch_m / PITCH_UNIT_M)
        self._clock = clock
        self._board = Board(
            BoardPort(
                role=BoardRole.CONVEYOR,
                port=settings.port,
                baud=settings.baud,
                reply_timeout_s=settings.reply_timeout_s,
                serial_number=settings.serial_number,
                table="feeder",
            )
        )
        self._busy = asyncio.Lock()
        """Held for one exchange; an index is one exchange."""
        self._index: asyncio.Task[object] | None = None
        """The task that is in ``present``, whether it waits for ``_busy`` or holds it."""

    @property
    def resets(self) -> int:
        """How many resets of the board were noticed since this object was made."""
        return self._board.resets

    async def connect(self) -> BeltIdentity:
        async with self._exchange():
            return _identity(await self._board.connect(), self._settings.port)

    async def state(self) -> BeltState:
        if self._index is not None and self._board.status is not None:
            return _state(self._board.status)
        async with self._exchange():
            return _state(await self._board.carry_out(Command.STATUS))

    async def present(self) -> None:
        assert self._index is None, "one index at a time"
        self._index = asyncio.current_task()
        try:
            async with self._exchange():
                await self._present()
        finally:
            self._index = None

    async def make_room(self) -> None:
        assert self._index is None, "one index at a time"
        self._index = asyncio.current_task()
        try:
            async with self._exchange():
                await self._make_room()
        finally:
            self._index = None

    async def halt(self) -> None:
        if self._index is not None:
            self._index.cancel()
        async with self._exchange():
            # Without a link there is nobody to tell: a board that hears nothing stops by itself.
            if self._board.is_open:
                await self._board.carry_out(Command.HALT)

    async def close(self) -> None:
        if self._index is not None:
            with suppress(CellFault):
                await self.halt()
        async with self._busy:
            self._board.drop()

    @asynccontextmanager
    async def _exchange(self) -> AsyncIterator[None]:
        """One exchange at a time; what goes wrong with the board becomes a fault."""
        async with self._busy:
            try:
                yield
            except BoardLostError as error:
                raise CellFault("belt_lost", str(error)) from error
            except (BoardMismatchError, BoardRefusedError) as error:
                raise CellFault("belt_mismatch", str(error)) from error

    # --- indexing -----------------------------------------------------------------------------

    async def _present(self) -> None:
        board, deadline_s = self._board, self._clock.now_s() + self._settings.index_timeout_s
        code, trouble = "belt_jam", "the belt is still moving"
        while True:
            try:
                reply = await self._move(Command.FORWARD, deadline_s, self._pitch)
            except ResetNoticed:
                # The part may lie anywhere up to the sensor: going on forward is right.
                code, trouble = "belt_lost", "the board was reset again and again"
                continue
            if reply is None:
                await board.carry_out(Command.HALT)
                raise CellFault(code, f"After {self._settings.index_timeout_s:g} s {trouble}.")
            match reply.error:
                case None:
                    return
                case ErrorCode.NO_EDGE:
                    raise CellFault("belt_empty", "The belt ran and no part came to the sensor.")
                case ErrorCode.NO_MOTION:
                    raise CellFault("belt_jam", "The belt's motor was stalled.")
                case ErrorCode.LATCHED:
                    await board.carry_out(Command.CLEAR)
                case ErrorCode.SILENCE | ErrorCode.MOVING | ErrorCode.STALE:
                    log.info("index interrupted, going on", reason=reply.error.value)
                    code, trouble = "belt_lost", f"the board still says {reply.error.value}"
                case _:
                    raise board.refused(Command.FORWARD, reply)

    async def _make_room(self) -> None:
        """Go one pitch backward; what interrupts it only makes it begin anew, for more room than a
        part takes does no harm."""
        board, deadline_s = self._board, self._clock.now_s() + self._settings.index_timeout_s
        distance = round(self._pitch * ROOM_PITCHES)
        while True:
            try:
                reply = await self._move(Command.BACKWARD, deadline_s, distance)
            except ResetNoticed:
                continue
            if reply is None:
                await board.carry_out(Command.HALT)
                timeout_s = self._settings.index_timeout_s
                raise CellFault("belt_jam", f"After {timeout_s:g} s there is no room on the belt.")
            match reply.error:
                case None:
                    return
                case ErrorCode.NO_MOTION:
                    raise CellFault(
                        "belt_jam",
                        "It went backward, and did not move or a part is still at the sensor.",
                    )
                case ErrorCode.LATCHED:
                    await board.carry_out(Command.CLEAR)
                case ErrorCode.SILENCE | ErrorCode.MOVING | ErrorCode.STALE:
                    log.info("going backward was interrupted, going on", reason=reply.error.value)
                case _:
                    raise board.refused(Command.BACKWARD, reply)

    async def _move(self, command: Command, deadline_s: float, argument: int) -> Reply | None:
        """Repeat a motion's line until its outcome is known; None when the deadline passes."""
        board = self._board
        link = await board.session()
        loop = asyncio.get_running_loop()
        frame, sequence = board.frame(command, argument)
        heard_s = loop.time()
        try:
            while self._clock.now_s() < deadline_s:
                link.send(frame)
                with suppress(TimeoutError):
                    async with self._clock.timeout(POLL_S):
                        while True:
                            reply = await board.reply_to(link, sequence)
                            heard_s = loop.time()
                            if reply.kind is not ReplyKind.BUSY:
                                return reply
                if loop.time() - heard_s > SENDS * self._settings.reply_timeout_s:
                    raise board.silent(" in the middle of an index")
        except LinkLostError as error:
            raise board.lost(str(error)) from error
        except asyncio.CancelledError:
            # A newer number also makes the board refuse repetitions of the index on their way.
            with suppress(LinkLostError):
                link.send(board.frame(Command.HALT)[0])
            raise
        return None


def _identity(found: Identity, port: str) -> BeltIdentity:
    return BeltIdentity(
        role=found.role,
        port=port,
        serial_number=found.serial_number,
        protocol_version=found.protocol_version,
        firmware_version=found.firmware_version,
    )


def _state(status: Status) -> BeltState:
    return BeltState(
        part_present=bool(status.flags & ConveyorFlag.PART),
        moving=bool(status.flags & ConveyorFlag.MOVING),
        indexes=status.value,
    )
