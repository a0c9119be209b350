"""The other robot: a UR10 on a CB3 controller at 125 Hz, which feels without a force sensor."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.cell.faulty import begin, expect_fault, finish_as_planned, reset, reset_and_resume
from tests.cell.harness import RunningCell, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]


@pytest.fixture(scope="module")
def running() -> Iterator[RunningCell]:
    with running_cell(
        speed=10.0,
        robot={"model": "ur10", "rtde_frequency_hz": 125},
        emulation={"controller_version": "3.15"},
    ) as cell:
        yield cell


@pytest.fixture
def cell(running: RunningCell) -> Iterator[RunningCell]:
    running.begin_test()
    yield running
    running.bring_back()


def placing_the_second(cell: RunningCell) -> dict[str, int]:
    """Where the first of two parts stands; the arm brings the second, which goes on top."""
    begin(cell)
    cell.wait("one that stands", lambda now: len(now.standing) == 1)
    (below,) = cell.truth().built
    cell.wait_mid_place()
    return {"x": below.x, "y": below.y, "z": below.z}


def test_a_ur10_at_125_hz_builds_the_letter_t(cell: RunningCell) -> None:
    cell.visitor.say("the letter T")
    assert cell.finish().outcome == "built"
    cell.assert_as_planned()


def test_a_part_below_stands_too_high(cell: RunningCell) -> None:
    where = placing_the_second(cell)
    cell.world.inject("part_raised", **where)
    expect_fault(cell, "contact_early")
    assert "above where the arm is told to be" in cell.client.snapshot().fault.detail
    assert cell.client.snapshot().gripper.holding == "part"
    assert cell.truth().violations[cell.held_before :] == ()
    reset(cell)
    assert "The TCP is at" in cell.hand("rise")
    cell.world.clear("part_raised", **where)  # somebody takes the crumb away
    cell.client.command("resume")
    finish_as_planned(cell)


def test_a_part_that_sticks_to_the_gripper_is_not_torn_off(cell: RunningCell) -> None:
    placing_the_second(cell)
    cell.world.inject("part_sticks")
    expect_fault(cell, "part_stuck")
    assert "below where the arm is told to be" in cell.client.snapshot().fault.detail
    assert len(cell.truth().built) == 2
    assert cell.truth().violations[cell.held_before :] == ()
    cell.world.clear("part_sticks")  # a person frees it
    reset_and_resume(cell)
    finish_as_planned(cell)


def test_nothing_is_under_the_part_that_is_to_be_let_go(cell: RunningCell) -> None:
    where = placing_the_second(cell)
    cell.world.inject("part_taken", **where)
    expect_fault(cell, "not_seated")
    assert "0.30 mm are due" in cell.client.snapshot().fault.detail
    assert cell.client.snapshot().gripper.holding == "part"
    assert cell.truth().violations[cell.held_before :] == ()
    reset(cell)
