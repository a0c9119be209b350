"""The emulated board by itself: the rules of the protocol, line by line, in exact cell time."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from cellctl.boards.constants import (
    PITCH_MIN,
    PROTOCOL_VERSION,
    REPLY_LIMIT,
    SILENCE_S,
    TRAVEL_LIMIT_PITCHES,
    Command,
    ConveyorFlag,
    ErrorCode,
    ReplyKind,
    ResetCause,
)
from cellctl.boards.line import (
    BANNER_START,
    REPLY_START,
    Banner,
    CommandLine,
    LineSplitter,
    Reply,
    decode_reply,
    encode_command,
)
from cellctl.errors import UsageError
from cellctl.sim.conveyor import BELT_SPEED_M_S, ConveyorEmulator
from cellctl.sim.conveyor_faults import FAULTS
from tests.feeding.bench import PITCH_M, PartsOnBelt, cell_config

PITCH = 1000
TICK_S = 0.005


class Board:
    """The emulator, and a host's end of the port that speaks raw lines."""

    def __init__(self, folder: Path, parts: int) -> None:
        self.port = folder / "deep" / "cell" / "conveyor"
        self.world = PartsOnBelt(parts)
        self.emulator = ConveyorEmulator(self.world, cell_config(self.port))
        self.emulator.start()
        self._descriptor = os.open(self.port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self._splitter = LineSplitter((REPLY_START, BANNER_START), REPLY_LIMIT)

    def close(self) -> None:
        os.close(self._descriptor)
        self.emulator.stop()

    def write(self, data: bytes) -> None:
        os.write(self._descriptor, data)

    def heard(self) -> list[Reply | Banner]:
        try:
            data = os.read(self._descriptor, 4096)
        except BlockingIOError:
            return []
        return [decode_reply(frame) for frame in self._splitter.feed(data)]

    def ask(self, sequence: int, command: str, argument: int | None = None) -> Reply:
        self.write(encode_command(CommandLine(sequence, command, argument)))
        self.emulator.advance(0.0)
        (reply,) = self.heard()
        assert isinstance(reply, Reply)
        assert reply.sequence == sequence
        return reply

    def finish(self, sequence: int, command: str = Command.FORWARD) -> Reply:
        """Repeat an index's line until its outcome is known."""
        for _ in range(1_000):
            reply = self.ask(sequence, command, PITCH)
            if reply.kind is not ReplyKind.BUSY:
                return reply
            self.emulator.advance(TICK_S)
        raise AssertionError("the index never ends")


@contextmanager
def switched_on(parts: int = 5) -> Iterator[Board]:
    """A board that has just been switched on; its banner is still on the line."""
    with tempfile.TemporaryDirectory() as folder:
        board = Board(Path(folder), parts)
        try:
            yield board
        finally:
            board.close()
        assert list(Path(folder).iterdir()) == []


@contextmanager
def identified(parts: int = 5) -> Iterator[Board]:
    """A board in a session; the newest sequence number is 0."""
    with switched_on(parts) as board:
        board.heard()
        assert board.ask(0, Command.IDENTIFY).identity is not None
        yield board


def test_the_banner_tells_why_the_board_started() -> None:
    with switched_on() as board:
        assert board.heard() == [Banner("conveyor", PROTOCOL_VERSION, ResetCause.POWER)]
        board.emulator.inject("reset", cause="watchdog")
        assert board.heard() == [Banner("conveyor", PROTOCOL_VERSION, ResetCause.WATCHDOG)]


def test_nothing_moves_before_the_board_is_identified() -> None:
    with switched_on() as board:
        board.heard()
        for command in "SFBHC":
            assert board.ask(7, command, None).error is ErrorCode.UNREADY
        board.emulator.advance(1.0)
        assert board.world.travel_m == 0.0


def test_a_repeated_number_tells_the_outcome_again_and_moves_nothing() -> None:
    with identified() as board:
        outcome = board.finish(1)
        assert outcome.status is not None
        assert outcome.status.flags == ConveyorFlag.PART
        assert outcome.status.value == 1
        board.world.take()
        for _ in range(5):
            assert board.ask(1, Command.FORWARD, PITCH) == outcome
            board.emulator.advance(0.1)
        assert board.world.travel_m == pytest.approx(PITCH_M, abs=0.002)


def test_an_old_number_is_refused() -> None:
    with identified() as board:
        board.finish(1)
        board.world.take()
        board.ask(2, Command.STATUS)
        assert board.ask(1, Command.FORWARD, PITCH).error is ErrorCode.STALE
        assert board.ask(2 - 128 + 256, Command.FORWARD, PITCH).error is ErrorCode.STALE
        assert board.emulator.truth().motions == 1


def test_numbers_start_over() -> None:
    with identified() as board:
        for sequence in range(1, 600):
            assert board.ask(sequence % 256, Command.STATUS).kind is ReplyKind.OK
        assert board.finish(600 % 256).kind is ReplyKind.OK


def test_a_halted_index_is_not_begun_again_by_a_late_repetition() -> None:
    with identified() as board:
        assert board.ask(1, Command.FORWARD, PITCH).kind is ReplyKind.BUSY
        board.emulator.advance(0.1)
        halted = board.ask(2, Command.HALT)
        assert halted.status is not None
        assert not halted.status.flags & ConveyorFlag.MOVING
        travel_m = board.world.travel_m
        assert board.ask(1, Command.FORWARD, PITCH).error is ErrorCode.STALE
        board.emulator.advance(0.1)
        assert board.world.travel_m == travel_m


def test_one_index_at_a_time() -> None:
    with identified() as board:
        board.ask(1, Command.FORWARD, PITCH)
        assert board.ask(2, Command.FORWARD, PITCH).error is ErrorCode.MOVING
        assert board.emulator.truth().motions == 1


def test_the_belt_stops_when_its_host_falls_silent() -> None:
    with identified() as board:
        board.ask(1, Command.FORWARD, PITCH)
        board.emulator.advance(0.9 * SILENCE_S)
        assert board.emulator.truth().moving
        for _ in range(40):
            board.emulator.advance(TICK_S)
        assert not board.emulator.truth().moving
        assert board.world.travel_m <= SILENCE_S * BELT_SPEED_M_S
        assert board.ask(1, Command.FORWARD, PITCH).error is ErrorCode.SILENCE
        assert board.finish(2).kind is ReplyKind.OK


def test_damaged_lines_are_no_sign_of_life() -> None:
    with identified() as board:
        board.ask(1, Command.FORWARD, PITCH)
        for _ in range(100):
            board.write(b">01 F 03E8*00\n\xff\x00>>")
            board.emulator.advance(TICK_S)
        assert not board.emulator.truth().moving
        assert board.heard() == []


def test_nothing_came_stays_latched_until_it_is_cleared() -> None:
    with identified(parts=0) as board:
        assert board.finish(1).error is ErrorCode.NO_EDGE
        assert board.world.travel_m == pytest.approx(TRAVEL_LIMIT_PITCHES * PITCH_M, abs=0.002)
        status = board.ask(2, Command.STATUS).status
        assert status is not None
        assert status.flags == ConveyorFlag.LATCHED
        assert board.ask(3, Command.FORWARD, PITCH).error is ErrorCode.LATCHED
        assert board.ask(4, Command.CLEAR).kind is ReplyKind.OK
        assert board.ask(5, Command.FORWARD, PITCH).kind is ReplyKind.BUSY


def test_a_part_is_taken_back_by_one_pitch() -> None:
    with identified(parts=2) as board:
        board.finish(1)
        outcome = board.finish(2, Command.BACKWARD)
        assert outcome.kind is ReplyKind.OK
        assert outcome.status is not None
        assert outcome.status.flags == ConveyorFlag(0)
        assert board.world.travel_m == pytest.approx(0.0, abs=0.002)


def test_a_part_that_does_not_leave_the_sensor_did_not_move() -> None:
    with identified() as board:
        board.finish(1)
        board.emulator.inject("jam")
        assert board.finish(2, Command.BACKWARD).error is ErrorCode.NO_MOTION


@pytest.mark.parametrize(
    ("command", "argument", "error"),
    [
        (Command.FORWARD, None, ErrorCode.ARGUMENT),
        (Command.FORWARD, PITCH_MIN - 1, ErrorCode.ARGUMENT),
        (Command.BACKWARD, 0xFFFF, ErrorCode.ARGUMENT),
        (Command.STATUS, 1, ErrorCode.ARGUMENT),
        ("X", None, ErrorCode.COMMAND),
    ],
)
def test_what_cannot_be_done_is_refused(
    command: str, argument: int | None, error: ErrorCode
) -> None:
    with identified() as board:
        assert board.ask(1, command, argument).error is error
        assert board.emulator.truth().motions == 0


@pytest.mark.parametrize("reads", [True, False])
def test_a_blocked_sensor_reads_the_same_whatever_is_there(reads: bool) -> None:
    with identified() as board:
        board.emulator.inject("sensor_blocked", reads=reads)
        outcome = board.finish(1)
        assert outcome.error is (None if reads else ErrorCode.NO_EDGE)
        assert (board.world.travel_m == 0.0) == reads


def test_a_new_session_stops_the_belt_and_forgets_the_last_outcome() -> None:
    with identified() as board:
        board.ask(9, Command.FORWARD, PITCH)
        board.emulator.advance(0.1)
        assert board.ask(9, Command.IDENTIFY).identity is not None
        assert not board.emulator.truth().moving
        assert board.finish(10).kind is ReplyKind.OK


@pytest.mark.parametrize(
    ("fault", "arguments", "said"),
    [
        ("no_such_fault", {}, "lost_replies"),
        ("lost_replies", {"count": 0}, "count"),
        ("jam", {"count": 1}, "count"),
        ("reset", {"cause": "boredom"}, "cause"),
    ],
)
def test_a_wrong_injection_is_refused(fault: str, arguments: dict[str, Any], said: str) -> None:
    with identified() as board, pytest.raises(UsageError, match=said):
        board.emulator.inject(fault, **arguments)


def test_every_fault_can_be_injected_and_cleared() -> None:
    with identified() as board:
        for fault in FAULTS:
            board.emulator.inject(fault)
            board.emulator.clear(fault)
            assert board.emulator.truth().faults == ()


def test_a_stale_link_is_replaced_and_a_file_is_not(tmp_path: Path) -> None:
    port = tmp_path / "conveyor"
    port.symlink_to("/dev/pts/gone")
    emulator = ConveyorEmulator(PartsOnBelt(1), cell_config(port))
    emulator.start()
    assert port.exists()
    emulator.stop()
    emulator.stop()
    assert not port.is_symlink()
    port.write_text("precious")
    with pytest.raises(UsageError, match="in the way"):
        emulator.start()
    assert port.read_text() == "precious"
