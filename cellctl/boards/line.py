"""The line protocol between the host and the cell's boards: pure encoding and decoding.

Described for people in ``docs/serial-protocol.md``. One line is one frame::

    host to board     >1A F 03E8*49              number, command, argument, CRC
    board to host     <1A busy 02 002F*63        number, kind, fields, CRC
    unasked, at boot  !conveyor 02 watchdog*C0   role, protocol version, cause, CRC

A board must be able to run on a microcontroller with 256 bytes of memory: a command fits 16 bytes,
numbers are hexadecimal in capitals, and what a board has to remember is one sequence number and one
outcome. The start characters are different and occur nowhere else in a line, so that both ends find
the next line after any garbage, and a host on a single-wire link can tell its own echo.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from cellctl.boards.constants import (
    COMMAND_LIMIT,
    CRC_POLYNOMIAL,
    CRC_START,
    REPLY_LIMIT,
    SEQUENCE_COUNT,
    STALE_COUNT,
    ErrorCode,
    ReplyKind,
    ResetCause,
)

COMMAND_START: Final = b">"
REPLY_START: Final = b"<"
BANNER_START: Final = b"!"
END: Final = b"\n"


class LineError(ValueError):
    """A line that is no valid frame; it is dropped, and its sender tries again."""


@dataclass(frozen=True, slots=True)
class CommandLine:
    """From host to board."""

    sequence: int
    command: str
    """A letter; one that the board does not know is for it to refuse."""
    argument: int | None = None


@dataclass(frozen=True, slots=True)
class Status:
    """What a board says of itself; part of every ``ok`` and ``busy`` but identify's."""

    flags: int
    """Bits of ``ConveyorFlag`` or ``GripperFlag``."""
    value: int
    """What the command asks for; otherwise the board's counter."""


@dataclass(frozen=True, slots=True)
class Identity:
    """The answer to identify: who a board says it is."""

    role: str
    serial_number: str
    """1 to 20 capital hexadecimal digits; the microcontroller's own."""
    protocol_version: int
    firmware_version: str
    """Digits and dots."""


@dataclass(frozen=True, slots=True)
class Reply:
    """From board to host; ``sequence`` is that of the command."""

    sequence: int
    kind: ReplyKind
    status: Status | None = None
    identity: Identity | None = None
    error: ErrorCode | None = None


@dataclass(frozen=True, slots=True)
class Banner:
    """Sent by the board, unasked, when it has started."""

    role: str
    protocol_version: int
    cause: ResetCause


def crc8(data: bytes) -> int:
    """Checksum over everything between a line's start character and its ``*``."""
    crc = CRC_START
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1) ^ (CRC_POLYNOMIAL if crc & 0x80 else 0)
            crc &= 0xFF
    return crc


def next_sequence(sequence: int) -> int:
    """The number after this one."""
    return (sequence + 1) % SEQUENCE_COUNT


def is_stale(sequence: int, last: int) -> bool:
    """Whether a line with this number was sent before the one with the number ``last``."""
    return 1 <= (last - sequence) % SEQUENCE_COUNT <= STALE_COUNT


def encode_command(line: CommandLine) -> bytes:
    """A command as bytes, its end included.

    Raises:
        LineError: it does not fit the protocol.
    """
    argument = f" {_hex(line.argument, 4)}" if line.argument is not None else ""
    body = f"{_hex(line.sequence, 2)} {line.command}{argument}"
    return _frame(COMMAND_START, body, COMMAND_LIMIT, _COMMAND)


def encode_reply(reply: Reply) -> bytes:
    """A reply as bytes, its end included.

    Raises:
        LineError: it does not fit the protocol.
    """
    fields = [_hex(reply.sequence, 2), reply.kind.value]
    if reply.status is not None:
        fields += [_hex(reply.status.flags, 2), _hex(reply.status.value, 4)]
    if reply.identity is not None:
        identity = reply.identity
        fields += [
            identity.role,
            identity.serial_number,
            _hex(identity.protocol_version, 2),
            identity.firmware_version,
        ]
    if reply.error is not None:
        fields.append(reply.error.value)
    return _frame(REPLY_START, " ".join(fields), REPLY_LIMIT, _STATUS, _IDENTITY, _ERROR)


def encode_banner(banner: Banner) -> bytes:
    """A boot banner as bytes, its end included.

    Raises:
        LineError: it does not fit the protocol.
    """
    body = f"{banner.role} {_hex(banner.protocol_version, 2)} {banner.cause.value}"
    return _frame(BANNER_START, body, REPLY_LIMIT, _BANNER)


def decode_command(frame: bytes) -> CommandLine:
    """Read a command; its end may be left out.

    Raises:
        LineError: it is damaged or malformed. The letter and argument are not judged here.
    """
    found = _match(_body(frame, COMMAND_START, COMMAND_LIMIT), _COMMAND)
    argument = found["argument"]
    return CommandLine(
        int(found["sequence"], 16),
        found["command"],
        int(argument, 16) if argument is not None else None,
    )


def decode_reply(frame: bytes) -> Reply | Banner:
    """Read what a board sent; its end may be left out.

    Raises:
        LineError: it is damaged or malformed.
    """
    if frame.startswith(BANNER_START):
        found = _match(_body(frame, BANNER_START, REPLY_LIMIT), _BANNER)
        return Banner(found["role"], int(found["protocol"], 16), ResetCause(found["cause"]))
    found = _match(_body(frame, REPLY_START, REPLY_LIMIT), _STATUS, _IDENTITY, _ERROR)
    fields = found.groupdict()
    sequence, kind = int(found["sequence"], 16), ReplyKind(found["kind"])
    if "flags" in fields:
        status = Status(int(found["flags"], 16), int(found["value"], 16))
        return Reply(sequence, kind, status=status)
    if "role" in fields:
        identity = Identity(
            found["role"], found["serial"], int(found["protocol"], 16), found["firmware"]
        )
        return Reply(sequence, kind, identity=identity)
    return Reply(sequence, kind, error=ErrorCode(found["error"]))


class LineSplitter:
    """Cuts a stream of bytes into frames, and finds the next frame after any garbage.

    Args:
        starts: the start characters to look for; what stands before one is dropped.
        limit: longest frame; a longer one is dropped.
    """

    def __init__(self, starts: Iterable[bytes], limit: int) -> None:
        self._starts = frozenset(start[0] for start in starts)
        self._limit = limit
        self._frame: bytearray | None = None

    def feed(self, data: bytes) -> list[bytes]:
        """Take bytes as they come; returns the frames they complete, without their ends."""
        frames = []
        for byte in data:
            if byte in self._starts:
                self._frame = bytearray((byte,))
            elif self._frame is None:
                continue
            elif byte == END[0]:
                frames.append(bytes(self._frame))
                self._frame = None
            elif len(self._frame) + 1 >= self._limit:
                self._frame = None
            else:
                self._frame.append(byte)
        return frames


def _any_of(names: type[StrEnum]) -> str:
    return "|".join(re.escape(name.value) for name in names)


_SEQUENCE = r"(?P<sequence>[0-9A-F]{2})"
_ROLE = r"(?P<role>[a-z]{1,12}) "
_PROTOCOL = r"(?P<protocol>[0-9A-F]{2}) "
_COMMAND: Final = re.compile(_SEQUENCE + r" (?P<command>[A-Z])(?: (?P<argument>[0-9A-F]{4}))?")
_STATUS: Final = re.compile(
    _SEQUENCE + r" (?P<kind>ok|busy) (?P<flags>[0-9A-F]{2}) (?P<value>[0-9A-F]{4})"
)
_IDENTITY: Final = re.compile(
    _SEQUENCE
    + r" (?P<kind>ok) "
    + _ROLE
    + r"(?P<serial>[0-9A-F]{1,20}) "
    + _PROTOCOL
    + r"(?P<firmware>[0-9.]{1,12})"
)
_ERROR: Final = re.compile(_SEQUENCE + rf" (?P<kind>err) (?P<error>{_any_of(ErrorCode)})")
_BANNER: Final = re.compile(_ROLE + _PROTOCOL + rf"(?P<cause>{_any_of(ResetCause)})")


def _hex(number: int, digits: int) -> str:
    if not 0 <= number < 16**digits:
        raise LineError(f"{number} does not fit {digits} hexadecimal digits")
    return f"{number:0{digits}X}"


def _frame(start: bytes, body: str, limit: int, *patterns: re.Pattern[str]) -> bytes:
    _match(body, *patterns)
    data = body.encode("ascii")
    frame = start + data + b"*" + _hex(crc8(data), 2).encode("ascii") + END
    if len(frame) > limit:
        raise LineError(f"{frame!r} is longer than {limit} bytes")
    return frame


def _body(frame: bytes, start: bytes, limit: int) -> str:
    frame = frame.removesuffix(END)
    if len(frame) + len(END) > limit:
        raise LineError(f"{frame!r} is longer than {limit} bytes")
    body, star, checksum = frame.removeprefix(start).rpartition(b"*")
    if not frame.startswith(start) or not star:
        raise LineError(f"{frame!r} is not {start!r}...*CRC")
    if checksum != b"%02X" % crc8(body):
        raise LineError(f"{frame!r} has a wrong checksum")
    if not body.isascii():
        raise LineError(f"{frame!r} is not ASCII")
    return body.decode("ascii")


def _match(body: str, *patterns: re.Pattern[str]) -> re.Match[str]:
    for pattern in patterns:
        if found := pattern.fullmatch(body):
            return found
    raise LineError(f"{body!r} is no line of this protocol")
