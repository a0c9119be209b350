"""One board on one serial port: who it is, sessions with it, and single exchanges.

Every exchange repeats one line with one sequence number until it is answered, so that a lost
command or reply costs time and is never carried out twice. A board that was reset is noticed by its
banner, or because it asks to be identified; whoever uses it is told, and goes on or not.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Final

import structlog

from cellctl.boards.constants import (
    FIRMWARE_OLDEST,
    PROTOCOL_VERSION,
    BoardRole,
    Command,
    ErrorCode,
    ResetCause,
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
from cellctl.errors import CellctlError

log = structlog.get_logger(__name__)

SENDS: Final = 3
"""How often a line is sent before the board counts as lost."""
_SESSIONS: Final = 3
"""How often the board may start anew within one exchange before it counts as lost."""


class BoardLostError(CellctlError):
    """The port cannot be opened or has gone, or the board on it does not answer."""


class BoardMismatchError(CellctlError):
    """Another board is on the port, or one that this cellctl cannot run; says what to do."""


class BoardRefusedError(CellctlError):
    """The board did not do it.

    Args:
        code: why, in the protocol's word; None where its answer makes no sense.
    """

    def __init__(self, message: str, hint: str = "", code: ErrorCode | None = None) -> None:
        super().__init__(message, hint)
        self.code = code

    def __reduce__(self) -> tuple[object, ...]:
        return (type(self), (self.message, self.hint, self.code))


class ResetNoticed(Exception):  # noqa: N818 - an event on the wire, not a failure
    """The board was reset: it said so, or it asks to be identified."""


@dataclass(frozen=True, slots=True)
class BoardPort:
    """Where a board is, and what it must be."""

    role: BoardRole
    port: str
    baud: int
    reply_timeout_s: float
    """For one line's answer (wall time)."""
    serial_number: str | None
    """The only one that will do; None: any."""
    table: str
    """The table of cell.toml that says so, for messages."""


class Board:
    """A board on a serial port. Connects by itself when used, and again after a loss.

    One exchange at a time: whoever uses it from several tasks holds a lock meanwhile.

    Args:
        settings: where it is, and what it must be.
        on_reset: called when a reset was noticed, with its cause if the board told one.
    """

    def __init__(
        self, settings: BoardPort, on_reset: Callable[[ResetCause | None], None] = lambda _: None
    ) -> None:
        self._settings = settings
        self._on_reset = on_reset
        self._link: SerialLink | None = None
        self._sequence = 0
        self._met = False
        """It was identified before, so that one that is unready now was reset meanwhile."""
        self.identity: Identity | None = None
        """Who answers; None while nobody does."""
        self.status: Status | None = None
        """What it said last."""
        self.resets = 0
        """How many resets were noticed since it was first identified."""

    @property
    def is_open(self) -> bool:
        """Whether the port is open."""
        return self._link is not None

    async def connect(self) -> Identity:
        """Open the port if need be and see who answers; safe to repeat.

        Raises:
            BoardLostError: nobody does.
            BoardMismatchError: it is the wrong board, or a wrong version.
        """
        settings = self._settings
        found = await self.identify()
        try:
            check_identity(found, settings)
        except BoardMismatchError:
            self.drop()
            raise
        if self.identity is None:
            log.info(
                "board connected",
                port=settings.port,
                role=found.role,
                serial_number=found.serial_number,
                protocol_version=found.protocol_version,
                firmware_version=found.firmware_version,
            )
        self.identity, self._met = found, True
        return found

    async def identify(self) -> Identity:
        """Open the port if need be and see who answers, whoever it is.

        Raises:
            BoardLostError: nobody does.
        """
        settings = self._settings
        try:
            if self._link is None:
                self._link = await SerialLink.open(
                    settings.port, settings.baud, lambda banner: self._was_reset(banner.cause)
                )
                await self._notice_reset_meanwhile(self._link)
            return await self._identify(self._link)
        except LinkLostError as error:
            raise self.lost(str(error)) from error

    async def session(self) -> SerialLink:
        """The link, with a board behind it that was identified since it was opened.

        Raises:
            BoardLostError, BoardMismatchError: of ``connect``.
        """
        if self._link is None or self.identity is None:
            await self.connect()
        assert self._link is not None
        return self._link

    def drop(self) -> None:
        """Let go of the port; the next use opens it again."""
        if self._link is not None:
            self._link.close()
        self._link = self.identity = self.status = None

    def lost(self, detail: str) -> BoardLostError:
        """Let go of the port; returns the error that says why."""
        self.drop()
        return BoardLostError(detail)

    def silent(self, when: str = "") -> BoardLostError:
        """It does not answer: ``lost``, in words."""
        return self.lost(f"{self._settings.port}: no answer{when or f' to {SENDS} lines'}.")

    def frame(self, command: Command, argument: int | None = None) -> tuple[bytes, int]:
        """A line with the next sequence number, and that number."""
        self._sequence = next_sequence(self._sequence)
        return encode_command(CommandLine(self._sequence, command, argument)), self._sequence

    async def carry_out(self, command: Command, argument: int | None = None) -> Status:
        """Carry out a command that is safe to give anew after a reset.

        Raises:
            BoardLostError, BoardMismatchError: of ``connect``, or it fell silent.
            BoardRefusedError: it did not do it.
        """
        for _ in range(_SESSIONS):
            with suppress(ResetNoticed):
                reply = await self._ask(command, argument)
                if reply.status is not None:
                    return reply.status
                raise self.refused(command, reply)
        raise self.lost("It was reset again and again.")

    def refused(self, command: Command, reply: Reply) -> BoardRefusedError:
        """A reply that is not what the command asks for, as an error."""
        said = reply.error.value if reply.error is not None else reply.kind.value
        text = f"The {self._settings.role} board answered {command.name.lower()} with {said!r}."
        return BoardRefusedError(text, code=reply.error)

    async def reply_to(self, link: SerialLink, sequence: int) -> Reply:
        """Wait for the answer to the line with this number; bounded by the caller.

        Raises:
            ResetNoticed: it was reset meanwhile.
            LinkLostError: the port has gone.
        """
        while True:
            message = await link.receive()
            if isinstance(message, Banner):
                raise ResetNoticed
            if message.sequence != sequence:
                continue  # a late answer to a line that was given up, or answered twice
            if message.error is ErrorCode.UNREADY:
                if self.identity is not None:
                    self._was_reset(None)
                raise ResetNoticed
            if message.status is not None:
                self.status = message.status
            return message

    async def _ask(self, command: Command, argument: int | None) -> Reply:
        link = await self.session()
        try:
            return await self._exchange(link, command, argument)
        except LinkLostError as error:
            raise self.lost(str(error)) from error
        except TimeoutError:
            raise self.silent() from None

    async def _exchange(
        self, link: SerialLink, command: Command, argument: int | None = None
    ) -> Reply:
        """Send a line until it is answered, ``SENDS`` times; then ``TimeoutError``."""
        frame, sequence = self.frame(command, argument)
        for _ in range(SENDS):
            link.send(frame)
            with suppress(TimeoutError):
                async with asyncio.timeout(self._settings.reply_timeout_s):
                    return await self.reply_to(link, sequence)
        raise TimeoutError

    async def _identify(self, link: SerialLink) -> Identity:
        frame, sequence = self.frame(Command.IDENTIFY)
        for _ in range(SENDS):
            link.send(frame)
            with suppress(TimeoutError):
                async with asyncio.timeout(self._settings.reply_timeout_s):
                    while True:
                        with suppress(ResetNoticed):
                            reply = await self.reply_to(link, sequence)
                            if reply.identity is not None:
                                return reply.identity
        raise self.silent()

    async def _notice_reset_meanwhile(self, link: SerialLink) -> None:
        """Ask a board that was away before it is identified: one that was reset says unready."""
        if not self._met:
            return
        before = self.resets
        try:
            await self._exchange(link, Command.STATUS)
        except ResetNoticed:
            if self.resets == before:
                self._was_reset(None)
        except TimeoutError:
            raise self.silent() from None

    def _was_reset(self, cause: ResetCause | None) -> None:
        if not self._met:
            return  # it was switched on before anybody knew it
        log.warning(
            "a board was reset", board=self._settings.role, cause=cause.value if cause else ""
        )
        self.resets += 1
        self.identity = None
        self._on_reset(cause)


def check_identity(found: Identity, wanted: BoardPort) -> None:
    """See that the board is the one that belongs on its port.

    Raises:
        BoardMismatchError: it is not; with what to do.
    """
    port, table = wanted.port, wanted.table
    if found.role != wanted.role:
        raise BoardMismatchError(
            f"The board on {port} says it is a {found.role} (serial number {found.serial_number}), "
            f"not a {wanted.role}: {_swapped(found.role, table)}."
        )
    if found.protocol_version != PROTOCOL_VERSION:
        raise BoardMismatchError(
            f"The board on {port} (firmware {found.firmware_version}) speaks protocol version "
            f"{found.protocol_version}; this cellctl speaks version {PROTOCOL_VERSION}: "
            f"`make flash-{wanted.role}` installs the firmware that belongs to it."
        )
    oldest = FIRMWARE_OLDEST[wanted.role]
    if _version(found.firmware_version) < _version(oldest):
        raise BoardMismatchError(
            f"The board on {port} runs firmware {found.firmware_version}; this cellctl needs "
            f"{oldest} at least: `make flash-{wanted.role}` installs it."
        )
    if wanted.serial_number is not None and found.serial_number != wanted.serial_number:
        raise BoardMismatchError(
            f"The board on {port} has the serial number {found.serial_number}, and "
            f"{table}.serial_number asks for {wanted.serial_number}: plug in that board, or "
            "correct the option."
        )


def _swapped(role: str, table: str) -> str:
    other = {BoardRole.CONVEYOR: "feeder", BoardRole.GRIPPER: "gripper"}
    options = {str(name): f"{section}.port" for name, section in other.items()}
    if role in options:
        return f"{table}.port and {options[role]} are swapped, or the boards' plugs are"
    return f"correct {table}.port; `cellctl boards` lists the ports"


def _version(text: str) -> tuple[int, ...]:
    """Digits between dots; what is missing between two dots counts as nothing."""
    return tuple(int(part or 0) for part in text.split("."))
