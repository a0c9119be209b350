"""The line protocol between the host and the conveyor's board: pure encoding and decoding.

Described for people in ``docs/serial-protocol.md``. One line is one frame::

    host to board     >1A F 03E8*49              number, command, argument, CRC
    board to host     <1A busy 02 002F*63        number, kind, fields, CRC
    unasked, at boot  !conveyor 01 watchdog*FD   role, protocol version, cause, CRC

The board must be able to run on a microcontroller with 256 bytes of memory: a command fits 16
bytes, numbers are hexadecimal in capitals, and what the board has to remember is one sequence
number and one outcome. The start characters are different and occur nowhere else in a line, so that
both ends find the next line after any garbage, and a host on a single-wire link can tell its own
echo.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntFlag, StrEnum
from typing import Final

PROTOCOL_VERSION: Final = 1
ROLE: Final = "conveyor"
"""What the conveyor's board calls itself; 1 to 12 letters of a to z."""

COMMAND_START: Final = b">"
REPLY_START: Final = b"<"
BANNER_START: Final = b"!"
END: Final = b"\n"
COMMAND_LIMIT: Final = 16
"""Longest command in bytes, start and end included."""
REPLY_LIMIT: Final = 64
"""Longest reply or banner in bytes, start and end included."""

SEQUENCE_COUNT: Final = 256
STALE_COUNT: Final = 128
"""A number that is 1 to this many behind the last one is an old line, late on its way."""
INDEX_COUNT: Final = 0x10000
"""The counter of indexes starts over at this."""

CRC_POLYNOMIAL: Final = 0x65
"""x^8 + x^6 + x^5 + x^2 + 1. With the two checksum digits in hexadecimal it still detects every
1- and 2-bit error of a line of up to 16 bytes, which the more common 0x07 does not."""
CRC_START: Final = 0x00

PITCH_UNIT_M: Final = 0.0001
"""The argument of an index command is the pitch from part to part in this unit."""
PITCH_MIN: Final = 200
PITCH_MAX: Final = 2500

SILENCE_S: Final = 0.20
"""A moving belt stops when the board has not had a valid line for this long."""
POLL_S: Final = 0.05
"""How often the host repeats the line of an index under way: its way to ask, and its sign of
life."""
TRAVEL_LIMIT_PITCHES: Final = 2.5
"""How far an index forward moves at most; bridges the place of one part that is missing."""


class Command(StrEnum):
    """What the host may ask."""

    IDENTIFY = "I"
    """Who are you? Starts a session: the belt halts, and the board forgets the last outcome."""
    STATUS = "S"
    FORWARD = "F"
    """Move forward until the sensor sees a part's edge; argument: the pitch. Done at once when a
    part is there."""
    BACKWARD = "B"
    """Take a part back: move one pitch backward; argument: the pitch."""
    HALT = "H"
    """Stop where it is."""
    CLEAR = "C"
    """Forget the latched error."""


MOTIONS: Final = frozenset({Command.FORWARD, Command.BACKWARD})


class ReplyKind(StrEnum):
    """How a reply begins, after its sequence number."""

    OK = "ok"
    BUSY = "busy"
    """The motion with this number is under way; repeat the line to hear its outcome."""
    ERROR = "err"


class ErrorCode(StrEnum):
    """Why the board did not do it."""

    NO_EDGE = "no_edge"
    """Latched. The drive turned as far as it may and the sensor saw no part's edge. Whether the
    belt is empty or jammed the board cannot know."""
    NO_MOTION = "no_motion"
    """Latched. The motor driver reports a stall, or the part that was to be taken back is still
    at the sensor."""
    SILENCE = "silence"
    """The host was not heard for ``SILENCE_S``; the belt stopped by itself."""
    HALTED = "halted"
    """A halt ended the motion."""
    MOVING = "moving"
    """Another motion is under way."""
    LATCHED = "latched"
    """An error is latched; clear it first."""
    UNREADY = "unready"
    """The board was reset; identify first."""
    STALE = "stale"
    """The sequence number is an old one."""
    COMMAND = "command"
    """There is no such command."""
    ARGUMENT = "argument"
    """The argument is missing, malformed or out of range."""


LATCHING: Final = frozenset({ErrorCode.NO_EDGE, ErrorCode.NO_MOTION})


class Flag(IntFlag):
    """The flags of a status, sent as two digits."""

    PART = 0x01
    """The sensor sees a part."""
    MOVING = 0x02
    LATCHED = 0x04
    """An error is latched."""


class ResetCause(StrEnum):
    """Why the board started, in its banner."""

    POWER = "power"
    BROWNOUT = "brownout"
    EXTERNAL = "external"
    WATCHDOG = "watchdog"
    SOFTWARE = "software"
    PROGRAMMER = "programmer"


class LineError(ValueError):
    """A line that is no valid frame; it is dropped, and its sender tries again."""


@dataclass(frozen=True, slots=True)
class CommandLine:
    """From host to board."""

    sequence: int
    command: str
    """A letter; one that ``Command`` does not know is for the board to refuse."""
    argument: int | None = None


@dataclass(frozen=True, slots=True)
class Status:
    """What the board knows of its belt; part of every ``ok`` and ``busy`` but identify's."""

    flags: Flag
    indexes: int
    """Parts brought to the pick station since power-on, modulo ``INDEX_COUNT``."""


@dataclass(frozen=True, slots=True)
class Identity:
    """The answer to identify."""

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
        fields += [_hex(reply.status.flags, 2), _hex(reply.status.indexes, 4)]
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
        status = Status(Flag(int(found["flags"], 16)), int(found["indexes"], 16))
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
    _SEQUENCE + r" (?P<kind>ok|busy) (?P<flags>0[0-7]) (?P<indexes>[0-9A-F]{4})"
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
