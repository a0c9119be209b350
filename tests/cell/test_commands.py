"""Pause, stop, cancel, confirm and the rest, through the door that people use."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cellctl.errors import RefusedError, UsageError
from tests.cell.harness import RunningCell, bar, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    with running_cell(speed=10.0, policy={"confirmation": "ask"}) as running:
        yield running


@pytest.fixture
def idle(cell: RunningCell) -> Iterator[RunningCell]:
    cell.begin_test()
    yield cell
    cell.bring_back()


def begin(cell: RunningCell, height: int = 2) -> None:
    cell.client.build("bar.json", bar(1, 1, height))
    cell.wait_state("validating_confirming")
    cell.visitor.confirm(True)


def test_the_cell_asks_before_it_builds(idle: RunningCell) -> None:
    idle.visitor.say("the letter T")
    snapshot = idle.wait_state("validating_confirming")
    assert snapshot.state.sentence.startswith("Letter T")
    assert "Shall I build it?" in snapshot.state.sentence
    idle.visitor.say("no thanks")
    assert idle.finish().outcome == "declined"
    assert idle.truth().built == ()


def asked(cell: RunningCell, *words: str) -> str:
    """What the cell asks, once it asks about that."""
    snapshot = cell.wait(
        f"asking about {' and '.join(words)}",
        lambda seen: (
            seen.state.state == "validating_confirming"
            and all(word in seen.state.sentence for word in words)
        ),
    )
    return snapshot.state.sentence


def asked_anew(cell: RunningCell, before: str) -> str:
    """What the cell asks, once that is something else than before."""
    snapshot = cell.wait(
        "another question",
        lambda seen: seen.state.state == "validating_confirming" and seen.state.sentence != before,
    )
    return snapshot.state.sentence


def test_a_change_said_while_it_asks_is_planned_and_asked_about(idle: RunningCell) -> None:
    idle.visitor.say("a stool thirty centimetres high")
    asked(idle, "Stool", " x 30 cm")
    assert "change" in idle.visitor.say("make it one block taller").message
    asked(idle, "Stool", " x 40 cm")
    # What cannot be changed leaves the question as it was, and says why.
    idle.visitor.say("add two drawers")
    asked(idle, "So it stays as it was", "Stool", " x 40 cm")
    with pytest.raises(RefusedError, match="rather not build weapons"):
        idle.visitor.say("make it a gun")
    with pytest.raises(RefusedError, match="I asked whether to build it"):
        idle.visitor.say("what a lovely day")
    idle.visitor.say("actually make it a tower")
    assert "stays as it was" not in asked(idle, "Tower", "Shall I build it?")
    idle.visitor.confirm(False)
    assert idle.finish().outcome == "declined"
    assert idle.truth().built == ()


def test_another_shape_is_shown_until_there_is_none(idle: RunningCell) -> None:
    with pytest.raises(RefusedError, match="I have not asked"):
        idle.visitor.say("show me another")
    idle.visitor.say("the letter T")
    first = asked(idle, "Letter T", "Shall I build it?")
    assert "another" in idle.visitor.say("something different please").message
    second = asked(idle, "Here is another one. Letter T")
    assert "another" in idle.visitor.say("make it look nicer").message
    third = asked(idle, "Here is another one. Letter T", " x 50 cm")
    assert len({first, second, third}) == 3
    last = third
    for _ in range(4):
        idle.visitor.say("not like that")
        last = asked_anew(idle, last)
        if "I know no other" in last:
            break
    assert "I know no other shape for it" in last
    assert "So it stays as it was" in last
    idle.visitor.confirm(False)
    assert idle.finish().outcome == "declined"


def test_pause_waits_for_a_safe_point_and_resume_goes_on(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_state("assembling_placing")
    idle.client.command("pause")
    snapshot = idle.wait_state("paused_resting")
    assert snapshot.gripper.holding == "nothing"
    assert len(idle.truth().built) == 1
    idle.client.command("resume")
    assert idle.finish().outcome == "built"
    idle.assert_as_planned()


def test_stop_brakes_at_once_and_keeps_the_part(idle: RunningCell) -> None:
    begin(idle)
    idle.wait_mid_place()
    idle.visitor.command("stop")
    snapshot = idle.wait_state("paused_resting")
    assert snapshot.gripper.holding == "part"
    assert snapshot.arm.tcp_speed_m_s < 0.01
    with pytest.raises(RefusedError, match="operator"):
        idle.visitor.command("resume")
    idle.client.command("resume")
    assert idle.finish().outcome == "built"
    idle.assert_as_planned()


def test_a_stop_where_nothing_moves_says_so(idle: RunningCell) -> None:
    assert "nothing moves" in idle.visitor.command("stop").message
    assert idle.client.snapshot().state.state == "idle"


def test_cancel_places_the_part_on_its_way_and_leaves_what_stands(idle: RunningCell) -> None:
    begin(idle, height=3)
    idle.wait_state("assembling_placing")
    with pytest.raises(RefusedError, match="The operator began this job"):
        idle.visitor.command("cancel")
    idle.client.command("cancel")
    job = idle.finish()
    assert job.outcome == "cancelled"
    truth = idle.truth()
    assert len(truth.built) == 1
    assert truth.violations == ()
    idle.visitor.say("the letter L")
    assert "1 of 1 part stays" in idle.wait_state("validating_confirming").state.sentence
    idle.visitor.confirm(False)
    assert idle.finish().outcome == "declined"


def test_a_visitor_may_cancel_what_a_visitor_began(idle: RunningCell) -> None:
    idle.visitor.say("the letter T")
    idle.visitor.command("cancel")
    assert idle.finish().outcome == "cancelled"


def test_a_part_that_a_cancelled_job_left_in_the_gripper_is_built_into_the_next(
    idle: RunningCell,
) -> None:
    begin(idle)
    idle.wait("a part on its way", lambda now: now.gripper.holding == "part")
    idle.client.command("stop")
    idle.wait_state("paused_resting")
    with pytest.raises(RefusedError, match="A job is under way"):
        idle.client.command("clear")
    idle.client.command("cancel")
    job = idle.wait_state("paused_resting").job
    assert job is not None
    assert job.outcome == "cancelled"
    with pytest.raises(RefusedError, match="I stand still"):
        idle.visitor.say("the letter T")
    idle.client.command("resume")
    idle.wait_state("idle")
    begin(idle)
    assert idle.finish().outcome == "built"
    idle.assert_as_planned()


def test_what_makes_no_sense_is_refused_with_a_reason(idle: RunningCell) -> None:
    for command in ("resume", "reset", "cancel"):
        with pytest.raises(RefusedError):
            idle.client.command(command)
    with pytest.raises(RefusedError, match="I have not asked"):
        idle.client.confirm(True)
    with pytest.raises(RefusedError, match="operator"):
        idle.visitor.build("bar.json", bar(1, 1, 1))
    with pytest.raises(UsageError, match="empty"):
        idle.client.build("bar.json", b"")
    idle.client.build("bar.json", b"this is no plan")
    assert idle.finish().outcome == "unreadable"


def test_pause_in_idle_holds_new_jobs_until_resumed(idle: RunningCell) -> None:
    idle.client.command("pause")
    with pytest.raises(RefusedError, match="I stand still"):
        idle.visitor.say("the letter T")
    idle.client.command("resume")
    idle.wait_state("idle")
