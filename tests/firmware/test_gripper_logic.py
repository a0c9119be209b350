"""The gripper's logic on the host, millisecond by millisecond."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from cellctl.boards.constants import (
    LATCH_PULSE_US,
    PULSE_MAX_US,
    PULSE_MIN_US,
    TRAVEL_MS,
    UNLATCH_PULSE_US,
    Command,
    ErrorCode,
    GripperFault,
    GripperFlag,
    Register,
    ReplyKind,
    ResetCause,
    SelfTest,
)
from cellctl.boards.line import (
    Banner,
    CommandLine,
    Reply,
    crc8,
    decode_reply,
    encode_command,
)
from tests.firmware.host_program import Change, HostProgram
from tests.firmware.noise import fuzz

GLITCH_MS = 4
DEBOUNCE_MS = 6
HALF_TOGGLE_MS = 100
GOOD_SUPPLY = 225
"""The reading of the 1.1 V reference at 5 V."""
LOW_SUPPLY = 310
"""At 3.6 V."""
CAUSES = list(ResetCause)


class GripperBoard:
    """The board, its pins and its line."""

    def __init__(self, program: HostProgram) -> None:
        self._program = program
        self._sequence = 0
        self.set("reference", GOOD_SUPPLY)
        self.start()
        self.tick(20)

    def start(self, cause: ResetCause = ResetCause.POWER) -> Banner:
        """Switch on, or reset; what the EEPROM holds is kept."""
        (sent,) = self._sent(self._program.do(f"start {CAUSES.index(cause)}"))
        banner = decode_reply(sent)
        assert isinstance(banner, Banner)
        return banner

    def set(self, name: str, value: int) -> None:
        """Set an input."""
        self._program.do(f"set {name} {value}")

    def tick(self, count: int) -> list[Change]:
        """Let milliseconds pass; nothing may be sent meanwhile."""
        return [Change.parse(line) for line in self._program.do(f"tick {count}")]

    def quietly(self, count: int) -> list[Change]:
        """Let milliseconds pass; what it may send meanwhile does not matter."""
        told = self._program.do(f"tick {count}")
        return [Change.parse(line) for line in told if not line.startswith("sent ")]

    def command(self, level: int, ticks: int = TRAVEL_MS + DEBOUNCE_MS) -> list[Change]:
        """Set the command line and let time pass."""
        self.set("command", level)
        return self.tick(ticks)

    def ask(self, letter: str, argument: int | None = None, sequence: int | None = None) -> Reply:
        """Send a command and take the answer."""
        if sequence is None:
            self._sequence = sequence = (self._sequence + 1) % 256
        line = encode_command(CommandLine(sequence, letter, argument))
        sent = self._sent(self._program.do(f"send {line.hex()}"))
        for _ in range(200):
            if sent:
                break
            sent = self._sent(self._program.do("tick 1"))
        (answer,) = sent
        reply = decode_reply(answer)
        assert isinstance(reply, Reply)
        assert reply.sequence == sequence
        return reply

    def send(self, data: bytes) -> list[bytes]:
        """Put bytes on the line; returns what is answered at once."""
        return self._sent(self._program.do(f"send {data.hex()}"))

    def flags(self) -> GripperFlag:
        """The flags of a status."""
        return GripperFlag(self._status(self.ask("S")))

    def register(self, register: Register) -> int:
        """The value of a register."""
        reply = self.ask("R", register)
        assert reply.status is not None
        return reply.status.value

    def poke(self, address: int, value: int) -> None:
        """Change a byte of the EEPROM."""
        self._program.do(f"poke {address} {value}")

    def writes(self) -> int:
        """How many bytes of the EEPROM were written."""
        return int(self._program.do("writes")[0].split()[1])

    @staticmethod
    def _status(reply: Reply) -> int:
        assert reply.status is not None
        return reply.status.flags

    @staticmethod
    def _sent(told: list[str]) -> list[bytes]:
        return [line.removeprefix("sent ").encode() for line in told if line.startswith("sent ")]


@pytest.fixture
def board(gripper_program: Path) -> Iterator[GripperBoard]:
    """A board that was just switched on, with an empty EEPROM and the command line low."""
    with HostProgram(gripper_program) as program:
        yield GripperBoard(program)


@pytest.fixture
def identified(board: GripperBoard) -> GripperBoard:
    """The same, identified."""
    assert board.ask("I").kind is ReplyKind.OK
    return board


def test_it_opens_and_closes_at_the_command_line_and_confirms_the_latch(
    board: GripperBoard,
) -> None:
    opened = board.command(1)
    assert [(change.status, change.pulse_us) for change in opened] == [
        (False, UNLATCH_PULSE_US),
        (False, 0),
    ]
    assert opened[1].time_ms - opened[0].time_ms == TRAVEL_MS
    closed = board.command(0)
    assert [(change.status, change.pulse_us) for change in closed] == [
        (False, LATCH_PULSE_US),
        (True, 0),
    ]
    assert closed[1].time_ms - closed[0].time_ms == TRAVEL_MS
    opened = board.command(1)
    assert [(change.status, change.pulse_us) for change in opened] == [
        (False, UNLATCH_PULSE_US),
        (False, 0),
    ]


@pytest.mark.parametrize("level", [0, 1])
def test_it_moves_nothing_at_boot_whatever_the_line_says(board: GripperBoard, level: int) -> None:
    board.set("command", level)
    board.start(ResetCause.BROWNOUT)
    assert board.tick(3000) == []


def test_a_glitch_at_boot_is_no_command(board: GripperBoard) -> None:
    board.start()
    for level in (1, 0, 1, 0):
        assert board.command(level, 3) == []
    assert board.tick(1000) == []


def test_a_glitch_of_the_command_line_moves_nothing(board: GripperBoard) -> None:
    for _ in range(20):
        assert board.command(1, GLITCH_MS) == []
        assert board.command(0, 2) == []
    assert board.tick(1000) == []


def test_a_confirmed_latch_stays_confirmed_through_a_glitch(board: GripperBoard) -> None:
    board.command(1)
    board.command(0)
    assert board.command(1, GLITCH_MS) == []
    assert board.command(0, 1000) == []


def test_a_change_during_travel_turns_back_and_takes_a_whole_travel(board: GripperBoard) -> None:
    board.command(1)
    board.command(0, 100)
    back = board.command(1)
    assert [(change.status, change.pulse_us) for change in back] == [
        (False, UNLATCH_PULSE_US),
        (False, 0),
    ]
    assert back[1].time_ms - back[0].time_ms == TRAVEL_MS


def test_a_reset_in_travel_leaves_the_servo_alone_and_confirms_nothing(
    board: GripperBoard,
) -> None:
    board.command(1)
    board.command(0, 100)
    assert board.start(ResetCause.WATCHDOG).cause is ResetCause.WATCHDOG
    assert board.tick(3000) == []
    assert [change.status for change in board.command(1)] == [False, False]
    assert board.command(0)[-1].status


def toggles(changes: list[Change]) -> list[int]:
    """Times between the changes of the status line."""
    return [later.time_ms - sooner.time_ms for sooner, later in pairwise(changes)]


def test_a_supply_that_falls_in_travel_is_a_fault_that_toggles(identified: GripperBoard) -> None:
    identified.command(1)
    identified.command(0, 100)
    identified.set("reference", LOW_SUPPLY)
    changes = identified.tick(2000)
    assert changes[0].pulse_us == 0
    assert set(toggles(changes)[1:]) == {HALF_TOGGLE_MS}
    assert len(changes) > 15
    assert identified.register(Register.FAULT) == GripperFault.SUPPLY
    assert GripperFlag.LATCHED in identified.flags()
    assert GripperFlag.CONFIRMED not in identified.flags()


def test_a_fault_is_cleared_by_a_command_of_the_host_which_moves_nothing(
    identified: GripperBoard,
) -> None:
    identified.set("reference", LOW_SUPPLY)
    identified.command(1)
    identified.set("reference", GOOD_SUPPLY)
    identified.tick(100)
    assert identified.ask("C").kind is ReplyKind.OK
    assert not any(change.pulse_us for change in identified.tick(1000))
    assert GripperFlag.LATCHED not in identified.flags()


def test_a_fault_is_left_behind_by_the_next_command_line_without_any_host(
    board: GripperBoard,
) -> None:
    board.command(1)
    board.set("reference", LOW_SUPPLY)
    board.command(0, 500)
    board.set("reference", GOOD_SUPPLY)
    board.tick(100)
    board.command(1)
    closed = board.command(0)
    assert (closed[-1].status, closed[-1].pulse_us) == (True, 0)


def test_a_low_supply_at_rest_is_told_by_the_self_test_only(identified: GripperBoard) -> None:
    identified.set("reference", LOW_SUPPLY)
    assert identified.tick(1000) == []
    reply = identified.ask("T")
    assert reply.status is not None
    assert SelfTest.SUPPLY in SelfTest(reply.status.value)


def test_a_short_dip_of_the_supply_is_ridden_out(board: GripperBoard) -> None:
    board.command(1)
    board.command(0, 50)
    board.set("reference", LOW_SUPPLY)
    board.tick(10)
    board.set("reference", GOOD_SUPPLY)
    assert board.tick(TRAVEL_MS)[-1].status


def test_no_line_moves_the_latch(identified: GripperBoard) -> None:
    for letter in "ABCDEFGHIJKLMNOPQRSTUVWXYZ":
        for argument in (None, 0, 1, 1000, 1500, 65535):
            identified.ask(letter, argument)
            assert identified.tick(500) == []


@pytest.mark.parametrize("seed", range(3))
def test_no_noise_on_the_line_moves_the_latch(identified: GripperBoard, seed: int) -> None:
    identified.command(1)
    identified.command(0)
    stream = fuzz(seed, 100_000)
    answers = 0
    for start in range(0, len(stream), 10_000):
        answers += len(identified.send(stream[start : start + 10_000]))
        assert [change for change in identified.quietly(500) if change.pulse_us] == []
    assert answers > 100, "hardly anything was a command: this proves nothing"


def test_before_it_is_identified_it_does_nothing_for_the_host(board: GripperBoard) -> None:
    for command in Command:
        if command is not Command.IDENTIFY:
            assert board.ask(command).error is ErrorCode.UNREADY
    identity = board.ask("I").identity
    assert identity is not None
    assert identity.role == "gripper"
    assert identity.serial_number == "A0A1A2A3A4A5A6A7A8A9"


def test_an_old_number_is_stale_and_a_repetition_is_answered(identified: GripperBoard) -> None:
    assert identified.ask("L", 1200, sequence=100).kind is ReplyKind.OK
    assert identified.ask("L", 1200, sequence=100).kind is ReplyKind.OK
    for behind in (1, 2, 128):
        old = (100 - behind) % 256
        assert identified.ask("L", 1300, sequence=old).error is ErrorCode.STALE
    assert identified.ask("R", Register.LATCH_PULSE, sequence=101).kind is ReplyKind.OK
    assert identified.ask("S", sequence=(101 + 127) % 256).kind is ReplyKind.OK


@pytest.mark.parametrize(
    ("letter", "register", "value", "wrong"),
    [
        ("L", Register.LATCH_PULSE, 1234, (PULSE_MIN_US - 1, PULSE_MAX_US + 1, 0, 65535)),
        ("U", Register.UNLATCH_PULSE, 1777, (PULSE_MIN_US - 1, PULSE_MAX_US + 1, 0, 65535)),
        ("D", Register.TRAVEL, 500, (99, 2001, 0, 65535)),
    ],
)
def test_a_calibration_is_checked_kept_and_outlives_power(
    identified: GripperBoard, letter: str, register: Register, value: int, wrong: tuple[int, ...]
) -> None:
    usual = identified.register(register)
    for refused in wrong:
        assert identified.ask(letter, refused).error is ErrorCode.ARGUMENT
    assert identified.ask(letter).error is ErrorCode.ARGUMENT
    assert identified.register(register) == usual
    reply = identified.ask(letter, value)
    assert reply.status is not None
    assert reply.status.value == value
    identified.start()
    identified.ask("I")
    assert identified.register(register) == usual, "what is not kept is forgotten"
    identified.ask(letter, value)
    assert identified.ask("K").kind is ReplyKind.OK
    identified.start()
    identified.ask("I")
    assert identified.register(register) == value
    assert GripperFlag.DEFAULT not in identified.flags()


def test_keeping_answers_when_it_is_done_and_writes_only_what_differs(
    identified: GripperBoard,
) -> None:
    identified.ask("L", 1100)
    assert identified.send(encode_command(CommandLine(90, "K"))) == []
    assert identified.ask("K", sequence=90).kind is ReplyKind.OK
    written = identified.writes()
    assert written == 8
    assert identified.ask("K", sequence=90).kind is ReplyKind.OK
    assert identified.ask("K", sequence=91).kind is ReplyKind.OK
    assert identified.writes() == written
    assert identified.ask("L", 1101, sequence=92).kind is ReplyKind.OK
    assert identified.ask("K", sequence=93).kind is ReplyKind.OK
    assert identified.writes() == written + 2, "the number's low byte and the check"


@pytest.mark.parametrize("address", range(8))
def test_a_damaged_record_falls_back_to_the_defaults_and_says_so(
    identified: GripperBoard, address: int
) -> None:
    identified.ask("L", 1100)
    identified.ask("D", 777)
    identified.ask("K")
    for bit in range(8):
        identified.start()
        identified.ask("I")
        assert identified.register(Register.LATCH_PULSE) == 1100
        kept = record_of(latch=1100, travel=777)
        identified.poke(address, kept[address] ^ 1 << bit)
        identified.start()
        identified.ask("I")
        assert identified.register(Register.LATCH_PULSE) == LATCH_PULSE_US
        assert identified.register(Register.TRAVEL) == TRAVEL_MS
        assert GripperFlag.DEFAULT in identified.flags()
        identified.tick(20)
        reply = identified.ask("T")
        assert reply.status is not None
        assert reply.status.value == SelfTest.RECORD
        identified.poke(address, kept[address])


def test_a_whole_record_of_another_layout_is_refused(identified: GripperBoard) -> None:
    for layout, kept in ((1, True), (0, False), (2, False), (255, False)):
        put(identified, record_of(latch=1100, travel=TRAVEL_MS, layout=layout))
        identified.start()
        identified.ask("I")
        assert (identified.register(Register.LATCH_PULSE) == 1100) is kept
        assert (GripperFlag.DEFAULT not in identified.flags()) is kept


def put(board: GripperBoard, record: bytes) -> None:
    """Write a record into the EEPROM."""
    for address, byte in enumerate(record):
        board.poke(address, byte)


def record_of(latch: int, travel: int, layout: int = 1) -> bytes:
    """The record as docs/firmware.md describes it, by code of the host's own."""
    numbers = (latch, UNLATCH_PULSE_US, travel)
    body = b"".join(number.to_bytes(2, "little") for number in numbers)
    body += bytes([layout])
    return body + bytes([crc8(body)])


@pytest.mark.parametrize("fill", [0x00, 0xFF])
def test_an_erased_eeprom_is_no_record(identified: GripperBoard, fill: int) -> None:
    for address in range(8):
        identified.poke(address, fill)
    identified.start()
    identified.ask("I")
    assert GripperFlag.DEFAULT in identified.flags()


def test_a_whole_record_with_numbers_out_of_range_is_refused(identified: GripperBoard) -> None:
    put(identified, record_of(latch=PULSE_MAX_US + 1, travel=TRAVEL_MS))
    identified.start()
    identified.ask("I")
    assert identified.register(Register.LATCH_PULSE) == LATCH_PULSE_US
    assert GripperFlag.DEFAULT in identified.flags()


def test_an_eeprom_that_keeps_nothing_is_a_fault(identified: GripperBoard) -> None:
    identified.set("eeprom_stuck", 1)
    assert identified.ask("K").error is ErrorCode.LATCHED
    assert identified.register(Register.FAULT) == GripperFault.STORE


def test_calibration_waits_for_the_latch(identified: GripperBoard) -> None:
    identified.command(1, 50)
    for letter, argument in (("L", 1200), ("U", 1200), ("D", 500), ("K", None)):
        assert identified.ask(letter, argument).error is ErrorCode.MOVING
    assert identified.flags() & GripperFlag.MOVING


def test_a_calibration_counts_from_the_next_movement(identified: GripperBoard) -> None:
    identified.ask("U", 2000)
    identified.ask("D", 150)
    opened = identified.command(1)
    assert [change.pulse_us for change in opened] == [2000, 0]
    assert opened[1].time_ms - opened[0].time_ms == 150


def test_counters_outlive_every_reset_but_power(identified: GripperBoard) -> None:
    identified.command(1)
    identified.command(0)
    for cause in (ResetCause.WATCHDOG, ResetCause.BROWNOUT, ResetCause.WATCHDOG):
        identified.start(cause)
        identified.ask("I")
    assert identified.register(Register.CYCLES) == 1
    assert identified.register(Register.WATCHDOG_RESETS) == 2
    assert identified.register(Register.BROWNOUT_RESETS) == 1
    identified.start()
    identified.ask("I")
    assert identified.register(Register.CYCLES) == 0
    assert identified.register(Register.WATCHDOG_RESETS) == 0


def test_the_supply_is_told_in_millivolts(identified: GripperBoard) -> None:
    for reading in range(20, 1024):
        identified.set("reference", reading)
        identified.tick(1)
        assert identified.register(Register.SUPPLY) == pytest.approx(
            1100 * 1023 / reading, abs=2 + 32 / reading
        ), reading


def test_flags_tell_part_command_and_confirmation(identified: GripperBoard) -> None:
    assert identified.flags() == GripperFlag.DEFAULT
    identified.set("part", 1)
    identified.command(1)
    assert identified.flags() == GripperFlag.DEFAULT | GripperFlag.PART | GripperFlag.TOLD_OPEN
    identified.command(0)
    assert identified.flags() == GripperFlag.DEFAULT | GripperFlag.PART | GripperFlag.CONFIRMED


def test_damaged_lines_are_counted(identified: GripperBoard) -> None:
    before = identified.register(Register.DAMAGED_LINES)
    identified.send(b">00 S*00\n>nonsense\n>")
    assert identified.register(Register.DAMAGED_LINES) == before + 3


def test_what_it_does_not_know_is_refused(identified: GripperBoard) -> None:
    for letter in "ABEGJMNOPQVWXYZFH":
        assert identified.ask(letter).error is ErrorCode.COMMAND
    for letter in "SCKTI":
        assert identified.ask(letter, 1).error is ErrorCode.ARGUMENT
    assert identified.ask("R", len(Register)).error is ErrorCode.ARGUMENT
    assert identified.ask("R").error is ErrorCode.ARGUMENT


def test_self_test_finds_a_status_line_that_is_held(identified: GripperBoard) -> None:
    identified.set("stuck", 1)
    identified.tick(1)
    reply = identified.ask("T")
    assert reply.status is not None
    assert SelfTest.STATUS_LINE in SelfTest(reply.status.value)
