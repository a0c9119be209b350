"""Taking apart and changing over, carried out, and cut off in the middle of each of its states."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from cellctl.assembly import Assembly, StepKind
from cellctl.control.journal_reader import JournalReader
from cellctl.errors import RefusedError
from cellctl.messages import MissingCommand, RecoverCommand, Snapshot
from cellctl.sim.world_values import Where
from tests.cell.faulty import expect_fault, reset, reset_and_resume
from tests.cell.harness import RunningCell, bar, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]

PARTS = 8
TABLE = [(0, 0, 0), (0, 0, 1), (1, 0, 1)]
"""A part beside a column: it hangs at its neighbour."""


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    with running_cell(speed=10.0, limits={"inventory_parts": PARTS}) as running:
        yield running


@pytest.fixture
def idle(cell: RunningCell) -> Iterator[RunningCell]:
    cell.begin_test()
    yield cell
    cell.bring_back()
    cell.assert_inventory_true()


def build(cell: RunningCell, cells: object = TABLE) -> None:
    content = Assembly.of(cells, pitch_m=0.1).model_dump_json().encode()
    cell.client.build("object.json", content)
    assert cell.finish().outcome == "built"
    cell.assert_as_planned()


def expect_apart(cell: RunningCell) -> None:
    """It comes apart to the last part, and nothing fell."""
    assert cell.finish().outcome == "taken_apart"
    assert cell.client.snapshot().standing == ()
    cell.assert_as_planned()


def stop_in(cell: RunningCell, state: str) -> Snapshot:
    """Wait for a state, and stop in it."""
    cell.wait_state(state)
    cell.visitor.command("stop")
    snapshot = cell.wait_state("paused_resting")
    assert snapshot.arm.tcp_speed_m_s < 0.01
    return snapshot


def test_what_was_built_is_taken_apart_whatever_stops_it(idle: RunningCell) -> None:
    build(idle, [*TABLE, (0, 0, 2)])
    idle.visitor.command("take_apart")
    for state in ("gripping", "parting", "returning", "verifying"):
        stop_in(idle, f"disassembling_{state}")
        idle.client.command("resume")
    expect_apart(idle)
    snapshot = idle.client.snapshot()
    assert snapshot.inventory["belt"] == PARTS
    assert [part.kind for part in snapshot.parts] == [StepKind.REMOVE] * 4
    assert "disassembling" in idle.states_seen()
    with pytest.raises(RefusedError, match="Nothing stands"):
        idle.visitor.command("take_apart")


def test_a_wish_changes_what_stands_and_keeps_what_it_can(idle: RunningCell) -> None:
    build(idle)
    idle.client.build("bar.json", bar(1, 1, 3))
    stop_in(idle, "disassembling_parting")
    idle.client.command("resume")
    idle.wait_state("assembling_placing")
    idle.client.command("pause")
    idle.wait_state("paused_resting", "idle")
    if idle.client.snapshot().state.state != "idle":
        idle.client.command("resume")
    assert idle.finish().outcome == "built"
    idle.assert_as_planned()
    plan = idle.client.snapshot().plan
    assert plan is not None
    assert [step.kind for step in plan.steps] == [StepKind.REMOVE, StepKind.PLACE]
    assert "2 of 3 parts stay; 2 moves instead of 6" in plan.changes[0].what


def test_cancelled_with_a_part_in_the_latch_it_stands_on_and_the_next_job_goes_on(
    idle: RunningCell,
) -> None:
    build(idle)
    idle.client.command("take_apart")
    idle.wait_state("disassembling_gripping")
    idle.client.command("pause")
    snapshot = idle.wait_state("paused_resting")
    assert snapshot.gripper.holding == "gripped"
    assert "The gripper has hold of a part that stands." in snapshot.state.sentence
    with pytest.raises(RefusedError, match="hold of a part that stands"):
        idle.hand("rise")
    idle.client.command("cancel")
    idle.wait("the end", lambda now: now.job is not None and now.job.outcome == "cancelled")
    idle.wait_state("paused_resting")
    idle.client.command("resume")
    idle.wait_state("idle")
    assert len(idle.truth().built) == 3
    idle.client.command("take_apart")
    expect_apart(idle)


def test_cancelled_with_a_part_on_its_way_the_part_goes_to_the_belt(idle: RunningCell) -> None:
    build(idle)
    idle.client.command("take_apart")
    idle.wait_state("disassembling_returning")
    idle.client.command("cancel")
    assert idle.finish().outcome == "cancelled"
    snapshot = idle.client.snapshot()
    assert (len(snapshot.standing), snapshot.inventory["belt"]) == (2, PARTS - 2)
    idle.assert_inventory_true()


def test_a_cancelled_change_that_is_cut_off_while_it_lets_its_part_go_goes_on(
    idle: RunningCell,
) -> None:
    build(idle)
    idle.client.build("bar.json", bar(1, 1, 3))
    idle.wait_state("disassembling_parting")
    idle.client.command("cancel")
    idle.wait_state("disassembling_returning")
    idle.world.inject("stuck_input", line=0, high=True)
    expect_fault(idle, "gripper_silent")
    idle.world.clear("stuck_input", line=0)
    reset(idle)
    assert idle.client.snapshot().gripper.holding == "releasing"
    idle.client.command("resume")
    assert idle.finish().outcome == "cancelled"
    assert idle.client.snapshot().inventory["belt"] == PARTS - 2


def test_a_part_left_in_the_gripper_by_a_cancelled_job_goes_to_the_belt_first(
    idle: RunningCell,
) -> None:
    build(idle)
    idle.client.command("take_apart")
    stop_in(idle, "disassembling_returning")
    idle.client.command("cancel")
    idle.wait("the end", lambda now: now.job is not None and now.job.outcome == "cancelled")
    snapshot = idle.wait_state("paused_resting")
    assert (len(snapshot.standing), snapshot.gripper.holding) == (2, "part")
    idle.client.command("resume")
    idle.wait_state("idle")
    idle.client.command("take_apart")
    expect_apart(idle)
    # The part that was left over is no step of the second job.
    assert [part.step for part in idle.client.snapshot().parts] == [0, 1]


def test_a_part_that_was_to_stay_and_is_gone_ends_the_plan(idle: RunningCell) -> None:
    build(idle)
    idle.client.build("bar.json", bar(1, 1, 3))
    stop_in(idle, "disassembling_gripping")
    column = [place for place in idle.truth().built if place.z == 1]
    kept = idle.client.snapshot().plan
    assert kept is not None
    stays = next(cell for cell in column if cell in kept.assembly.cells)
    hangs = next(cell for cell in column if cell != stays)
    for gone in (hangs, stays):
        idle.world.inject("part_taken", x=gone.x, y=gone.y, z=gone.z)
    idle.client.request(MissingCommand(cells=(hangs, stays)))
    with pytest.raises(RefusedError, match="was to stay, and is missing"):
        idle.client.command("resume")
    idle.client.command("cancel")
    idle.wait("the end", lambda now: now.job is not None and bool(now.job.outcome))


def test_a_part_that_vanishes_from_a_latch_that_was_cut_off_is_told(idle: RunningCell) -> None:
    build(idle)
    idle.world.inject("gripper_silent")
    idle.client.command("take_apart")
    expect_fault(idle, "gripper_silent")
    reset(idle)
    snapshot = idle.client.snapshot()
    assert snapshot.gripper.holding == "latching"
    with pytest.raises(RefusedError, match="hold of a part that stands"):
        idle.hand("rise")
    built = set(idle.truth().built)
    (gone,) = (place for place in built if place.z and place.below() not in built)
    idle.world.inject("part_taken", x=gone.x, y=gone.y, z=gone.z)
    idle.client.request(MissingCommand(cells=(gone,)))
    idle.world.clear("gripper_silent")
    idle.client.command("resume")
    expect_fault(idle, "gripper_holds")  # it has closed: nobody knows on what
    reset(idle)
    idle.hand("open", part_held=True)
    idle.client.command("resume")
    assert idle.finish().outcome == "taken_apart"
    assert idle.truth().built == ()
    idle.assert_inventory_true(taken=1)


def test_a_part_on_its_way_back_that_somebody_put_where_it_was_stands_there(
    idle: RunningCell,
) -> None:
    build(idle)
    built = idle.client.snapshot().standing
    idle.client.command("take_apart")
    idle.wait("an arm that brings a part back", _brings_back)
    idle.client.command("stop")
    assert len(idle.wait_state("paused_resting").standing) == len(built) - 1
    idle.world.inject("output_changed", line=0, high=True)  # somebody takes it out
    idle.wait("an open latch", lambda _: idle.truth().counts[Where.GRIPPER] == 0)
    idle.client.request(RecoverCommand(part="cell"))
    assert set(idle.client.snapshot().standing) == set(built)
    idle.world.inject("output_changed", line=0, high=False)


def test_a_build_that_is_cancelled_leaves_no_act_without_an_outcome(idle: RunningCell) -> None:
    idle.client.build("bar.json", bar(1, 1, 3))
    idle.wait_mid_place()
    idle.wait("the next part", lambda now: now.conveyor.activity == "ready")
    idle.client.command("cancel")
    assert idle.finish().outcome == "cancelled"

    def open_acts(_: Snapshot) -> bool:
        with JournalReader(Path(idle.config.journal.path)) as journal:
            return bool(journal.unsettled())

    idle.wait("outcomes on disk", lambda now: not open_acts(now))


def test_a_jammed_belt_keeps_the_part_in_the_gripper(idle: RunningCell) -> None:
    build(idle)
    idle.world.inject("belt_stall")
    idle.client.command("take_apart")
    expect_fault(idle, "belt_jam")
    assert idle.client.snapshot().gripper.holding == "part"
    idle.world.clear("belt_stall")
    reset_and_resume(idle)
    expect_apart(idle)


@pytest.mark.soak
def test_a_latch_that_lost_its_part_on_the_way_is_asked_about(idle: RunningCell) -> None:
    build(idle)
    idle.client.command("take_apart")
    idle.wait("an arm that brings a part back", _brings_back)
    idle.world.inject("gripper_silent")
    expect_fault(idle, "gripper_silent")
    idle.world.clear("gripper_silent")
    reset(idle)
    assert "the latch does not confirm it" in idle.client.snapshot().state.sentence
    idle.client.command("resume")  # a person has looked: it is there
    expect_apart(idle)


def _brings_back(now: Snapshot) -> bool:
    return now.state.state == "disassembling_returning" and now.arm.tcp_speed_m_s > 0.1


@pytest.mark.soak
def test_missing_parts_need_not_be_taken_off(idle: RunningCell) -> None:
    build(idle)
    idle.client.command("take_apart")
    stop_in(idle, "disassembling_gripping")
    built = set(idle.truth().built)
    (gone,) = (place for place in built if place.z and place.below() not in built)
    idle.world.inject("part_taken", x=gone.x, y=gone.y, z=gone.z)
    idle.client.request(MissingCommand(cells=(gone,)))
    idle.client.command("resume")
    assert idle.finish().outcome == "taken_apart"
    assert idle.truth().built == ()
    idle.assert_inventory_true(taken=1)
