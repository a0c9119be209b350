"""The firmware's reader of lines: it takes what is a command, and nothing else.

What is a command is decided by the host's codec, which shares no code with it.
"""

from __future__ import annotations

import random
import re
import subprocess
from pathlib import Path

import pytest

from cellctl.boards.constants import COMMAND_LIMIT
from cellctl.boards.line import (
    CommandLine,
    LineError,
    LineSplitter,
    decode_command,
    encode_command,
)

LETTERS = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
SHORT_FRAMES = 256 * len(LETTERS)
"""Sequence numbers times letters: every frame without an argument."""


def read(lines: Path, stream: bytes) -> tuple[list[CommandLine], int]:
    """The commands that the firmware finds in a stream, and how many lines it dropped."""
    done = subprocess.run([lines, "read"], input=stream, capture_output=True, check=True)
    *found, last = done.stdout.decode("ascii").splitlines()
    commands = []
    for line in found:
        sequence, letter, argument = line.split()
        commands.append(
            CommandLine(int(sequence), letter, int(argument) if argument != "-1" else None)
        )
    return commands, int(last.removeprefix("damaged "))


def expected(stream: bytes) -> list[CommandLine]:
    """The same by the host's codec."""
    commands = []
    for frame in LineSplitter((b">",), COMMAND_LIMIT).feed(stream):
        try:
            commands.append(decode_command(frame))
        except LineError:
            continue
    return commands


def random_command(rng: random.Random) -> bytes:
    argument = rng.randrange(0x10000) if rng.random() < 0.5 else None
    return encode_command(CommandLine(rng.randrange(256), rng.choice(LETTERS), argument))


def garble(rng: random.Random, frame: bytes) -> bytes:
    """Damage a frame in one of the ways in which lines get damaged."""
    data = bytearray(frame)
    place = rng.randrange(len(data))
    match rng.randrange(6):
        case 0:
            data[place] ^= 1 << rng.randrange(8)
        case 1:
            del data[place]
        case 2:
            data.insert(place, rng.randrange(256))
        case 3:
            del data[place:]
        case 4:
            data[place] = ord(rng.choice("0123456789ABCDEFabcdef *>\n"))
        case _:
            data[place:place] = data[:place]
    return bytes(data)


def fuzz(seed: int, size: int) -> bytes:
    """Noise, digits and signs of the protocol, whole frames and damaged ones."""
    rng = random.Random(seed)  # noqa: S311 - repeatable chance
    stream = bytearray()
    while len(stream) < size:
        match rng.randrange(4):
            case 0:
                stream += rng.randbytes(rng.randrange(20))
            case 1:
                stream += bytes(rng.choices(b">0123456789ABCDEF *\n", k=rng.randrange(20)))
            case 2:
                stream += random_command(rng)
            case _:
                stream += garble(rng, random_command(rng))
    return bytes(stream[:size])


def check_fuzzed(lines: Path, seed: int, size: int) -> None:
    stream = fuzz(seed, size)
    found, damaged = read(lines, stream)
    assert found == expected(stream)
    assert len(found) > size / 100, "hardly anything was a command: this proves nothing"
    assert damaged > size / 100, "hardly anything was damaged: this proves nothing"


def test_a_million_fuzzed_bytes_give_no_false_command(lines: Path) -> None:
    check_fuzzed(lines, seed=1, size=1_000_000)


@pytest.mark.soak
def test_ten_million_fuzzed_bytes_give_no_false_command(lines: Path) -> None:
    for seed in range(2, 12):
        check_fuzzed(lines, seed, size=1_000_000)


@pytest.mark.parametrize(
    "stream",
    [
        b">00 S*66\n",  # a wrong checksum
        b">00 s*00\n",
        b">0 S*00\n",
        b"00 S*00\n",
        b">" * 40,
        b">00 F 03E8 03E8*00\n",
        b">00 F 03E8*00",
        b"\n\n\n",
        b"",
    ],
)
def test_what_is_no_command_is_dropped(lines: Path, stream: bytes) -> None:
    assert read(lines, stream)[0] == []


def test_a_command_is_found_behind_a_line_that_was_cut(lines: Path) -> None:
    whole = encode_command(CommandLine(7, "F", 1000))
    for cut in range(len(whole)):
        found, damaged = read(lines, whole[:cut] + whole)
        assert found == [CommandLine(7, "F", 1000)]
        assert damaged == (1 if cut else 0)


def flip(lines: Path, *, with_argument: bool, frames: int) -> None:
    done = subprocess.run(
        [lines, "flip", str(int(with_argument)), str(frames)],
        capture_output=True,
        check=True,
        text=True,
    )
    tried, missed, checksums = map(int, re.findall(r"\d+", done.stdout))
    bits = 8 * (14 if with_argument else 9)
    assert tried == frames * (bits + bits * (bits - 1) // 2)
    assert missed == 0
    assert checksums == 256


def test_every_error_of_one_or_two_bits_of_a_short_frame_is_detected(lines: Path) -> None:
    flip(lines, with_argument=False, frames=SHORT_FRAMES)


def test_every_error_of_one_or_two_bits_of_a_long_frame_is_detected(lines: Path) -> None:
    # Whether an error is seen depends on the checksum of the frame and on the error, not on the
    # rest of the frame: a CRC is linear. So frames with every checksum stand for all frames.
    flip(lines, with_argument=True, frames=2_000)


@pytest.mark.soak
def test_every_error_of_many_long_frames_is_detected(lines: Path) -> None:
    flip(lines, with_argument=True, frames=SHORT_FRAMES * 16)
