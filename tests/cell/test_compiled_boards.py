"""Whole cells with the compiled programs of both boards in the loop."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cellctl.sim.world_values import Where
from tests.cell.faulty import begin, finish_as_planned, reset_and_resume
from tests.cell.harness import RunningCell, running_cell
from tests.firmware.loop.bench import compile_programs

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]
COMPILED = {"firmware": "elf"}


@pytest.fixture(scope="module", autouse=True)
def programs() -> None:
    """The programs are those of the sources."""
    compile_programs()


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    """At twice real speed: the boards' own times cannot be stretched."""
    with running_cell(speed=2.0, emulation=COMPILED) as running:
        yield running


def test_an_object_is_built_though_both_programs_hang_on_the_way(cell: RunningCell) -> None:
    cell.begin_test()
    begin(cell, 2, 1, 1)
    cell.wait_mid_place()
    cell.world.inject("gripper_board_hang")
    cell.world.inject("board_hang", interrupts=False)
    held = cell.wait_state("fault_held")
    assert held.fault.entry is not None
    assert held.fault.entry.code == "gripper_reset"
    assert cell.truth().counts[Where.GRIPPER] == 1
    reset_and_resume(cell)
    finish_as_planned(cell)
    truth = cell.truth()
    assert truth.gripper_board["resets"] == cell.client.snapshot().gripper.resets == 1
    assert truth.conveyor["resets"] == 1


@pytest.mark.soak
def test_a_stool_is_built_as_planned() -> None:
    with running_cell(speed=1.0, patience_s=1200.0, emulation=COMPILED) as slow:
        slow.begin_test()
        slow.visitor.say("I want a simple stool")
        assert slow.finish().outcome == "built"
        slow.assert_as_planned()
        lost_s = slow.truth().lost_s
        seconds = [part.seconds for part in slow.client.snapshot().parts]
        each_s = sum(seconds) / len(seconds)
        print(f"{len(seconds)} parts, {each_s:.2f} s a part, {lost_s:.1f} s lost")  # noqa: T201
