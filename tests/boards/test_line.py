"""The line codec: what is sent is what is read, and what is damaged is never read."""

from __future__ import annotations

import itertools
import random
import re
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cellctl.boards import line
from cellctl.boards.constants import (
    COMMAND_LIMIT,
    CRC_POLYNOMIAL,
    MOTIONS,
    REPLY_LIMIT,
    SEQUENCE_COUNT,
    SETTINGS,
    STALE_COUNT,
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
    Status,
    crc8,
    decode_command,
    decode_reply,
    encode_banner,
    encode_command,
    encode_reply,
    is_stale,
    next_sequence,
)

bytes2 = st.integers(0, 0xFF)
bytes4 = st.integers(0, 0xFFFF)
commands = st.builds(
    CommandLine, bytes2, st.sampled_from([c.value for c in Command]), st.none() | bytes4
)
statuses = st.builds(Status, bytes2, bytes4)
roles = st.text("abcxyz", min_size=1, max_size=12)
identities = st.builds(
    Identity,
    roles,
    st.text("0123456789ABCDEF", min_size=1, max_size=20),
    bytes2,
    st.text("0123456789.", min_size=1, max_size=12),
)
replies = st.one_of(
    st.builds(Reply, bytes2, st.sampled_from([ReplyKind.OK, ReplyKind.BUSY]), status=statuses),
    st.builds(Reply, bytes2, st.just(ReplyKind.OK), identity=identities),
    st.builds(Reply, bytes2, st.just(ReplyKind.ERR), error=st.sampled_from(ErrorCode)),
)
banners = st.builds(Banner, roles, bytes2, st.sampled_from(ResetCause))


@given(commands)
def test_a_command_is_read_as_it_was_written(command: CommandLine) -> None:
    frame = encode_command(command)
    assert len(frame) <= COMMAND_LIMIT
    assert decode_command(frame) == command


@given(replies | banners)
def test_what_a_board_says_is_read_as_it_was_written(message: Reply | Banner) -> None:
    frame = encode_reply(message) if isinstance(message, Reply) else encode_banner(message)
    assert len(frame) <= REPLY_LIMIT
    assert decode_reply(frame) == message


@given(st.binary(max_size=100))
def test_garbage_is_refused_and_nothing_else_happens(data: bytes) -> None:
    for frame in (data, COMMAND_START + data, b"<" + data, b"!" + data):
        for decode in (decode_command, decode_reply):
            with pytest.raises(LineError):
                decode(frame)


@given(st.lists(commands, max_size=5), st.data())
def test_frames_are_found_in_garbage_however_the_stream_is_cut(
    sent: list[CommandLine], data: st.DataObject
) -> None:
    noise = st.binary(max_size=40).map(lambda junk: junk.replace(COMMAND_START, b""))
    stream = b"".join(data.draw(noise) + encode_command(command) for command in sent)
    splitter = LineSplitter((COMMAND_START,), COMMAND_LIMIT)
    frames: list[bytes] = []
    while stream:
        length = data.draw(st.integers(1, len(stream)))
        frames += splitter.feed(stream[:length])
        stream = stream[length:]
    assert [decode_command(frame) for frame in frames] == sent


def test_a_line_without_an_end_is_dropped_at_the_limit_and_the_next_is_found() -> None:
    splitter = LineSplitter((COMMAND_START,), COMMAND_LIMIT)
    good = encode_command(CommandLine(1, Command.STATUS))
    assert splitter.feed(COMMAND_START + b"A" * 1000 + b"\n") == []
    assert splitter.feed(COMMAND_START + b"01 S" + good) == [good.rstrip()]


@pytest.mark.parametrize(
    "command",
    [
        CommandLine(256, "S"),
        CommandLine(-1, "S"),
        CommandLine(0, "f"),
        CommandLine(0, "FF"),
        CommandLine(0, "F", 0x10000),
        CommandLine(0, "F", -1),
    ],
)
def test_what_does_not_fit_the_protocol_is_not_sent(command: CommandLine) -> None:
    with pytest.raises(LineError):
        encode_command(command)


def test_a_reply_that_would_be_too_long_is_not_sent() -> None:
    with pytest.raises(LineError):
        encode_reply(Reply(0, ReplyKind.OK, identity=Identity("a" * 13, "0", 1, "1")))


def test_the_checksum_is_the_published_one() -> None:
    # Division of the message by the polynomial, bit by bit, as arithmetic on whole numbers.
    def remainder(data: bytes) -> int:
        number = int.from_bytes(data) << 8
        divisor = 0x100 | CRC_POLYNOMIAL
        while number.bit_length() > 8:
            number ^= divisor << (number.bit_length() - 9)
        return number

    chance = random.Random(1)  # noqa: S311 - repeatable chance
    for length in range(30):
        data = chance.randbytes(length)
        assert crc8(data) == remainder(data)


def damaged(frame: bytes, bits: int) -> Iterator[bytes]:
    for places in itertools.combinations(range(len(frame) * 8), bits):
        copy = bytearray(frame)
        for place in places:
            copy[place // 8] ^= 1 << place % 8
        yield bytes(copy)


def understood(stream: bytes) -> list[CommandLine]:
    found = []
    for frame in LineSplitter((COMMAND_START,), COMMAND_LIMIT).feed(stream):
        try:
            found.append(decode_command(frame))
        except LineError:
            continue
    return found


SAMPLE = [
    *(CommandLine(sequence, Command.FORWARD, 1000) for sequence in (0x00, 0x4A, 0xFF)),
    *(CommandLine(sequence, Command.HALT) for sequence in (0x1B, 0xC3)),
    CommandLine(0x55, Command.LATCH_PULSE, 1500),
]


@pytest.mark.parametrize("bits", [1, 2])
def test_no_command_with_one_or_two_flipped_bits_is_understood(bits: int) -> None:
    for command in SAMPLE:
        for stream in damaged(encode_command(command), bits):
            assert understood(stream) == [], stream


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_no_command_at_all_with_one_or_two_flipped_bits_is_understood() -> None:
    for sequence in range(SEQUENCE_COUNT):
        for command in Command:
            takes = command in MOTIONS | SETTINGS or command is Command.READ
            argument = 1000 if takes else None
            frame = encode_command(CommandLine(sequence, command, argument))
            for bits in (1, 2):
                for stream in damaged(frame, bits):
                    assert understood(stream) == [], stream


@given(bytes2, st.integers(0, SEQUENCE_COUNT - 1))
def test_stale_numbers_are_those_behind(last: int, ahead: int) -> None:
    number = last
    for _ in range(ahead):
        number = next_sequence(number)
    assert is_stale(number, last) == (ahead >= SEQUENCE_COUNT - STALE_COUNT)


def test_the_codes_docstring_shows_valid_lines() -> None:
    found = re.findall(r"[><!][0-9A-Za-z][0-9A-Za-z. ]*\*[0-9A-F]{2}", line.__doc__ or "")
    assert len(found) == 3
    for example in found:
        frame = example.encode()
        decode = decode_command if frame.startswith(COMMAND_START) else decode_reply
        decode(frame)
