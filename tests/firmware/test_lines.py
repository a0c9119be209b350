"""The firmware's reader of lines: it takes what is a command, and nothing else.

What is a command is decided by the host's codec, which shares no code with it.
"""

from __future__ import annotations

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
from tests.firmware.noise import LETTERS, fuzz

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
