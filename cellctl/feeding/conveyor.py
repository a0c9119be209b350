"""The conveyor, over its serial port: the product's implementation of ``Belt``.

Every exchange repeats one line with one sequence number until it is answered, so that a lost
command or reply costs time and never a second advance. An index under way is asked for by repeating
its line; these repetitions are also the sign of life without which the board stops the belt.
"""

from __future__ import annotations

import asyncio
from contextlib import suppress
from typing import Final

import structlog

from cellctl.boards.constants import (
    PITCH_UNIT_M,
    POLL_S,
    PROTOCOL_VERSION,
    BoardRole,
    Command,
    ConveyorFlag,
    ErrorCode,
    ReplyKind,
)
from cellctl.boards.line import (
    Banner,
    CommandLine,
    Identity,
    Reply,
    Status,
    encode_command,
    next_sequence,
)
from cellctl.boards.link import LinkLostError, SerialLink
from cellctl.clock import Clock
from cellctl.config import FeederSection
from cellctl.errors import CellFault
from cellctl.feeding.belt import BeltIdentity, BeltState

log = structlog.get_logger(__name__)

SENDS: Final = 3
"""How often a line is sent before the board counts as lost."""
_SESSIONS: Final = 3
"""How often the board may start anew within one exchange before it counts as lost."""


class _ResetNoticed(Exception):  # noqa: N818 - an event on the wire, not a failure
    """The board was reset: it said so, or it asks to be identified."""


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
        self._link: SerialLink | None = None
        self._identity: BeltIdentity | None = None
        self._sequence = 0
        self._busy = asyncio.Lock()
        """Held for one exchange; an index is one exchange."""
        self._index: asyncio.Task[object] | None = None
        """The task that is in ``present``, whether it waits for ``_busy`` or holds it."""
        self._status: Status | None = None
        self.resets = 0
        """How many resets of the board were noticed since this object was made."""

    async def connect(self) -> BeltIdentity:
        async with self._busy:
            return await self._connect()

    async def state(self) -> BeltState:
        if self._index is not None and self._status is not None:
            return _state(self._status)
        async with self._busy:
            return _state(await self._status_of(Command.STATUS))

    async def present(self) -> None:
        assert self._index is None, "one index at a time"
        self._index = asyncio.current_task()
        try:
            async with self._busy:
                await self._present()
        finally:
            self._index = None

    async def halt(self) -> None:
        if self._index is not None:
            self._index.cancel()
        async with self._busy:
            # Without a link there is nobody to tell: a board that hears nothing stops by itself.
            if self._link is not None:
                await self._status_of(Command.HALT)

    async def close(self) -> None:
        if self._index is not None:
            with suppress(CellFault):
                await self.halt()
        async with self._busy:
            self._drop()

    # --- sessions -----------------------------------------------------------------------------

    async def _connect(self) -> BeltIdentity:
        port = self._settings.port
        try:
            if self._link is None:
                self._link = await SerialLink.open(port, self._settings.baud)
            found = await self._identify(self._link)
        except LinkLostError as error:
            raise self._lost(str(error)) from error
        if found.role != BoardRole.CONVEYOR:
            self._drop()
            raise CellFault(
                "belt_mismatch",
                f"The board on {port} says it is a {found.role} "
                f"(serial number {found.serial_number}), not a {BoardRole.CONVEYOR}.",
            )
        if found.protocol_version != PROTOCOL_VERSION:
            self._drop()
            raise CellFault(
                "belt_mismatch",
                f"The board on {port} (firmware {found.firmware_version}) speaks protocol version "
                f"{found.protocol_version}; this cellctl speaks version {PROTOCOL_VERSION}.",
            )
        self._identity = BeltIdentity(
            role=found.role,
            serial_number=found.serial_number,
            protocol_version=found.protocol_version,
            firmware_version=found.firmware_version,
        )
        log.info("conveyor connected", port=port, **self._identity.model_dump())
        return self._identity

    async def _identify(self, link: SerialLink) -> Identity:
        frame, sequence = self._frame(Command.IDENTIFY)
        for _ in range(SENDS):
            link.send(frame)
            with suppress(TimeoutError):
                async with asyncio.timeout(self._settings.reply_timeout_s):
                    while True:
                        with suppress(_ResetNoticed):
                            reply = await self._reply_to(link, sequence)
                            if reply.identity is not None:
                                return reply.identity
        raise self._lost(f"{self._settings.port}: no answer to {SENDS} lines.")

    async def _session(self) -> SerialLink:
        """The link, with a board behind it that was identified since it was opened."""
        if self._link is None or self._identity is None:
            await self._connect()
        assert self._link is not None
        return self._link

    def _drop(self) -> None:
        if self._link is not None:
            self._link.close()
        self._link = self._identity = self._status = None

    def _lost(self, detail: str) -> CellFault:
        self._drop()
        return CellFault("belt_lost", detail)

    # --- exchanges ----------------------------------------------------------------------------

    def _frame(self, command: Command, argument: int | None = None) -> tuple[bytes, int]:
        self._sequence = next_sequence(self._sequence)
        return encode_command(CommandLine(self._sequence, command, argument)), self._sequence

    async def _reply_to(self, link: SerialLink, sequence: int) -> Reply:
        while True:
            message = await link.receive()
            if isinstance(message, Banner):
                log.warning("the conveyor's board was reset", cause=message.cause)
                self.resets += 1
                self._identity = None
                raise _ResetNoticed
            if message.sequence != sequence:
                continue  # a late answer to a line that was given up, or answered twice
            if message.error is ErrorCode.UNREADY:
                if self._identity is not None:
                    log.warning("the conveyor's board was reset", cause="unknown")
                    self.resets += 1
                    self._identity = None
                raise _ResetNoticed
            if message.status is not None:
                self._status = message.status
            return message

    async def _status_of(self, command: Command) -> Status:
        """Carry out a command that moves nothing; its answer is a status."""
        for _ in range(_SESSIONS):
            with suppress(_ResetNoticed):
                reply = await self._ask(command)
                if reply.status is not None:
                    return reply.status
                raise self._refused(command, reply)
        raise self._lost("It was reset again and again.")

    async def _ask(self, command: Command) -> Reply:
        link = await self._session()
        frame, sequence = self._frame(command)
        try:
            for _ in range(SENDS):
                link.send(frame)
                with suppress(TimeoutError):
                    async with asyncio.timeout(self._settings.reply_timeout_s):
                        return await self._reply_to(link, sequence)
        except LinkLostError as error:
            raise self._lost(str(error)) from error
        raise self._lost(f"{self._settings.port}: no answer to {SENDS} lines.")

    # --- indexing -----------------------------------------------------------------------------

    async def _present(self) -> None:
        deadline_s = self._clock.now_s() + self._settings.index_timeout_s
        code, trouble = "belt_jam", "the belt is still moving"
        while True:
            try:
                reply = await self._move(Command.FORWARD, deadline_s)
            except _ResetNoticed:
                # The part may lie anywhere up to the sensor: going on forward is right.
                code, trouble = "belt_lost", "the board was reset again and again"
                continue
            if reply is None:
                await self._status_of(Command.HALT)
                raise CellFault(code, f"After {self._settings.index_timeout_s:g} s {trouble}.")
            match reply.error:
                case None:
                    return
                case ErrorCode.NO_EDGE:
                    raise CellFault("belt_empty", "The belt ran and no part came to the sensor.")
                case ErrorCode.NO_MOTION:
                    raise CellFault("belt_jam", "The belt's motor was stalled.")
                case ErrorCode.LATCHED:
                    await self._status_of(Command.CLEAR)
                case ErrorCode.SILENCE | ErrorCode.MOVING | ErrorCode.STALE:
                    log.info("index interrupted, going on", reason=reply.error.value)
                    code, trouble = "belt_lost", f"the board still says {reply.error.value}"
                case _:
                    raise self._refused(Command.FORWARD, reply)

    async def _move(self, command: Command, deadline_s: float) -> Reply | None:
        """Repeat a motion's line until its outcome is known; None when the deadline passes."""
        link = await self._session()
        loop = asyncio.get_running_loop()
        frame, sequence = self._frame(command, self._pitch)
        heard_s = loop.time()
        try:
            while self._clock.now_s() < deadline_s:
                link.send(frame)
                with suppress(TimeoutError):
                    async with self._clock.timeout(POLL_S):
                        while True:
                            reply = await self._reply_to(link, sequence)
                            heard_s = loop.time()
                            if reply.kind is not ReplyKind.BUSY:
                                return reply
                if loop.time() - heard_s > SENDS * self._settings.reply_timeout_s:
                    raise self._lost(f"{self._settings.port}: no answer in the middle of an index.")
        except LinkLostError as error:
            raise self._lost(str(error)) from error
        except asyncio.CancelledError:
            # A newer number also makes the board refuse repetitions of the index on their way.
            with suppress(LinkLostError):
                link.send(self._frame(Command.HALT)[0])
            raise
        return None

    def _refused(self, command: Command, reply: Reply) -> CellFault:
        said = reply.error.value if reply.error is not None else reply.kind.value
        return CellFault(
            "belt_mismatch", f"Its board answered {command.name.lower()} with {said!r}."
        )


def _state(status: Status) -> BeltState:
    return BeltState(
        part_present=bool(status.flags & ConveyorFlag.PART),
        moving=bool(status.flags & ConveyorFlag.MOVING),
        indexes=status.value,
    )
