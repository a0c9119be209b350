"""What people say of parts, and move by hand, in the middle of a build; the world keeps count."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from cellctl.assembly import Cell
from cellctl.client import CellClient
from cellctl.errors import RefusedError, UsageError
from cellctl.messages import (
    Command,
    CountCommand,
    HandCommand,
    MissingCommand,
    OwnCommand,
    PartPlace,
    RecoverCommand,
    RefillCommand,
)
from cellctl.sim.world_values import Where
from tests.cell.faulty import expect_fault, reset_and_resume
from tests.cell.harness import RunningCell, bar, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]

OWNED, ON_BELT = 12, 4


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    with running_cell(
        speed=10.0,
        limits={"inventory_parts": OWNED},
        feeder={"capacity_parts": ON_BELT},
    ) as running:
        yield running


@pytest.fixture
def idle(cell: RunningCell) -> Iterator[RunningCell]:
    cell.begin_test()
    yield cell
    cell.bring_back()
    cell.assert_inventory_true()


def begin(cell: RunningCell, *size: int) -> None:
    cell.client.build("bar.json", bar(*size))


def finish(cell: RunningCell, taken: int = 0) -> None:
    assert cell.finish().outcome == "built"
    cell.assert_as_planned(taken)


def stop_with_a_part(cell: RunningCell, *size: int) -> None:
    """A build that stands still with a part on its way."""
    begin(cell, *size)
    cell.wait_mid_place()
    cell.visitor.command("stop")
    assert cell.wait_state("paused_resting").gripper.holding == "part"


def say(part: PartPlace) -> RecoverCommand:
    return RecoverCommand(part=part)


# --- refilling --------------------------------------------------------------------------------


def test_a_belt_that_runs_empty_in_mid_build_is_waited_for_and_refilled(idle: RunningCell) -> None:
    begin(idle, 3, 2, 1)
    snapshot = idle.wait_state("feeding_refilling")
    assert snapshot.state.sentence == (
        "The belt is empty and 2 parts are still to place. "
        "Lay parts on the belt and say `cellctl refill`."
    )
    talk = snapshot.dialogue
    assert talk.line is not None
    assert talk.waits is not None
    assert talk.line == talk.waits.model_copy(update={"number": talk.line.number})
    assert talk.line.text.startswith("I have run out of parts.")
    for question in ("what are you doing?", "why?", "help"):
        assert idle.visitor.say(question).message == talk.line.text
    assert snapshot.inventory["belt"] == 0
    assert len(idle.truth().built) == ON_BELT
    with pytest.raises(RefusedError, match="operator"):
        idle.visitor.request(RefillCommand())
    with pytest.raises(UsageError, match="The belt has room for 4 parts"):
        idle.client.request(RefillCommand(parts=5))
    assert idle.client.snapshot().state.state == "feeding_refilling"
    idle.refill(3)
    finish(idle)
    with pytest.raises(UsageError, match="The stock has 5 parts"):
        idle.client.request(RefillCommand(parts=6))


def test_a_stop_while_parts_are_waited_for_and_resume_waits_on(idle: RunningCell) -> None:
    begin(idle, 5, 1, 1)
    idle.wait_state("feeding_refilling")
    idle.visitor.command("stop")
    idle.wait_state("paused_resting")
    idle.client.command("resume")
    idle.wait_state("feeding_refilling")
    idle.refill()
    finish(idle)


def test_parts_may_be_laid_on_the_belt_while_the_arm_works(idle: RunningCell) -> None:
    begin(idle, 3, 2, 1)
    idle.wait("two parts that stand", lambda now: len(now.standing) == 2)
    idle.refill(1)
    idle.refill()
    states = {message.state for message in idle.seen}
    finish(idle)
    assert "feeding_refilling" not in states | {message.state for message in idle.seen}


# --- the workspace ----------------------------------------------------------------------------


def test_what_stands_is_handed_over_or_cleared_before_the_next_build(idle: RunningCell) -> None:
    begin(idle, 1, 1, 2)
    with pytest.raises(RefusedError, match="A job is under way"):
        idle.client.command("hand_over")
    finish(idle)
    assert "You may take it along" in idle.client.snapshot().state.sentence
    with pytest.raises(RefusedError, match="needs the operator"):
        idle.visitor.command("clear")
    assert idle.world.hand_over() == 2
    assert "2 parts. Is that right?" in idle.visitor.command("hand_over").message
    assert len(idle.client.snapshot().standing) == 2
    assert "2 parts handed over" in idle.visitor.confirm(True).message
    idle.assert_inventory_true()
    assert idle.client.snapshot().inventory["handed_over"] == 2
    with pytest.raises(RefusedError, match="Nothing stands"):
        idle.visitor.command("hand_over")
    begin(idle, 1, 1, 1)
    finish(idle)
    idle.world.clear_workspace()
    assert "1 part back in the stock" in idle.client.command("clear").message
    idle.assert_inventory_true()
    assert idle.client.snapshot().standing == ()


def test_a_part_that_somebody_took_in_mid_build_is_placed_again(idle: RunningCell) -> None:
    begin(idle, 2, 2, 1)
    idle.wait("two parts that stand", lambda now: len(now.standing) == 2)
    gone, *_ = idle.client.snapshot().standing
    with pytest.raises(RefusedError, match="only when the cell is idle, paused or in a fault"):
        idle.client.request(MissingCommand(cells=(gone,)))
    idle.client.command("pause")
    snapshot = idle.wait_state("paused_resting")
    assert "Look whether all placed parts still stand" in snapshot.state.sentence
    idle.world.inject("part_taken", x=gone.x, y=gone.y, z=gone.z)
    with pytest.raises(RefusedError, match="operator"):
        idle.visitor.request(MissingCommand(cells=(gone,)))
    with pytest.raises(UsageError, match=r"No part is known to stand at \[0, 0, 5\]"):
        idle.client.request(MissingCommand(cells=(gone, Cell(0, 0, 5))))
    idle.client.request(MissingCommand(cells=(gone,)))
    idle.assert_inventory_true(taken=1)
    idle.refill()
    idle.client.command("resume")
    finish(idle, taken=1)


def test_what_cannot_stand_without_a_missing_part_is_missing_too(idle: RunningCell) -> None:
    begin(idle, 1, 1, 2)
    finish(idle)
    below, above = idle.client.snapshot().standing
    with pytest.raises(UsageError, match="cannot stand without the one at"):
        idle.client.request(MissingCommand(cells=(below,)))
    for gone in (above, below):
        idle.world.inject("part_taken", x=gone.x, y=gone.y, z=gone.z)
    idle.client.request(MissingCommand(cells=(below, above)))
    idle.assert_inventory_true(taken=2)


# --- counting ---------------------------------------------------------------------------------


def test_counting_and_owning_correct_the_inventory_and_what_cannot_be_is_refused(
    idle: RunningCell,
) -> None:
    def refused(why: str, *requests: Command) -> None:
        before = idle.client.snapshot().inventory
        for request in requests:
            with pytest.raises(UsageError, match=why):
                idle.client.request(request)
        assert idle.client.snapshot().inventory == before

    stock = idle.client.snapshot().inventory["stock"]
    assert stock >= 3
    refused("Say what was counted", CountCommand(note="nothing"))
    refused(f"more than the {OWNED} parts", CountCommand(stock=OWNED, belt=ON_BELT))
    refused(f"the stock has {stock}", OwnCommand(parts=OWNED - stock - 1))
    for request in (CountCommand(belt=1), OwnCommand(parts=20)):
        with pytest.raises(RefusedError, match="operator"):
            idle.visitor.request(request)
    idle.client.request(OwnCommand(parts=OWNED + 5, note="a new box"))
    assert idle.client.snapshot().inventory["stock"] == stock + 5
    idle.client.request(OwnCommand(parts=OWNED))
    idle.client.request(CountCommand(stock=stock - 3, note="three are gone"))
    assert idle.client.snapshot().inventory["unknown"] == 3
    idle.client.request(CountCommand(stock=stock - 2, scrap=2))
    snapshot = idle.client.snapshot()
    assert (snapshot.inventory["unknown"], snapshot.inventory["scrap"]) == (0, 2)
    begin(idle, 2, 1, 1)
    idle.wait_state("assembling_placing")
    for request in (CountCommand(stock=1), OwnCommand(parts=20)):
        with pytest.raises(RefusedError, match="only when the cell is idle, paused or in a fault"):
            idle.client.request(request)
    assert idle.finish().outcome == "built"


def test_no_object_may_have_more_parts_than_there_are(idle: RunningCell) -> None:
    idle.client.request(CountCommand(stock=0, belt=2))
    begin(idle, 3, 1, 1)
    job = idle.finish()
    assert job.outcome == "cannot_plan"
    assert "2" in job.message


# --- a part in the gripper --------------------------------------------------------------------


def see_the_status_fall(cell: RunningCell) -> None:
    """In the world, and then by whatever the robot told since."""
    cell.wait("a status that fell", lambda _: not cell.truth().latch["status"])
    fell_s = cell.client.snapshot().arm.robot_time_s
    assert fell_s is not None
    cell.wait("news", lambda now: (now.arm.robot_time_s or 0.0) > fell_s + 0.5)


def test_a_part_is_taken_out_of_the_gripper_and_the_next_one_takes_its_place(
    idle: RunningCell,
) -> None:
    stop_with_a_part(idle, 2, 1, 1)
    with pytest.raises(RefusedError, match="The latch is closed"):
        idle.client.request(say("scrap"))
    with pytest.raises(RefusedError, match="--part-held"):
        idle.hand("open")
    assert idle.truth().latch["latched"]
    idle.world.inject("part_dropped")  # the operator holds it, and takes it away
    assert "taken to the stock" in idle.hand("open", part_held=True)
    assert idle.client.snapshot().gripper.holding == "nothing"
    idle.world.clear_workspace()  # into the box with it
    idle.assert_inventory_true()
    with pytest.raises(RefusedError, match="none is in doubt"):
        idle.client.request(say("scrap"))
    idle.client.command("resume")
    finish(idle)


def test_a_part_that_is_no_longer_in_the_gripper_is_written_off(idle: RunningCell) -> None:
    stop_with_a_part(idle, 2, 1, 1)
    idle.world.inject("gripper_silent")  # with no power the latch confirms nothing
    see_the_status_fall(idle)
    idle.world.inject("part_dropped")
    with pytest.raises(RefusedError, match="operator"):
        idle.visitor.request(say("scrap"))
    idle.client.request(say("gripper"))
    idle.client.request(say("scrap"))
    snapshot = idle.client.snapshot()
    assert (snapshot.inventory["scrap"], snapshot.gripper.holding) == (1, "nothing")
    idle.world.clear("gripper_silent")
    idle.client.command("resume")
    assert idle.finish().outcome == "built"
    truth = idle.truth()
    assert len(truth.built) == 2
    assert (truth.counts[Where.FALLEN], truth.counts[Where.GRIPPER]) == (1, 0)


def test_a_latch_that_is_no_longer_confirmed_is_asked_about_before_the_arm_goes_on(
    idle: RunningCell,
) -> None:
    stop_with_a_part(idle, 2, 1, 1)
    idle.world.inject("gripper_reboot")
    see_the_status_fall(idle)
    with pytest.raises(RefusedError, match="the latch does not confirm it: look"):
        idle.client.command("resume")
    assert idle.client.snapshot().doubt
    idle.client.command("resume")  # it is there
    stopped = idle.wait(
        "the end, or news of the board's reset",
        lambda now: now.state.state in {"idle", "fault_held"},
    )
    if stopped.state.state == "fault_held":
        assert stopped.fault.entry is not None
        assert stopped.fault.entry.code == "gripper_reset"
        reset_and_resume(idle)
    finish(idle)


def test_a_latch_that_ceases_to_confirm_on_the_way_does_not_count_a_part_as_placed(
    idle: RunningCell,
) -> None:
    begin(idle, 2, 1, 1)
    idle.wait_held()
    idle.world.inject("gripper_silent")
    expect_fault(idle, "gripper_silent")
    idle.world.clear("gripper_silent")
    idle.client.command("reset")
    snapshot = idle.wait(
        "a doubt", lambda now: now.state.state == "paused_resting" and bool(now.doubt)
    )
    assert "the latch does not confirm it" in snapshot.state.sentence
    assert snapshot.standing == ()
    idle.client.command("resume")  # a person has looked: it is there
    finish(idle)


def test_a_part_that_fell_out_of_a_latch_opened_on_the_pendant_is_told(idle: RunningCell) -> None:
    stop_with_a_part(idle, 2, 1, 1)
    idle.world.inject("part_dropped")
    idle.world.inject("output_changed", line=0, high=True)
    see_the_status_fall(idle)
    with pytest.raises(RefusedError, match="somebody has opened it: look, then say resume"):
        idle.client.command("resume")
    with pytest.raises(UsageError, match="The latch is open"):
        idle.client.request(say("gripper"))
    idle.client.request(say("unknown"))
    idle.assert_inventory_true()
    idle.client.command("resume")
    expect_fault(idle, "robot_mismatch")  # the output is not as it was ordered
    reset_and_resume(idle)  # as it was meant
    assert idle.finish().outcome == "built"
    assert len(idle.truth().built) == 2


def test_only_a_paused_cell_is_told_where_a_part_is(idle: RunningCell) -> None:
    with pytest.raises(RefusedError, match="Only a paused cell"):
        idle.client.request(say("stock"))
    idle.client.command("pause")
    with pytest.raises(RefusedError, match="No part is in the gripper"):
        idle.client.request(say("stock"))


# --- cancelling at each grip ------------------------------------------------------------------


def cancelled(cell: RunningCell) -> None:
    """Cancel out of the pause, and be ready for the next."""
    cell.client.command("cancel")
    snapshot = cell.wait("the end", lambda now: now.job is not None and bool(now.job.outcome))
    assert snapshot.job is not None
    assert snapshot.job.outcome == "cancelled"
    cell.wait_state("paused_resting")
    cell.assert_inventory_true()
    cell.client.command("resume")
    cell.wait_state("idle")


def test_cancel_out_of_a_pause_with_nothing_in_the_gripper(idle: RunningCell) -> None:
    begin(idle, 2, 1, 1)
    idle.wait_state("assembling_placing")
    idle.client.command("pause")
    assert idle.wait_state("paused_resting").gripper.holding == "nothing"
    cancelled(idle)
    assert len(idle.client.snapshot().standing) == len(idle.truth().built) == 1


def test_cancel_while_the_latch_closes_finds_out_what_it_has(idle: RunningCell) -> None:
    idle.world.inject("gripper_silent")
    begin(idle, 2, 1, 1)
    idle.wait_state("fault_held")
    idle.world.clear("gripper_silent")
    idle.client.command("reset")
    assert idle.wait_state("paused_resting").gripper.holding == "latching"
    with pytest.raises(RefusedError, match="cut off in the middle"):
        idle.hand("open", part_held=True)
    cancelled(idle)
    assert idle.client.snapshot().gripper.holding == "part"
    idle.clear_workspace()
    begin(idle, 1, 1, 1)
    finish(idle)


def test_cancel_while_the_latch_opens_finds_out_what_it_let_go(idle: RunningCell) -> None:
    begin(idle, 2, 1, 1)
    idle.wait_mid_place()
    idle.world.inject("stuck_input", line=0, high=True)
    idle.wait_state("fault_held")
    idle.world.clear("stuck_input", line=0)
    idle.client.command("reset")
    assert idle.wait_state("paused_resting").gripper.holding == "releasing"
    (stands,) = idle.truth().built
    with pytest.raises(UsageError, match="No part is known to stand"):
        idle.client.request(MissingCommand(cells=(stands,)))
    cancelled(idle)
    assert idle.client.snapshot().standing == (stands,)


# --- by hand ----------------------------------------------------------------------------------


def test_the_arm_is_moved_by_hand_with_a_part_in_mid_build(idle: RunningCell) -> None:
    stop_with_a_part(idle, 2, 1, 1)
    for command in ("close", "check_lines"):
        with pytest.raises(RefusedError, match="There is a part in the gripper"):
            idle.client.request(HandCommand.model_validate({"command": "hand", "move": command}))
    with pytest.raises(RefusedError, match="operator"):
        idle.visitor.request(HandCommand(move="home"))
    with pytest.raises(UsageError, match="one axis"):
        idle.hand("jog", delta_m=(0.01, 0.01, 0.0))
    height_m = idle.client.snapshot().arm.tcp_pose[2]
    idle.hand("rise")
    risen_m = idle.client.snapshot().arm.tcp_pose[2]
    assert risen_m >= height_m - 1e-4
    idle.hand("above_cell", cell=Cell(4, 3, 0))
    above_m = idle.client.snapshot().arm.tcp_pose[2]
    idle.hand("jog", delta_m=(0.0, 0.0, -0.02))
    assert idle.client.snapshot().arm.tcp_pose[2] == pytest.approx(above_m - 0.02, abs=0.002)
    idle.hand("jog", turn_rad=0.2)
    with pytest.raises(UsageError, match="outside the workspace"):
        idle.hand("above_cell", cell=Cell(40, 0, 0))
    with pytest.raises(RefusedError, match="Name the cell"):
        idle.hand("above_cell")
    idle.hand("home")
    joints = idle.client.snapshot().arm.joints_rad
    assert joints == pytest.approx(idle.config.robot.home_rad, abs=0.01)
    assert idle.client.snapshot().gripper.holding == "part"
    idle.client.command("resume")
    finish(idle)


def test_the_empty_gripper_and_the_belt_are_moved_by_hand(idle: RunningCell) -> None:
    idle.client.command("pause")
    assert "Both lines work" in idle.hand("check_lines")
    idle.hand("close")
    with pytest.raises(RefusedError, match="--part-held"):  # it may have closed on something
        idle.hand("open")
    idle.hand("open", part_held=True)
    idle.hand("index")
    assert idle.client.snapshot().conveyor.part_present
    idle.hand("above_station")
    idle.hand("home")
    idle.client.command("resume")
    begin(idle, 1, 1, 1)
    finish(idle)


def test_nothing_is_moved_by_hand_but_out_of_a_pause(idle: RunningCell) -> None:
    def refused() -> None:
        with pytest.raises(RefusedError, match="only when the cell is paused"):
            idle.hand("home")

    refused()
    begin(idle, 1, 1, 1)
    idle.wait_state("assembling_placing")
    refused()
    idle.world.inject("safeguard_stop")
    idle.wait_state("fault_stopped")
    refused()


def test_a_movement_by_hand_is_stopped_and_the_build_goes_on(idle: RunningCell) -> None:
    stop_with_a_part(idle, 1, 1, 1)
    idle.hand("home")
    slow = HandCommand(move="above_cell", cell=Cell(0, 0, 0), speed_fraction=0.05)
    with CellClient.for_role(idle.config) as other, ThreadPoolExecutor(1) as hand:
        order = hand.submit(other.request, slow, timeout_s=idle.patience_s)
        idle.wait("an arm that moves", lambda now: now.arm.tcp_speed_m_s > 0.01)
        assert idle.client.snapshot().state.state == "paused_moving"
        with pytest.raises(RefusedError, match="The arm still moves"):
            idle.client.command("resume")
        idle.visitor.command("stop")
        with pytest.raises(RefusedError, match="interrupted"):
            order.result(idle.patience_s)
    snapshot = idle.wait_state("paused_resting")
    assert snapshot.arm.tcp_speed_m_s < 0.01
    assert snapshot.gripper.holding == "part"
    idle.client.command("resume")
    finish(idle)
