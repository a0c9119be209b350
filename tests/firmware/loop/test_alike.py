"""The plain emulators and the compiled programs do the same, as far as anybody can tell."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import pytest

from cellctl.assembly import Cell
from cellctl.boards.constants import (
    FIRMWARE_VERSION,
    PITCH_MAX,
    PITCH_MIN,
    PROTOCOL_VERSION,
    PULSE_MAX_US,
    SILENCE_S,
    TRAVEL_LIMIT_PITCHES,
    BoardRole,
    Command,
    ConveyorFlag,
    ErrorCode,
    GripperFlag,
    Register,
    ReplyKind,
    ResetCause,
)
from cellctl.boards.line import Banner, CommandLine, Reply, encode_command
from cellctl.sim.latch import LatchFault
from cellctl.sim.world_values import Where
from tests.firmware.loop.bench import BOOT_S, PITCH, STEP_S, Bench, conveyor, gripper

KINDS = ("plain", "elf")


@pytest.fixture(params=KINDS)
def grip(request: pytest.FixtureRequest) -> Iterator[Bench]:
    """A gripper's board, with nothing in its latch."""
    with gripper(request.param) as bench:
        yield bench


@pytest.fixture(params=KINDS)
def belt(request: pytest.FixtureRequest) -> Iterator[Bench]:
    """A conveyor's board in a session, and a full belt."""
    with conveyor(request.param) as bench:
        yield bench


def reboots(bench: Bench) -> list[Reply | Banner]:
    """What is heard while a board starts."""
    bench.advance(BOOT_S + 0.3)  # a watchdog takes a quarter of a second
    return bench.host.heard()


def test_the_latch_from_boot_to_a_placed_part(grip: Bench) -> None:
    grip.command(False)
    assert not any(grip.levels(0.5))
    assert grip.latch.truth()["latched"]
    grip.command(True)
    assert not any(grip.levels(0.5))
    assert not grip.latch.truth()["latched"]
    grip.command(False)
    assert grip.until_status(True) == pytest.approx(0.355, abs=0.01)
    assert all(grip.levels(0.2))
    grip.hand.place(0, 0, 0)
    assert grip.world.counts()[Where.PLACED] == 1
    assert grip.hand.kinds() == []


def test_status_falls_once_the_latch_is_told_to_open(grip: Bench) -> None:
    grip.hand.pick()
    assert grip.status
    grip.command(True)
    assert grip.until_status(False) <= 0.02
    assert grip.world.held_part is not None
    grip.advance(0.4)
    assert grip.world.held_part is None


def test_its_switch_feels_the_part_that_the_latch_has_hold_of(grip: Bench) -> None:
    grip.host.identify()
    numbers = itertools.count(1)

    def felt() -> bool:
        grip.advance(0.02)  # until its switch is believed
        told = grip.host.ask(next(numbers), Command.STATUS).status
        assert told is not None
        return GripperFlag.PART in GripperFlag(told.flags)

    grip.hand.pick()
    assert felt()
    grip.hand.carry(0, 0, 0)
    grip.hand.open()
    assert not felt()
    grip.hand.close()  # on the part that stands
    assert felt()
    grip.hand.open()
    grip.world.take_placed_part(Cell(0, 0, 0))
    grip.hand.close()
    assert not felt()


def test_a_silent_gripper_moves_all_the_same(grip: Bench) -> None:
    grip.hand.pick()
    grip.latch.inject(LatchFault.SILENT)
    grip.hand.open()
    assert grip.world.held_part is None
    grip.hand.close()
    assert not grip.status
    grip.latch.clear(LatchFault.SILENT)
    assert grip.status


def test_a_fault_toggles_the_status_and_keeps_the_part(grip: Bench) -> None:
    grip.hand.pick()
    grip.latch.inject(LatchFault.FAULT)
    grip.command(True)
    grip.advance(0.2)
    levels = grip.levels(2.0)
    edges = sum(a != b for a, b in itertools.pairwise(levels))
    assert edges == pytest.approx(20, abs=1)
    assert grip.world.held_part is not None
    grip.latch.clear(LatchFault.FAULT)
    grip.command(False)
    grip.advance(0.5)
    grip.command(True)
    grip.advance(0.5)
    assert grip.world.held_part is None


def test_a_glitch_of_the_command_line_moves_nothing(grip: Bench) -> None:
    grip.hand.pick()
    grip.plant.glitch(0.004)
    grip.advance(0.002)
    grip.advance(0.002)
    assert all(grip.levels(0.5))
    assert grip.world.held_part is not None
    grip.plant.glitch(0.02)
    assert not all(grip.levels(0.5))


@pytest.mark.parametrize("cause", [ResetCause.POWER, ResetCause.BROWNOUT, ResetCause.WATCHDOG])
def test_a_reset_keeps_the_part_and_is_told(grip: Bench, cause: ResetCause) -> None:
    grip.host.identify()
    grip.hand.pick()
    grip.host.heard()
    grip.gripper.reset(cause)
    assert Banner(BoardRole.GRIPPER, PROTOCOL_VERSION, cause) in reboots(grip)
    assert not any(grip.levels(0.5))
    grip.command(False)  # the level it had all along
    assert not any(grip.levels(0.5))
    assert grip.world.held_part is not None
    assert grip.host.ask(1, Command.STATUS).error is ErrorCode.UNREADY
    grip.hand.open()
    grip.hand.close()
    assert grip.status


def test_losing_power_while_opening_keeps_the_part(grip: Bench) -> None:
    grip.hand.pick()
    grip.command(True)
    grip.advance(0.1)
    grip.gripper.reset(ResetCause.POWER)
    grip.advance(1.0)
    assert grip.world.held_part is not None


def test_the_gripper_tells_and_is_calibrated(grip: Bench) -> None:
    reply = grip.host.ask(7, Command.IDENTIFY)
    assert reply.identity is not None
    assert reply.identity.role == BoardRole.GRIPPER
    assert reply.identity.firmware_version == FIRMWARE_VERSION[BoardRole.GRIPPER]
    assert len(reply.identity.serial_number) == 20
    grip.hand.close()
    grip.command(True)
    grip.advance(0.05)
    moving = grip.host.ask(8, Command.STATUS).status
    assert moving is not None
    assert moving.flags == GripperFlag.MOVING | GripperFlag.TOLD_OPEN
    refused = grip.host.ask(9, Command.TRAVEL, 200)
    assert refused.error is ErrorCode.MOVING
    grip.hand.open()
    assert grip.host.ask(10, Command.TRAVEL, 200).kind is ReplyKind.OK
    assert grip.host.ask(11, Command.LATCH_PULSE, PULSE_MAX_US + 1).error is ErrorCode.ARGUMENT
    assert grip.host.ask(12, Command.HALT).error is ErrorCode.COMMAND
    grip.command(False)
    assert grip.until_status(True) == pytest.approx(0.205, abs=0.01)
    kept = grip.host.ask(13, Command.KEEP)
    while kept.kind is ReplyKind.BUSY:
        kept = grip.host.ask(13, Command.KEEP)
    assert kept.status is not None
    assert kept.status.flags & ~GripperFlag.PART == GripperFlag.CONFIRMED
    grip.gripper.reset(ResetCause.POWER)
    reboots(grip)
    grip.host.identify()
    travel = grip.host.ask(1, Command.READ, Register.TRAVEL)
    assert travel.status is not None
    assert travel.status.value == 200


def test_a_damaged_store_falls_back_to_the_defaults_and_says_so(grip: Bench) -> None:
    grip.host.identify()
    grip.host.ask(1, Command.TRAVEL, 200)
    while grip.host.ask(2, Command.KEEP).kind is ReplyKind.BUSY:
        pass
    grip.gripper.inject("store_damaged")
    grip.gripper.reset(ResetCause.POWER)
    reboots(grip)
    grip.host.identify()
    travel = grip.host.ask(1, Command.READ, Register.TRAVEL).status
    assert travel is not None
    assert travel.value == 350
    assert travel.flags & GripperFlag.DEFAULT


def test_pulling_the_serial_cable_never_moves_the_latch(grip: Bench) -> None:
    grip.hand.pick()
    grip.gripper.inject("unplugged")
    assert all(grip.levels(0.5))
    grip.hand.open()
    grip.hand.pick()
    assert grip.world.held_part is not None


def test_parts_come_one_after_another(belt: Bench) -> None:
    for number in range(1, 4):
        outcome = belt.host.finish(number)
        assert outcome.status is not None
        assert outcome.status.flags == ConveyorFlag.PART
        assert outcome.status.value == number
        assert belt.world.counts()[Where.PICK_STATION] == 1
        belt.world.remove_next_part()
        belt.advance(0.02)
    truth = belt.conveyor.truth()
    assert (truth.indexes, truth.motions, truth.moving) == (3, 3, False)


def test_a_repeated_number_tells_the_outcome_again_and_moves_nothing(belt: Bench) -> None:
    outcome = belt.host.finish(1)
    belt.world.remove_next_part()
    travel_m = belt.conveyor.truth().travel_m
    for _ in range(3):
        again = belt.host.ask(1, Command.FORWARD, PITCH)
        assert again.kind is ReplyKind.OK
        belt.advance(0.1)
    assert outcome.status is not None
    assert belt.conveyor.truth().travel_m == travel_m


def test_what_cannot_be_done_is_refused(belt: Bench) -> None:
    ask = belt.host.ask
    for argument in (None, PITCH_MIN - 1, PITCH_MAX + 1):
        assert ask(1, Command.FORWARD, argument).error is ErrorCode.ARGUMENT
    assert ask(2, Command.SELF_TEST).error is ErrorCode.COMMAND
    assert ask(3, Command.STATUS, 1).error is ErrorCode.ARGUMENT
    assert ask(2, Command.STATUS).error is ErrorCode.STALE
    assert ask(4, Command.FORWARD, PITCH).kind is ReplyKind.BUSY
    assert ask(5, Command.FORWARD, PITCH).error is ErrorCode.MOVING
    assert belt.conveyor.truth().motions == 1


def test_a_halt_ends_the_index_for_good(belt: Bench) -> None:
    assert belt.host.ask(1, Command.FORWARD, PITCH).kind is ReplyKind.BUSY
    belt.advance(0.1)
    assert belt.host.ask(2, Command.HALT).kind is ReplyKind.OK
    belt.advance(0.1)
    travel_m = belt.conveyor.truth().travel_m
    assert belt.host.ask(1, Command.FORWARD, PITCH).error is ErrorCode.STALE
    belt.advance(0.1)
    assert belt.conveyor.truth().travel_m == travel_m
    assert belt.host.finish(3).kind is ReplyKind.OK


@pytest.mark.parametrize("command", [Command.FORWARD, Command.BACKWARD])
def test_a_halt_right_behind_its_index_lets_nothing_move(belt: Bench, command: Command) -> None:
    lines = (CommandLine(1, command, PITCH), CommandLine(2, Command.HALT))
    belt.host.write(b"".join(map(encode_command, lines)))
    belt.advance(0.5)
    truth = belt.conveyor.truth()
    assert not truth.moving
    assert truth.travel_m <= 0.0001
    assert belt.host.finish(3).kind is ReplyKind.OK


def test_a_silent_host_stops_the_belt_in_time(belt: Bench) -> None:
    asked_s = moved_s = belt.time_s
    travel_m = 0.0
    belt.host.ask(1, Command.FORWARD, PITCH)
    while belt.conveyor.truth().moving:
        belt.advance(STEP_S)
        if belt.conveyor.truth().travel_m != travel_m:
            travel_m, moved_s = belt.conveyor.truth().travel_m, belt.time_s
    assert 0.9 * SILENCE_S <= moved_s - asked_s <= 0.25
    assert belt.host.ask(1, Command.FORWARD, PITCH).error is ErrorCode.SILENCE
    assert belt.host.finish(2).kind is ReplyKind.OK


def test_damaged_lines_are_no_sign_of_life(belt: Bench) -> None:
    belt.host.ask(1, Command.FORWARD, PITCH)
    for _ in range(30):
        belt.host.write(b">01 F 03E8*00\n\xff\x00>>")
        belt.advance(0.01)
    assert not belt.conveyor.truth().moving
    assert belt.host.heard() == []


def test_nothing_came_is_found_after_its_whole_travel_and_stays_latched(belt: Bench) -> None:
    belt.world.empty_belt()
    began_s = belt.time_s
    assert belt.host.finish(1).error is ErrorCode.NO_EDGE
    assert belt.time_s - began_s == pytest.approx(TRAVEL_LIMIT_PITCHES, abs=0.15)
    assert belt.conveyor.truth().travel_m == pytest.approx(TRAVEL_LIMIT_PITCHES * 0.1, abs=0.002)
    assert belt.conveyor.truth().error is ErrorCode.NO_EDGE
    assert belt.host.ask(2, Command.FORWARD, PITCH).error is ErrorCode.LATCHED
    assert belt.host.ask(3, Command.CLEAR).kind is ReplyKind.OK
    belt.world.refill_belt()
    assert belt.host.finish(4).kind is ReplyKind.OK


def test_did_not_move_is_found_at_once(belt: Bench) -> None:
    belt.conveyor.inject("stall")
    began_s = belt.time_s
    assert belt.host.finish(1).error is ErrorCode.NO_MOTION
    assert belt.time_s - began_s <= 0.1
    belt.conveyor.clear("stall")
    assert belt.host.ask(2, Command.CLEAR).kind is ReplyKind.OK
    assert belt.host.finish(3).kind is ReplyKind.OK


def test_a_part_is_taken_back(belt: Bench) -> None:
    belt.host.finish(1)
    assert belt.host.finish(2, Command.BACKWARD).kind is ReplyKind.OK
    assert belt.world.counts()[Where.PICK_STATION] == 0
    assert belt.host.finish(3).kind is ReplyKind.OK
    assert belt.world.counts()[Where.PICK_STATION] == 1


@pytest.mark.parametrize("cause", [ResetCause.BROWNOUT, ResetCause.WATCHDOG])
def test_a_reset_in_mid_index_is_told_and_the_part_still_comes(
    belt: Bench, cause: ResetCause
) -> None:
    belt.conveyor.inject("reset", cause=cause.value, after_m=0.01)
    assert belt.host.ask(1, Command.FORWARD, PITCH).kind is ReplyKind.BUSY
    assert Banner(BoardRole.CONVEYOR, PROTOCOL_VERSION, cause) in reboots(belt)
    assert not belt.conveyor.truth().moving
    assert belt.host.ask(2, Command.STATUS).error is ErrorCode.UNREADY
    belt.host.identify()
    assert belt.host.finish(1).kind is ReplyKind.OK
    assert belt.world.counts()[Where.PICK_STATION] == 1


def test_a_hang_ends_by_the_watchdog_and_the_belt_stands(belt: Bench) -> None:
    belt.host.ask(1, Command.FORWARD, PITCH)
    belt.advance(0.05)
    belt.conveyor.inject("hang", interrupts=False)
    assert Banner(BoardRole.CONVEYOR, PROTOCOL_VERSION, ResetCause.WATCHDOG) in reboots(belt)
    assert not belt.conveyor.truth().moving
    assert belt.world.violations == []
