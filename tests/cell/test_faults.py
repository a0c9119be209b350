"""Each fault injected at the wire, left by its documented way, and the same daemon builds on."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from cellctl.messages import RecoverCommand
from cellctl.sim.world_values import Imperfections, ViolationKind
from cellctl.speaking.voices import speak_to_wav
from tests.cell.faulty import begin, expect_fault, finish_as_planned, reset, reset_and_resume
from tests.cell.harness import RunningCell, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    with running_cell(speed=10.0) as running:
        yield running


@pytest.fixture
def idle(cell: RunningCell) -> Iterator[RunningCell]:
    """An idle cell, and afterwards proof that the same daemon still builds."""
    cell.begin_test()
    yield cell
    cell.bring_back()
    begin(cell)
    assert cell.finish().outcome == "built"
    assert len(cell.truth().built) == 2
    cell.clear_workspace()


def test_an_empty_belt(idle: RunningCell) -> None:
    idle.world.inject("belt_empty")
    begin(idle)
    expect_fault(idle, "belt_jam")  # the inventory knows of parts that should be there
    idle.world.refill()
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_jammed_belt(idle: RunningCell) -> None:
    begin(idle, nz=3)
    idle.wait_mid_place()
    idle.world.inject("belt_jam")
    expect_fault(idle, "belt_jam")
    idle.world.clear("belt_jam")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_gripper_that_reports_nothing(idle: RunningCell) -> None:
    idle.world.inject("gripper_silent")
    begin(idle)
    expect_fault(idle, "gripper_silent")
    idle.world.clear("gripper_silent")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_gripper_that_reports_a_fault(idle: RunningCell) -> None:
    idle.world.inject("gripper_fault")
    begin(idle)
    expect_fault(idle, "gripper_fault")
    idle.world.clear("gripper_fault")
    reset_and_resume(idle)
    finish_as_planned(idle)


def slowly_to_the_station(cell: RunningCell) -> None:
    """A build whose open gripper is on its way to its first part."""
    cell.world.inject("speed_slider", fraction=0.1)
    begin(cell)
    cell.wait(
        "an arm that moves to the station",
        lambda now: now.state.state == "assembling_picking" and now.arm.moving,
    )


def test_a_latch_that_stalls_as_it_closes_carries_nothing(idle: RunningCell) -> None:
    slowly_to_the_station(idle)
    idle.world.inject("gripper_fault")
    idle.world.inject("speed_slider", fraction=1.0)
    expect_fault(idle, "gripper_fault")
    assert (
        "should be in the gripper, and the latch does not confirm" in idle.client.snapshot().doubt
    )
    idle.world.clear("gripper_fault")
    reset(idle)
    idle.client.request(RecoverCommand(part="station"))
    idle.client.command("resume")
    assert idle.finish().outcome == "built"
    idle.assert_inventory_true()
    # Once it is cleared, the latch closes where the arm has stopped.
    held = idle.truth().violations[idle.held_before :]
    assert {violation.kind for violation in held} <= {ViolationKind.PICKED_NOTHING}


def test_a_part_that_is_taken_from_under_the_gripper_is_not_carried(idle: RunningCell) -> None:
    slowly_to_the_station(idle)
    idle.world.inject("part_missing")
    idle.world.inject("replies_lost", count=2)  # the arm is there before the belt has answered
    idle.world.inject("speed_slider", fraction=1.0)
    assert idle.finish().outcome == "built"
    assert len(idle.truth().built) == 2
    idle.count()  # somebody has put it into the stock
    held = idle.truth().violations[idle.held_before :]
    assert {violation.kind for violation in held} <= {ViolationKind.PICKED_NOTHING}


def test_a_protective_stop_in_mid_place(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_mid_place()
    idle.world.inject("protective_stop")
    expect_fault(idle, "protective_stop")
    assert idle.client.snapshot().gripper.holding == "part"
    assert idle.truth().latch["latched"]
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_an_emergency_stop_in_mid_place(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_mid_place()
    idle.world.inject("emergency_stop")
    expect_fault(idle, "emergency_stop")
    idle.client.command("reset")
    expect_fault(idle, "emergency_stop")  # the button is still pressed
    idle.world.clear("emergency_stop")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_safeguard_stop_in_mid_place(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_mid_place()
    idle.world.inject("safeguard_stop")
    expect_fault(idle, "safeguard_stop")
    idle.world.clear("safeguard_stop")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_lost_connection_in_mid_place(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_mid_place()
    idle.world.inject("drop_connections")
    expect_fault(idle, "robot_lost")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_killed_program_in_mid_place(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_mid_place()
    idle.world.inject("kill_program")
    expect_fault(idle, "program_stopped")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_silent_conveyor_board(idle: RunningCell) -> None:
    idle.world.inject("board_silent")
    begin(idle)
    expect_fault(idle, "belt_lost")
    idle.world.clear("board_silent")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_latch_that_does_not_move(idle: RunningCell) -> None:
    idle.world.inject("gripper_stuck")
    begin(idle)
    expect_fault(idle, "gripper_silent")
    idle.world.clear("gripper_stuck")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_part_that_lies_turned_is_missed_twice_and_then_a_fault(idle: RunningCell) -> None:
    idle.world.inject("part_yawed")
    begin(idle)
    expect_fault(idle, "pick_missed")
    assert idle.client.snapshot().gripper.holding == "nothing"
    idle.world.clear("part_yawed")
    reset_and_resume(idle)
    assert idle.finish().outcome == "built"
    assert len(idle.truth().built) == 2
    held = idle.truth().violations[idle.held_before :]
    assert {violation.kind for violation in held} == {ViolationKind.PICKED_NOTHING}


def test_a_part_that_sticks_and_a_gap_on_the_belt_are_no_faults(idle: RunningCell) -> None:
    idle.world.inject("part_missing")
    idle.world.inject("part_sticky")
    idle.count()  # the part that is missing on the belt is in the stock
    begin(idle)
    finish_as_planned(idle)


def test_a_fault_while_listening_builds_nothing_afterwards(
    idle: RunningCell, tmp_path: Path
) -> None:
    path = tmp_path / "wish.wav"
    speak_to_wav("the letter T", path)
    joints = idle.truth().robot["joints_rad"]
    idle.visitor.hear(path.name, path.read_bytes())
    idle.wait_state("listening_hearing")
    idle.world.inject("safeguard_stop")
    expect_fault(idle, "safeguard_stop")
    idle.world.clear("safeguard_stop")
    reset_and_resume(idle)
    snapshot = idle.wait_state("idle")
    assert snapshot.job is not None
    assert snapshot.job.outcome == "failed"
    assert idle.truth().robot["joints_rad"] == joints


def test_a_robot_that_is_lost_while_idle_is_noticed(idle: RunningCell) -> None:
    idle.world.inject("freeze")
    expect_fault(idle, "robot_lost")
    idle.world.clear("freeze")
    reset_and_resume(idle)
    idle.wait_state("idle")


def test_an_imperfect_belt(idle: RunningCell) -> None:
    rough = Imperfections(belt_slip=0.2, pitch_drift_m=0.02, missing_share=0.2, sticky_share=0.3)
    idle.world.set_imperfections(rough, relay=True)
    idle.count()  # gaps on the belt leave parts in the stock
    begin(idle, nz=4)
    assert idle.finish().outcome == "built"
    idle.assert_as_planned()
    idle.world.set_imperfections(Imperfections(), relay=True)


def test_a_robot_that_refuses_the_connection(cell: RunningCell) -> None:
    """At the start, as a visitor's first sight of the cell in the morning."""
    cell.world.inject("refuse_connections")
    cell.world.inject("drop_connections")
    cell.client.say("the letter T")
    expect_fault(cell, "robot_lost")
    cell.client.command("reset")
    expect_fault(cell, "robot_lost")
    cell.world.clear("refuse_connections")
    reset_and_resume(cell)
    finish_as_planned(cell)
    cell.clear_workspace()
