"""The gripper's serial port in a running cell: it tells, and its loss or a reset does no harm."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cellctl.errors import RefusedError, UsageError
from cellctl.messages import GripperCommand
from tests.cell.faulty import begin, finish_as_planned
from tests.cell.harness import RunningCell, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    with running_cell(speed=10.0) as running:
        yield running


@pytest.fixture
def idle(cell: RunningCell) -> Iterator[RunningCell]:
    """An idle cell, left as one."""
    cell.begin_test()
    yield cell
    cell.bring_back()


def ask(cell: RunningCell, **what: object) -> str:
    return cell.client.request(GripperCommand.model_validate(what)).message


def test_a_reset_while_the_latch_opens_lets_no_part_be_carried_off(idle: RunningCell) -> None:
    begin(idle, 2, 1, 1)
    idle.wait_mid_place()
    idle.world.inject("gripper_board_reset", when="opening")
    finish_as_planned(idle)
    assert idle.truth().gripper_board["resets"] == idle.client.snapshot().gripper.resets > 0


def test_a_reset_while_the_latch_closes_is_made_good(idle: RunningCell) -> None:
    resets = idle.client.snapshot().gripper.resets
    idle.world.inject("gripper_board_reset", when="closing")
    begin(idle, 2, 1, 1)
    finish_as_planned(idle)
    assert idle.client.snapshot().gripper.resets == resets + 1


def test_a_lost_board_stops_no_build_and_is_told_and_found_again(idle: RunningCell) -> None:
    begin(idle, 2, 1, 1)
    idle.wait_mid_place()
    idle.world.inject("gripper_board_silent")
    snapshot = idle.wait("a notice", lambda now: now.gripper.notice is not None)
    assert snapshot.gripper.notice is not None
    assert snapshot.gripper.notice.code == "gripper_board_lost"
    finish_as_planned(idle)
    assert idle.client.snapshot().gripper.board is None
    idle.world.clear("gripper_board_silent")
    idle.wait("the board", lambda now: now.gripper.board is not None)


def test_a_board_that_was_reset_while_it_was_unplugged_is_noticed(idle: RunningCell) -> None:
    before = idle.client.snapshot().gripper.resets
    idle.world.inject("gripper_board_unplugged")
    idle.wait("a notice", lambda now: now.gripper.board is None)
    idle.world.clear("gripper_board_unplugged")
    idle.wait("a reset", lambda now: now.gripper.resets == before + 1)


def test_after_a_reset_an_opening_begins_with_a_latch_that_is_confirmed(
    idle: RunningCell,
) -> None:
    def cycles() -> int:
        ask(idle, do="show")
        return idle.client.snapshot().gripper.registers["cycles"]

    begin(idle, 1, 1, 1)
    idle.wait_state("feeding_indexing", "assembling_picking")
    idle.client.command("stop")
    idle.wait_state("paused_resting")
    idle.hand("open")
    before = cycles()
    idle.hand("open")
    assert cycles() == before
    resets = idle.client.snapshot().gripper.resets
    idle.world.inject("gripper_board_reset")
    idle.wait("the reset", lambda now: now.gripper.resets == resets + 1)
    idle.hand("open")
    assert cycles() == before + 1
    idle.client.command("resume")
    finish_as_planned(idle)


def test_an_operator_sees_calibrates_and_keeps(idle: RunningCell) -> None:
    assert "latch pulse: 1500 us (600 to 2400)" in ask(idle, do="show")
    assert "nothing wrong" in ask(idle, do="test")
    with pytest.raises(UsageError, match="600 to 2400 us"):
        ask(idle, do="set", latch_pulse_us=2401)
    with pytest.raises(UsageError, match="what to set"):
        ask(idle, do="set")
    ask(idle, do="set", latch_pulse_us=1450, travel_ms=300)
    ask(idle, do="keep")
    idle.world.inject("gripper_board_reset")
    idle.wait("the reset", lambda _: "watchdog resets: 0" not in ask(idle, do="show"))
    assert "latch pulse: 1450 us" in ask(idle, do="show")
    idle.world.inject("gripper_store_damaged")
    idle.world.inject("gripper_board_reset")
    notice = idle.wait("a notice", lambda now: now.gripper.notice is not None).gripper.notice
    assert notice is not None
    assert notice.code == "gripper_uncalibrated"
    assert "latch pulse: 1500 us" in ask(idle, do="show")
    assert "found wrong: record" in ask(idle, do="test")
    ask(idle, do="keep")
    idle.wait("no notice", lambda now: now.gripper.notice is None)


def test_nothing_is_set_while_a_job_moves_and_nothing_by_a_visitor(idle: RunningCell) -> None:
    with pytest.raises(RefusedError, match="operator"):
        idle.visitor.request(GripperCommand(do="show"))
    begin(idle, 2, 1, 1)
    idle.wait_mid_place()
    for do in ("set", "keep", "test", "clear"):
        with pytest.raises(RefusedError, match="moves"):
            ask(idle, do=do, latch_pulse_us=1450)
    assert "supply: 5000 mV" in ask(idle, do="show")
    finish_as_planned(idle)
    assert idle.truth().gripper_board["calibration"]["latch_pulse"] != 1450
