"""The conveyor's logic on the host, with a motor that makes the steps and a part's edge."""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import pytest

from cellctl.boards.constants import (
    PITCH_MAX,
    PITCH_MIN,
    SILENCE_S,
    TRAVEL_LIMIT_PITCHES,
    Command,
    ConveyorFlag,
    ErrorCode,
    ReplyKind,
)
from cellctl.boards.line import CommandLine, Reply, decode_reply, encode_command
from tests.firmware.host_program import HostProgram
from tests.firmware.noise import fuzz

STEPS_PER_M = 40_000
STEPS_PER_UNIT = 4
PITCH = 1000
"""In the protocol's unit: 100 mm."""
PITCH_STEPS = PITCH * STEPS_PER_UNIT
SEAT_STEPS = 320
"""From the edge to rest: 8 mm."""
SENSOR_DELAY_STEPS = 20
"""What the belt moves at full speed, 4 steps a millisecond, until the sensor is believed."""
FAR = 10**9
TIMER_HZ = 5_000_000
POLL_MS = 50


@dataclass(frozen=True)
class Motor:
    """What the motor has done."""

    time_ms: int
    position: int
    steps: int
    shortest: int
    """Timer counts between the two steps that were closest to each other."""
    turning: bool


class ConveyorBoard:
    """The board, its belt and its line."""

    def __init__(self, program: HostProgram) -> None:
        self._program = program
        self._sequence = 0
        self.set("edge", FAR)
        self.tick(10)

    def set(self, name: str, value: int) -> None:
        """Set the part's edge, the stall, or whether the host is heard all the time."""
        self._program.do(f"set {name} {value}")

    def tick(self, count: int) -> None:
        """Let milliseconds pass."""
        self._program.do(f"tick {count}")

    def motor(self) -> Motor:
        """What the motor has done."""
        words = self._program.do("state")[0].split()
        time_ms, position, steps, shortest, turning = map(int, words[1::2])
        return Motor(time_ms, position, steps, shortest, turning == 1)

    def next(self) -> int:
        """The next sequence number."""
        self._sequence = (self._sequence + 1) % 256
        return self._sequence

    def ask(self, letter: str, argument: int | None = None, sequence: int | None = None) -> Reply:
        """Send a command and take the answer."""
        number = self.next() if sequence is None else sequence
        line = encode_command(CommandLine(number, letter, argument))
        (sent,) = self._program.do(f"send {line.hex()}")
        reply = decode_reply(sent.removeprefix("sent ").encode())
        assert isinstance(reply, Reply)
        assert reply.sequence == number
        return reply

    def noise(self, data: bytes) -> None:
        """Put anything on the line; what is answered does not matter."""
        self._program.do(f"send {data.hex()}")

    def index(self, letter: str, pitch: int = PITCH) -> Reply:
        """Begin an index and ask for its end as the host does."""
        number = self.next()
        reply = self.ask(letter, pitch, number)
        for _ in range(400):
            if reply.kind is not ReplyKind.BUSY:
                return reply
            self.tick(POLL_MS)
            reply = self.ask(letter, pitch, number)
        raise AssertionError("the index never ends")


@pytest.fixture
def fresh(conveyor_program: Path) -> Iterator[ConveyorBoard]:
    """A board that was just switched on, with no part in sight."""
    with HostProgram(conveyor_program) as program:
        yield ConveyorBoard(program)


@pytest.fixture
def board(fresh: ConveyorBoard) -> ConveyorBoard:
    """The same, identified."""
    assert fresh.ask("I").kind is ReplyKind.OK
    return fresh


def flags(reply: Reply) -> ConveyorFlag:
    assert reply.status is not None
    return ConveyorFlag(reply.status.flags)


def indexes(reply: Reply) -> int:
    assert reply.status is not None
    return reply.status.value


def test_forward_stops_a_little_behind_the_edge(board: ConveyorBoard) -> None:
    board.set("edge", 3000)
    reply = board.index("F")
    assert reply.kind is ReplyKind.OK
    assert flags(reply) == ConveyorFlag.PART
    assert indexes(reply) == 1
    assert 0 <= board.motor().position - 3000 - SEAT_STEPS <= SENSOR_DELAY_STEPS


def test_forward_is_done_at_once_where_a_part_is(board: ConveyorBoard) -> None:
    board.set("edge", 0)
    board.tick(10)
    reply = board.ask("F", PITCH)
    assert reply.kind is ReplyKind.OK
    assert indexes(reply) == 0
    board.tick(1000)
    assert board.motor().steps == 0


def halted_behind_the_edge(board: ConveyorBoard) -> None:
    """Bring a part, and halt the belt before it has pressed the part against the stop."""
    board.set("edge", 3000)
    assert board.ask("F", PITCH).kind is ReplyKind.BUSY
    for _ in range(4000):
        if board.motor().position > 3000 + SENSOR_DELAY_STEPS:
            break
        board.tick(1)
        if board.motor().steps % 50 == 0:
            board.ask("S")
    assert board.ask("H").kind is ReplyKind.OK
    board.tick(200)
    assert board.motor().position < 3000 + SEAT_STEPS


def test_forward_goes_on_with_a_part_that_was_left_short_of_the_stop(board: ConveyorBoard) -> None:
    halted_behind_the_edge(board)
    before = board.motor().position
    reply = board.index("F")
    assert reply.kind is ReplyKind.OK
    assert indexes(reply) == 1
    assert before + SEAT_STEPS <= board.motor().position <= before + SEAT_STEPS + 400
    assert board.motor().position >= 3000 + SEAT_STEPS
    # Now it is there.
    at = board.motor().position
    assert indexes(board.index("F")) == 1
    assert board.motor().position == at


def test_a_part_that_comes_when_another_left_short_is_gone_counts_as_there(
    board: ConveyorBoard,
) -> None:
    halted_behind_the_edge(board)
    board.set("edge", FAR)
    board.tick(10)
    board.set("edge", 0)
    board.tick(10)
    at = board.motor().position
    assert board.ask("F", PITCH).kind is ReplyKind.OK
    assert board.motor().position == at


@pytest.mark.parametrize("pitch", [PITCH_MIN, PITCH, PITCH_MAX])
def test_nothing_came_is_found_after_the_travel_limit(board: ConveyorBoard, pitch: int) -> None:
    assert board.index("F", pitch).error is ErrorCode.NO_EDGE
    assert board.motor().position == pitch * STEPS_PER_UNIT * TRAVEL_LIMIT_PITCHES
    assert board.ask("F", pitch).error is ErrorCode.LATCHED
    assert ConveyorFlag.LATCHED in flags(board.ask("S"))
    assert board.ask("C").kind is ReplyKind.OK
    assert board.ask("F", pitch).kind is ReplyKind.BUSY


@pytest.mark.parametrize("pitch", [PITCH_MIN, 333, PITCH, PITCH_MAX])
def test_backward_goes_one_pitch_exactly(board: ConveyorBoard, pitch: int) -> None:
    board.set("edge", 0)
    board.tick(10)
    for count in range(1, 6):
        assert board.index("B", pitch).kind is ReplyKind.OK
        assert board.motor().position == -count * pitch * STEPS_PER_UNIT


def test_a_part_that_stays_where_it_is_did_not_move(board: ConveyorBoard) -> None:
    board.set("edge", -FAR)
    board.tick(10)
    assert board.index("B").error is ErrorCode.NO_MOTION
    assert ConveyorFlag.LATCHED in flags(board.ask("S"))


def test_a_stall_stops_at_once_and_is_latched(board: ConveyorBoard) -> None:
    number = board.next()
    board.ask("F", PITCH, number)
    board.tick(150)
    board.set("stall", 1)
    board.tick(4)
    stopped = board.motor()
    assert not stopped.turning
    assert board.ask("F", PITCH, number).error is ErrorCode.NO_MOTION
    assert board.ask("F", PITCH).error is ErrorCode.LATCHED


def test_the_belt_stops_when_the_host_falls_silent(board: ConveyorBoard) -> None:
    number = board.next()
    board.ask("F", PITCH_MAX, number)
    board.tick(190)
    board.ask("F", PITCH_MAX, number)
    heard = board.motor().time_ms
    board.tick(int(SILENCE_S * 1000) - 1)
    turning = board.motor()
    assert turning.turning
    while board.motor().turning:
        board.tick(1)
    assert SILENCE_S * 1000 < board.motor().time_ms - heard <= 245
    assert board.ask("F", PITCH_MAX, number).error is ErrorCode.SILENCE
    assert board.ask("F", PITCH).kind is ReplyKind.BUSY, "silence latches nothing"


def test_every_valid_line_counts_as_the_host_heard(board: ConveyorBoard) -> None:
    board.ask("F", PITCH_MAX)
    for _ in range(20):
        board.tick(190)
        assert ConveyorFlag.MOVING in flags(board.ask("S"))


def test_a_repeated_line_moves_nothing_a_second_time(board: ConveyorBoard) -> None:
    board.set("edge", 3000)
    number = board.next()
    while board.ask("F", PITCH, number).kind is ReplyKind.BUSY:
        board.tick(20)
    stopped = board.motor()
    board.set("edge", FAR)  # the part was taken
    for _ in range(50):
        board.tick(20)
        assert board.ask("F", PITCH, number).kind is ReplyKind.OK
    assert board.motor().steps == stopped.steps


def test_old_numbers_move_nothing(board: ConveyorBoard) -> None:
    board.ask("I", sequence=130)
    for behind in (1, 64, 128):
        assert board.ask("F", PITCH, 130 - behind).error is ErrorCode.STALE
    board.tick(500)
    assert board.motor().steps == 0


def test_nothing_moves_before_the_board_is_identified(fresh: ConveyorBoard) -> None:
    for letter in "SFBHC":
        argument = PITCH if letter in "FB" else None
        assert fresh.ask(letter, argument).error is ErrorCode.UNREADY
    fresh.tick(500)
    assert fresh.motor().steps == 0


@pytest.mark.parametrize("seed", range(3))
def test_no_noise_on_the_line_moves_the_belt(fresh: ConveyorBoard, seed: int) -> None:
    stream = fuzz(seed, 100_000)
    # Whole frames are among the noise. Those that identify the board or ask for an index are
    # spoilt.
    harmless = re.sub(rb"I(?=\*)|[FB](?= )", b"S", stream)
    for start in range(0, len(harmless), 10_000):
        fresh.noise(harmless[start : start + 10_000])
        fresh.tick(500)
    assert fresh.motor().steps == 0
    fresh.ask("I")
    assert fresh.index("F").error is ErrorCode.NO_EDGE, "it still works"


def test_a_halt_brakes_and_the_next_index_begins_from_rest(board: ConveyorBoard) -> None:
    number = board.next()
    board.ask("F", PITCH_MAX, number)
    board.tick(150)
    assert board.ask("H").kind is ReplyKind.OK
    braking = board.motor()
    assert braking.turning
    assert board.ask("B", PITCH).kind is ReplyKind.BUSY
    board.tick(60)
    assert board.motor().shortest >= TIMER_HZ / 4000 - 5
    board.set("heard", 1)
    board.tick(2000)
    assert board.motor().position == pytest.approx(braking.position + 80 - PITCH_STEPS, abs=2)


@pytest.mark.parametrize("letter", ["F", "B"])
@pytest.mark.parametrize("after_ms", [0, 1, 2, 3, 4, 5, 10, 20])
def test_a_halt_at_the_very_beginning_stops_it_too(
    board: ConveyorBoard, letter: str, after_ms: int
) -> None:
    board.ask(letter, PITCH)
    board.tick(after_ms)
    begun = board.motor().steps
    assert board.ask("H").kind is ReplyKind.OK
    board.tick(200)
    assert not board.motor().turning
    assert board.motor().steps <= max(1, 2 * begun)


def test_a_halt_tells_the_index_that_it_ended(board: ConveyorBoard) -> None:
    board.ask("F", PITCH, 9)
    board.tick(100)
    board.ask("I", sequence=9)
    board.tick(100)
    assert not board.motor().turning


def test_another_index_is_refused_while_one_runs(board: ConveyorBoard) -> None:
    board.ask("F", PITCH)
    board.tick(50)
    assert board.ask("F", PITCH).error is ErrorCode.MOVING
    assert board.ask("B", PITCH).error is ErrorCode.MOVING


def test_a_pitch_must_be_in_range(board: ConveyorBoard) -> None:
    for pitch in (None, 0, PITCH_MIN - 1, PITCH_MAX + 1, 65535):
        assert board.ask("F", pitch).error is ErrorCode.ARGUMENT
        assert board.ask("B", pitch).error is ErrorCode.ARGUMENT
    for letter in "SHCI":
        assert board.ask(letter, PITCH).error is ErrorCode.ARGUMENT
    known = {Command.FORWARD, Command.BACKWARD, *map(Command, "ISHC")}
    for letter in set("ABCDEFGHIJKLMNOPQRSTUVWXYZ") - {command.value for command in known}:
        assert board.ask(letter).error is ErrorCode.COMMAND


def test_a_speck_before_the_sensor_is_no_part(board: ConveyorBoard) -> None:
    board.ask("F", PITCH_MAX)
    board.set("heard", 1)
    board.tick(500)
    board.set("edge", 0)
    board.tick(2)
    board.set("edge", FAR)
    board.tick(100)
    assert board.motor().turning


def test_the_ramp_keeps_speed_and_acceleration(board: ConveyorBoard) -> None:
    board.set("heard", 1)
    board.ask("B", PITCH)
    positions = [board.motor().position]
    while not positions[1:] or board.motor().turning:
        board.tick(1)
        positions.append(board.motor().position)
    steps_per_ms = [earlier - later for earlier, later in pairwise(positions)]
    assert max(steps_per_ms) <= 5
    speed = [sum(steps_per_ms[at : at + 10]) / 10 for at in range(len(steps_per_ms) - 10)]
    assert max(speed) == pytest.approx(4.0, rel=0.01), "100 mm/s are 4 steps a millisecond"
    # 2.5 m/s2 are 0.1 steps/ms a millisecond; a mean over 10 ms is only as fine as its steps.
    assert max(abs(later - now) for now, later in zip(speed, speed[10:], strict=False)) <= 1.0 + 0.2
    assert board.motor().position == -PITCH_STEPS


def test_errors_do_not_add_up_over_a_thousand_indexes_with_slip_and_drift(
    board: ConveyorBoard,
) -> None:
    rng = random.Random(5)  # noqa: S311 - repeatable chance
    board.set("heard", 1)
    for count in range(1, 1001):
        start = board.motor().position
        slip, drift = rng.uniform(0.0, 0.03), rng.uniform(0.0, 0.005)
        edge = start + round(PITCH_STEPS * (1 + slip) + drift * STEPS_PER_M)
        board.set("edge", edge)
        number = board.next()
        board.ask("F", PITCH, number)
        board.tick(1300)
        reply = board.ask("F", PITCH, number)
        assert reply.kind is ReplyKind.OK
        assert indexes(reply) == count
        assert 0 <= board.motor().position - edge - SEAT_STEPS <= SENSOR_DELAY_STEPS
        board.set("edge", FAR)  # the part was taken
        board.tick(10)
