"""Faults that people bring about, or that need a person to look: each left by its documented way.

``tests/house/test_fault_list.py`` keeps the list of all codes and of the tests that provoke them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from cellctl.assembly import Cell, Pace
from cellctl.cli.speed_walk import SpeedWalk, column
from cellctl.control.acts import ActKind
from cellctl.control.journal_reader import JournalReader
from cellctl.errors import CellctlError, RefusedError
from cellctl.feeding.inventory import Move
from cellctl.messages import CountCommand, MissingCommand, RecoverCommand
from tests.cell.faulty import begin, expect_fault, finish_as_planned, reset, reset_and_resume
from tests.cell.harness import RunningCell, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    with running_cell(
        speed=10.0,
        limits={"inventory_parts": 12},
        feeder={"capacity_parts": 4},
        robot={"move_timeout_factor": 1.2},
        policy={"confirmation": "waived", "refill_timeout_s": 40.0},
    ) as running:
        yield running


@pytest.fixture
def idle(cell: RunningCell) -> Iterator[RunningCell]:
    """An idle cell, and afterwards proof that the same daemon still builds."""
    cell.begin_test()
    yield cell
    cell.bring_back()
    cell.begin_test()
    begin(cell, nz=1)
    finish_as_planned(cell)
    cell.clear_workspace()


def hold_unconfirmed(cell: RunningCell) -> None:
    """A build that is paused while the latch has closed, and nobody has confirmed it."""
    cell.world.inject("gripper_silent")
    begin(cell)
    expect_fault(cell, "gripper_silent")
    cell.world.clear("gripper_silent")
    reset(cell)
    assert cell.client.snapshot().gripper.holding == "latching"


def test_another_board_is_on_the_grippers_port(idle: RunningCell) -> None:
    idle.world.inject("gripper_board_role")
    idle.world.inject("gripper_board_reset")
    begin(idle, nz=1)
    expect_fault(idle, "gripper_mismatch")
    idle.world.clear("gripper_board_role")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_the_grippers_board_is_reset_with_a_part_in_it(idle: RunningCell) -> None:
    begin(idle, 2, 1, 1)
    idle.wait_mid_place()
    idle.world.inject("gripper_board_reset")
    expect_fault(idle, "gripper_reset")
    snapshot = idle.client.snapshot()
    assert "Part 1 should be in the gripper, whose board was reset (watchdog)" in snapshot.doubt
    assert snapshot.gripper.holding == "part"
    assert idle.truth().latch["latched"], "the voxel is kept"
    reset_and_resume(idle)  # a person has looked: it is there
    finish_as_planned(idle)


def test_nobody_refills_the_belt(idle: RunningCell) -> None:
    begin(idle, 5, 1, 1)
    idle.wait_state("feeding_refilling")
    expect_fault(idle, "belt_empty")
    assert idle.client.snapshot().fault.during == "feeding_refilling"
    idle.refill()
    reset_and_resume(idle)
    finish_as_planned(idle)


@pytest.mark.parametrize("swapped", ["board_role", "board_protocol"])
def test_another_board_is_on_the_conveyors_port(idle: RunningCell, swapped: str) -> None:
    idle.world.inject(swapped)
    begin(idle, nz=1)
    expect_fault(idle, "belt_mismatch")
    idle.client.command("reset")
    expect_fault(idle, "belt_mismatch")  # nobody has plugged in the right one
    idle.world.clear(swapped)
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_the_latch_holds_something_that_nobody_knows_of(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_state("assembling_placing")
    idle.client.command("pause")
    idle.wait_state("paused_resting")
    idle.hand("home")
    idle.hand("close")
    idle.client.command("cancel")
    expect_fault(idle, "gripper_holds")
    idle.world.inject("output_changed", line=0, high=True)
    reset_and_resume(idle)
    assert idle.finish().outcome == "cancelled"
    assert len(idle.truth().built) == 1
    idle.assert_inventory_true()


def test_the_arm_is_moved_while_the_latch_is_not_confirmed(idle: RunningCell) -> None:
    hold_unconfirmed(idle)
    idle.hand("rise")
    idle.client.command("resume")
    expect_fault(idle, "arm_moved")
    reset(idle)
    idle.client.command("cancel")
    snapshot = idle.wait_state("paused_resting")
    assert "it seems, but the arm was moved" in snapshot.state.sentence
    assert snapshot.doubt
    idle.client.request(RecoverCommand(part="gripper"))
    snapshot = idle.client.snapshot()
    assert (snapshot.doubt, snapshot.gripper.holding) == ("", "part")
    idle.client.command("resume")
    idle.wait_state("idle")
    idle.assert_inventory_true()


def test_a_part_stands_over_the_cell_where_another_must_go(idle: RunningCell) -> None:
    begin(idle, 2, 1, 3)
    idle.wait_state("feeding_refilling")
    idle.visitor.command("stop")
    below = min(idle.wait_state("paused_resting").standing)
    take_out(idle, below)  # the one above it hangs on its neighbour
    idle.refill()
    idle.client.command("resume")
    expect_fault(idle, "no_route")
    assert idle.client.snapshot().gripper.holding == "part"
    take_out(idle, below._replace(z=1))
    reset_and_resume(idle)
    finish_as_planned(idle, taken=2)


def take_out(cell: RunningCell, place: Cell) -> None:
    """Somebody takes a part off the structure, and the operator tells it."""
    cell.world.inject("part_taken", x=place.x, y=place.y, z=place.z)
    cell.client.request(MissingCommand(cells=(place,)))


def test_the_speed_slider_is_down(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_mid_place()
    idle.world.inject("speed_slider", fraction=0.005)
    expect_fault(idle, "motion_timeout")
    idle.world.inject("speed_slider", fraction=1.0)
    reset_and_resume(idle)
    finish_as_planned(idle)


@pytest.mark.parametrize("changed", ["tcp_changed", "payload_changed"])
def test_the_robots_settings_were_changed_on_the_pendant(idle: RunningCell, changed: str) -> None:
    idle.world.inject(changed)
    begin(idle, nz=1)
    expect_fault(idle, "robot_mismatch")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_the_pendant_is_switched_to_local(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_mid_place()
    idle.world.inject("local_control")
    expect_fault(idle, "local_control")
    idle.client.command("reset")
    expect_fault(idle, "local_control")
    idle.world.clear("local_control")
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_the_inventory_rules_out_what_the_arm_has_done(idle: RunningCell) -> None:
    hold_unconfirmed(idle)
    counts = idle.client.snapshot().inventory
    wrong = CountCommand(stock=counts["stock"] + counts["belt"], belt=0)
    right = CountCommand(stock=counts["stock"], belt=counts["belt"])
    idle.client.request(wrong)  # although a part of the belt is in the latch
    idle.client.command("resume")
    expect_fault(idle, "internal")
    assert "counts no part in belt" in idle.client.snapshot().fault.detail
    idle.client.request(right)
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_nothing_is_under_the_part_that_is_to_be_let_go(idle: RunningCell) -> None:
    begin(idle)
    idle.wait("one that stands", lambda now: len(now.standing) == 1)
    (below,) = idle.truth().built
    idle.wait_mid_place()
    idle.world.inject("part_taken", x=below.x, y=below.y, z=below.z)
    expect_fault(idle, "not_seated")
    assert idle.client.snapshot().gripper.holding == "part"
    assert idle.truth().violations[idle.held_before :] == ()
    reset(idle)
    idle.client.request(MissingCommand(cells=(below,)))
    idle.client.command("resume")
    finish_as_planned(idle, taken=1)


def test_a_part_below_stands_too_high(idle: RunningCell) -> None:
    begin(idle)
    idle.wait("one that stands", lambda now: len(now.standing) == 1)
    (below,) = idle.truth().built
    where = {"x": below.x, "y": below.y, "z": below.z}
    idle.wait_mid_place()
    idle.world.inject("part_raised", **where)
    expect_fault(idle, "contact_early")
    assert idle.client.snapshot().gripper.holding == "part"
    assert idle.truth().violations[idle.held_before :] == ()
    reset(idle)
    assert "The TCP is at" in idle.hand("rise")
    idle.world.clear("part_raised", **where)  # somebody takes the crumb away
    idle.client.command("resume")
    finish_as_planned(idle)


@pytest.mark.soak
def test_a_part_stands_where_another_must_go_and_nobody_told(idle: RunningCell) -> None:
    begin(idle)
    idle.wait("one that stands", lambda now: len(now.standing) == 1)
    (below,) = idle.truth().built
    where = {"x": below.x, "y": below.y, "z": below.z + 1}
    idle.wait_mid_place()
    idle.world.inject("part_put", **where)
    fault = idle.wait("a fault", lambda now: now.fault.entry is not None).fault.entry
    assert fault is not None
    assert fault.code in {"contact_early", "protective_stop"}  # whichever feels it first
    assert idle.client.snapshot().gripper.holding == "part"
    # It ran into a part that nobody told of, and that is all that happened.
    assert {told.kind for told in idle.truth().violations[idle.held_before :]} <= {"collision"}
    reset(idle)
    assert idle.client.snapshot().gripper.holding == "part"
    idle.world.inject("part_taken", **where)
    idle.client.command("resume")
    assert idle.finish().outcome == "built"
    assert len(idle.truth().built) == 2


class Standing:
    """A person beside trials of speed, who takes away what falls."""

    def __init__(self, cell: RunningCell, removed: Callable[[], None]) -> None:
        self._cell = cell
        self._removed = removed

    def tell(self, text: str) -> None:
        assert text

    def agreed(self, question: str) -> bool:
        raise AssertionError(f"nothing is in question in these trials: {question}")

    def removed(self, what: str) -> bool:
        assert "nothing is felt under the gripper" in what
        self._removed()
        self._cell.world.clear_workspace()
        return True


def test_a_part_is_set_down_too_hard_in_a_trial_of_speed(idle: RunningCell) -> None:
    def removed() -> None:
        expect_fault(idle, "part_fell")
        assert idle.client.snapshot().standing == ()
        idle.assert_inventory_true()

    # Whoever tries leaves the fault by a reset, and takes apart what stood before the next pace.
    quick, hard = (Pace(speed_m_s=v, acceleration_m_s2=v) for v in (1.5, 2.5))
    content = column(idle.config.voxel.pitch_m, 1)
    walk = SpeedWalk(idle.client, Standing(idle, removed), name="column.json", content=content)
    found = walk.run((hard, quick))
    assert [(one.pace, one.stood, one.tried) for one in found] == [(hard, 0, 1), (quick, 1, 1)]
    assert 3.0 < found[1].told_s < 6.0
    assert [told.kind for told in idle.truth().violations[idle.held_before :]] == ["jolted"]
    assert idle.client.snapshot().standing == ()
    idle.assert_inventory_true()
    with JournalReader(Path(idle.config.journal.path)) as journal:
        noted = [act.detail for act in journal.acts("") if act.kind is ActKind.CALIBRATED]
        jobs = [stored.record for stored in journal.jobs(3)]
        released = [act for act in journal.acts(jobs[-1].job_id) if act.kind is ActKind.RELEASE]
    assert noted[-2] == "speed: column.json at 2.5 m/s and 2.5 m/s2: 0 of 1 stood"
    assert noted[-1].startswith("speed: column.json at 1.5 m/s and 1.5 m/s2: 1 of 1 stood")
    assert [job.pace for job in jobs] == [None, quick, hard]
    told = [(act.outcome, act.detail, act.moves) for act in released]
    assert told == [("failed", "nothing is felt under the gripper", (Move.PLACE, Move.LOSE_PLACED))]


def test_a_part_that_sticks_to_the_gripper_is_not_torn_off(idle: RunningCell) -> None:
    begin(idle)
    idle.wait("one that stands", lambda now: len(now.standing) == 1)
    idle.wait_mid_place()
    idle.world.inject("part_sticks")
    expect_fault(idle, "part_stuck")
    assert len(idle.truth().built) == 2
    assert idle.truth().violations[idle.held_before :] == ()
    idle.world.clear("part_sticks")  # a person frees it
    reset_and_resume(idle)
    finish_as_planned(idle)


def test_a_gripper_that_a_person_has_moved_off_its_part_counts_as_free(idle: RunningCell) -> None:
    begin(idle)
    idle.wait("one that stands", lambda now: len(now.standing) == 1)
    idle.wait_mid_place()
    idle.world.inject("part_sticks")
    expect_fault(idle, "part_stuck")
    reset(idle)
    idle.client.command("cancel")
    idle.wait("the end", lambda now: now.gripper.holding == "gripped")
    idle.wait_state("paused_resting")
    idle.world.clear("part_sticks")
    x_m, y_m, z_m = idle.config.workspace.frame[:3]
    idle.world.inject("arm_guided", x_m=x_m, y_m=y_m, z_m=z_m + 0.6)
    idle.wait("rest", lambda now: not now.arm.moving)
    assert idle.hand("open") == "The latch is open."
    assert idle.client.snapshot().gripper.holding == "nothing"
    assert len(idle.client.snapshot().standing) == len(idle.truth().built) == 2
    idle.hand("home")
    idle.client.command("resume")
    idle.wait_state("idle")


def test_a_part_that_sticks_stays_known_when_the_job_is_cancelled(idle: RunningCell) -> None:
    begin(idle)
    idle.wait("one that stands", lambda now: len(now.standing) == 1)
    idle.wait_mid_place()
    idle.world.inject("part_sticks")
    expect_fault(idle, "part_stuck")
    reset(idle)
    idle.client.command("cancel")
    snapshot = idle.wait("the end", lambda now: now.gripper.holding == "gripped")
    assert len(snapshot.standing) == 2
    idle.wait_state("paused_resting")
    with pytest.raises(RefusedError, match="hold of a part that stands"):
        idle.hand("rise")
    with pytest.raises(CellctlError, match="does not come off"):
        idle.hand("open")
    expect_fault(idle, "part_stuck")
    reset(idle)
    idle.world.clear("part_sticks")  # a person frees it
    assert idle.hand("open") == "The latch is open; the part stands."
    idle.hand("rise")
    assert len(idle.truth().built) == 2
    assert idle.truth().violations[idle.held_before :] == ()
    idle.client.command("resume")
    idle.wait_state("idle")
