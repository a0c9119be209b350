"""Whatever dies beside the daemon at any instant, the build is completed and no part is lost."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path

import psutil
import pytest

from cellctl.errors import RefusedError
from cellctl.messages import Snapshot
from cellctl.sim.world_values import ViolationKind
from tests.cell.harness import RunningCell, bar, running_cell

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]

_FARTHEST_S = 12.0
"""In cell time: two parts take about as long."""


@pytest.fixture(scope="module")
def cell() -> Iterator[RunningCell]:
    with running_cell(speed=10.0) as running:
        yield running


def kill_arm_process(cell: RunningCell) -> None:
    """The child that speaks with the robot."""
    for process in psutil.process_iter(["cmdline"]):
        line = process.info["cmdline"] or []
        if "cellctl.assembling.arm_worker" in line and _descends(process, cell):
            process.kill()


def _descends(process: psutil.Process, cell: RunningCell) -> bool:
    folder = str(Path(cell.config.journal.path).parent)
    return any(folder in " ".join(parent.cmdline()) for parent in process.parents())


def restart_board(cell: RunningCell) -> None:
    """The conveyor's."""
    cell.world.inject("board_reset")


def restart_gripper_board(cell: RunningCell) -> None:
    """The gripper's, whose latch stays where it is."""
    cell.world.inject("gripper_board_reset")


def restart_robot(cell: RunningCell) -> None:
    """The controller's supply fails for a moment."""
    cell.world.inject("power_lost")


DEATHS: dict[str, Callable[[RunningCell], None]] = {
    "the arm process": kill_arm_process,
    "the conveyor's board": restart_board,
    "the gripper's board": restart_gripper_board,
    "the robot's controller": restart_robot,
}


def wait_cell_s(cell: RunningCell, duration_s: float) -> None:
    """Let cell time pass, while the build goes on."""
    until_s = cell.truth().cell_time_s + duration_s
    cell.wait("cell time to pass", lambda _: cell.truth().cell_time_s >= until_s)


def go_on_to_the_end(cell: RunningCell) -> None:
    """An operator resets and resumes until the object stands."""

    def decided(now: Snapshot) -> bool:
        at_rest = now.state.state in {"fault_held", "fault_stopped", "paused_resting"}
        return at_rest or (now.state.state == "idle" and now.job is not None)

    closed_on_nothing = False
    while (now := cell.wait("the end, or a stop", decided)).state.state != "idle":
        if not now.doubt:
            assert_belief(cell, now)
        if now.fault.entry is not None and now.fault.entry.code == "gripper_holds":
            closed_on_nothing = True  # its output fell with the robot's supply
        elif closed_on_nothing and now.state.state == "paused_resting":
            cell.hand("open", part_held=True)
            closed_on_nothing = False
        command = "resume" if now.state.state == "paused_resting" else "reset"
        try:
            cell.client.command(command)
        except RefusedError:  # it has gone on by itself
            cell.listen()
            continue
        cell.wait("an answer", lambda later: later.state != now.state)
    job = cell.client.snapshot().job
    assert job is not None
    assert job.outcome == "built"
    forgive_the_latch(cell)
    cell.assert_as_planned()


def forgive_the_latch(cell: RunningCell) -> None:
    """When the robot's supply fails an open latch closes by itself, wherever it is."""
    held = cell.truth().violations
    if all(one.kind is ViolationKind.PICKED_NOTHING for one in held[cell.held_before :]):
        cell.held_before = len(held)


def assert_belief(cell: RunningCell, now: Snapshot) -> None:
    """What the cell believes of its structure is the case, once a cut-off act is settled.

    A latch that has closed by itself may have taken hold of the part that was just placed: what the
    status line tells of it is looked at before anything moves (``gripper_holds``).
    """
    truth = cell.truth()
    holding = now.gripper.holding
    if holding in {"nothing", "part"} and truth.latch["latched"] == (holding == "part"):
        assert set(now.standing) == set(truth.built)


def build_and_let_die(
    cell: RunningCell, die: Callable[[RunningCell], None], after_s: float, height: int
) -> None:
    cell.begin_test()
    cell.client.build("bar.json", bar(1, 1, height))
    cell.wait("a build", lambda now: now.state.state.startswith(("feeding", "assembling")))
    wait_cell_s(cell, after_s)
    die(cell)
    go_on_to_the_end(cell)
    cell.clear_workspace()


@pytest.mark.parametrize("what", DEATHS)
def test_a_death_beside_the_daemon(cell: RunningCell, what: str) -> None:
    instants = random.Random(what)  # noqa: S311 - which instants is of no consequence
    build_and_let_die(cell, DEATHS[what], instants.uniform(0.0, _FARTHEST_S), height=3)


@pytest.mark.soak
@pytest.mark.timeout(7200)
@pytest.mark.parametrize("what", DEATHS)
def test_deaths_beside_the_daemon(cell: RunningCell, what: str) -> None:
    instants = random.Random(f"many {what}")  # noqa: S311 - which instants is of no consequence
    for _ in range(40):
        build_and_let_die(cell, DEATHS[what], instants.uniform(0.0, _FARTHEST_S), height=3)
