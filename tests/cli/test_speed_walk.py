"""``cellctl calibrate speed``: an object at one pace after another, in the emulated cell."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path

import pytest

from cellctl.assembling.route import RoutePlanner
from cellctl.assembly import (
    Assembly,
    BuildPlan,
    Cell,
    Change,
    Pace,
    PartOutcome,
    Role,
    Step,
    StepKind,
)
from cellctl.cli.calibrate_command import need_consent, offer, read_pace
from cellctl.cli.speed_walk import (
    PAPERS,
    Attempts,
    SpeedWalk,
    best,
    column,
    need_full_speed,
    need_ready,
    remarks_on,
    told_a_part,
    values_of,
)
from cellctl.client import CellClient
from cellctl.config import CellConfig, load_config
from cellctl.config.rewriting import rewritten
from cellctl.control.acts import JobFiles
from cellctl.control.job import Job
from cellctl.control.journal_rows import job_of, job_row
from cellctl.errors import ExitStatus, PlanError, RefusedError, UsageError
from cellctl.messages import (
    ArmData,
    ConveyorData,
    FaultData,
    GripperData,
    HealthData,
    JobData,
    Snapshot,
    StateData,
)
from cellctl.sim.isolation import write_config
from cellctl.validating.plan import plan_file
from cellctl.validating.trials import paced, plan_trial
from tests.cell.harness import CONFIG, RunningCell, cell_config, running_cell
from tests.cli.terminal import Terminal

ROW = [(2, 2, 0), (2, 2, 1), (3, 2, 1)]
"""Its last part hangs at the side of another."""
STOOD = (True, True, False, False, True, True, True, False)
"""Of the paper's table, in the order of ``PAPERS``."""


def attempts(speed_m_s: float, stood: int, told_s: float, tried: int = 2) -> Attempts:
    return Attempts(Pace(speed_m_s=speed_m_s, acceleration_m_s2=1.0), tried, stood, told_s)


def test_the_papers_eight_paces_in_the_order_of_its_table() -> None:
    assert [(pace.speed_m_s, pace.acceleration_m_s2) for pace in PAPERS] == [
        (1.0, 1.0), (1.5, 1.5), (2.0, 2.0), (2.5, 2.5),
        (1.0, 0.5), (1.5, 0.75), (2.0, 1.0), (2.5, 1.25),
    ]  # fmt: skip


def test_the_quickest_at_which_all_stood_is_chosen() -> None:
    sometimes, slow, quick = attempts(2.0, 1, 4.0), attempts(1.0, 2, 6.0), attempts(1.5, 2, 5.0)
    assert best([slow, sometimes, quick]) is quick
    assert best([sometimes, attempts(3.0, 0, 0.0, tried=0)]) is None


@pytest.mark.parametrize(
    ("speed_m_s", "acceleration_m_s2", "counts"),
    [(2.0, 2.0, False), (1.5, 1.0, False), (1.5, 0.9, True), (1.4, 3.0, True)],
)
def test_nothing_counts_that_is_as_fast_as_what_failed(
    speed_m_s: float, acceleration_m_s2: float, counts: bool
) -> None:
    slow, failed = attempts(1.0, 2, 6.0), attempts(1.5, 1, 5.0)
    lucky = Attempts(Pace(speed_m_s=speed_m_s, acceleration_m_s2=acceleration_m_s2), 2, 2, 4.0)
    assert best([slow, failed, lucky]) is (lucky if counts else slow)
    refused = failed._replace(tried=0, stood=0)
    assert best([slow, refused, lucky]) is lucky


def snapshot(**changes: object) -> Snapshot:
    """A cell that is idle and empty."""
    whole = Snapshot(
        seq=1,
        version="1",
        cell="cell",
        kind="emulated",
        grid=(6, 5, 6),
        state=StateData(state="idle", previous="starting", event="started"),
        job=None,
        plan=None,
        parts=(),
        standing=(),
        inventory={"unknown": 0},
        arm=ArmData(connected=True),
        conveyor=ConveyorData(connected=True),
        gripper=GripperData(holding="nothing"),
        fault=FaultData(),
        health=HealthData(uptime_s=1.0, loop_blocked_p99_s=0.0, loop_blocked_max_s=0.0, inbox=0),
        recogniser="none",
    )
    return whole.model_copy(update=changes)


def test_what_was_told_for_a_part_needs_every_part_felt() -> None:
    job = JobData(job_id="x", role=Role.OPERATOR, outcome="built", parts_total=2)
    parts = tuple(
        PartOutcome(step=z, cell=Cell(0, 0, z), seconds=9.0, waited_s=0.0, predicted_s=5.0 + z)
        for z in range(2)
    )
    assert told_a_part(snapshot(job=job, parts=parts)) == pytest.approx(5.5)
    for felt in (parts[:1], ()):
        with pytest.raises(RefusedError, match="interrupted before every part was felt"):
            told_a_part(snapshot(job=job, parts=felt))
    with pytest.raises(RefusedError, match="interrupted"):
        told_a_part(snapshot(job=job.model_copy(update={"parts_total": 0})))


def test_what_was_changed_or_is_in_question_is_shown_before_a_yes() -> None:
    job = JobData(
        job_id="x",
        role=Role.OPERATOR,
        changes=(Change(what="It is smaller.", why="The arm does not reach so far."),),
        questions=("Two legs?",),
    )
    assert remarks_on(job) == ["It is smaller. The arm does not reach so far.", "Two legs?"]
    assert remarks_on(JobData(job_id="x", role=Role.OPERATOR)) == []


def test_a_trial_needs_the_speed_slider_at_full_speed() -> None:
    need_ready(snapshot())
    need_full_speed(0.99)
    with pytest.raises(RefusedError, match="slider is at 50%"):
        need_ready(snapshot(arm=ArmData(connected=True, speed_fraction=0.5)))
    with pytest.raises(RefusedError, match="slider was at 98%"):
        need_full_speed(0.98)
    with pytest.raises(RefusedError, match="nothing stands"):
        need_ready(snapshot(standing=(Cell(0, 0, 0),)))


def test_paces_beyond_the_limits_of_the_cell_need_a_yes(
    capsys: pytest.CaptureFixture[str],
) -> None:
    settings = cell_config(robot={"travel_speed_m_s": 1.5, "travel_acceleration_m_s2": 1.0})
    within = [PAPERS[0], PAPERS[5]]
    asked: list[str] = []

    def answer(question: str) -> bool:
        asked.append(question)
        return len(asked) == 1

    need_consent(within, settings, answer)
    assert asked == []
    need_consent([*within, PAPERS[1]], settings, answer)
    shown = capsys.readouterr().out
    assert "   1.5 m/s and 1.5 m/s2\n" in shown
    assert str(PAPERS[0]) not in shown
    with pytest.raises(RefusedError, match="nothing was tried") as refused:
        need_consent(PAPERS, settings, answer)
    assert refused.value.exit_status == ExitStatus.USAGE


def test_it_is_written_as_the_limit_for_carrying(tmp_path: Path) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(CONFIG.read_text())
    values = values_of(attempts(1.5, 2, 5.0), "a #stool.glb")
    assert offer(file, values, lambda _: True) is True
    robot = load_config(file).robot
    assert (robot.carrying_speed_m_s, robot.carrying_acceleration_m_s2) == (1.5, 1.0)
    assert robot.carrying_measured.endswith("a  stool.glb, 2 of 2 stood at 1.5 m/s and 1 m/s2")
    again, _ = rewritten(file.read_text(), values, "again")
    assert again == file.read_text()


def test_a_long_name_is_cut_to_what_the_configuration_takes(tmp_path: Path) -> None:
    file = tmp_path / "cell.toml"
    file.write_text(CONFIG.read_text())
    assert offer(file, values_of(attempts(1.5, 2, 5.0), "n" * 200), lambda _: True) is True
    measured = load_config(file).robot.carrying_measured
    assert len(measured) == 200
    assert measured.endswith("nn, 2 of 2 stood at 1.5 m/s and 1 m/s2")


@pytest.mark.parametrize("text", ["", "1", "1,2,3", "fast,1", "0,1", "4,1", "1,nan"])
def test_what_is_no_pace_is_refused(text: str) -> None:
    with pytest.raises(UsageError, match="no pace"):
        read_pace(text)


class Standing:
    """A person at an emulated cell, who takes away what fell; at once where nothing else stands."""

    def __init__(self, cell: RunningCell, *, alone: bool = True) -> None:
        self._cell = cell
        self._alone = alone
        self.told: list[str] = []
        self.removals = 0

    def tell(self, text: str) -> None:
        self.told.append(text)

    def agreed(self, question: str) -> bool:
        raise AssertionError(f"nothing is in question in these trials: {question}")

    def removed(self, what: str) -> bool:
        assert "nothing is felt under the gripper" in what
        self.removals += 1
        if self._alone:
            self._cell.world.clear_workspace()
        return True


@pytest.fixture(scope="module")
def running() -> Iterator[RunningCell]:
    with running_cell(speed=10.0, limits={"inventory_parts": 16}) as running:
        yield running


@pytest.fixture
def cell(running: RunningCell) -> Iterator[RunningCell]:
    running.begin_test()
    yield running
    running.bring_back()


def walked(cell: RunningCell, paces: tuple[Pace, ...], parts: int) -> list[Attempts]:
    """What came of it; the world has seen the same, and no part was lost."""
    person = Standing(cell)
    content = column(cell.config.voxel.pitch_m, parts)
    found = SpeedWalk(cell.client, person, name="column.json", content=content).run(paces)
    fell = sum(one.stood < one.tried for one in found)
    assert person.removals == fell
    assert [told.kind for told in cell.truth().violations[cell.held_before :]] == ["jolted"] * fell
    assert cell.client.snapshot().standing == ()
    cell.assert_inventory_true()
    return found


@pytest.mark.wire
@pytest.mark.shared_cell
@pytest.mark.soak
def test_a_trial_that_is_stopped_goes_on_and_one_that_is_cancelled_ends(cell: RunningCell) -> None:
    pace = Pace(speed_m_s=1.5, acceleration_m_s2=1.5)
    content = column(cell.config.voxel.pitch_m)
    with CellClient.for_role(cell.config) as own, ThreadPoolExecutor(1) as pool:
        walk = SpeedWalk(own, Standing(cell), name="column.json", content=content)
        trial = pool.submit(walk.run, (pace,))
        cell.wait_mid_place()
        cell.visitor.command("stop")
        stopped = cell.wait_state("paused_resting")
        assert stopped.gripper.holding == "part"
        assert stopped.job is not None
        assert stopped.job.pace == pace
        cell.client.command("resume")
        (found,) = trial.result(cell.patience_s)
        assert found.stood == 1
        trial = pool.submit(walk.run, (pace,))
        cell.wait_mid_place()
        cell.client.command("cancel")
        with pytest.raises(RefusedError, match="not carried through"):
            trial.result(cell.patience_s)
    cell.wait_state("idle")
    assert len(cell.client.snapshot().standing) == len(cell.truth().built) == 1
    cell.assert_inventory_true()
    with pytest.raises(RefusedError, match="nothing stands"):
        SpeedWalk(cell.client, Standing(cell), name="column.json", content=content).run((pace,))


@pytest.mark.wire
@pytest.mark.shared_cell
@pytest.mark.soak
def test_a_part_that_hangs_beside_another_is_felt_by_the_latch(cell: RunningCell) -> None:
    pace = Pace(speed_m_s=1.0, acceleration_m_s2=1.0)
    content = Assembly.of([Cell(*c) for c in ROW], cell.config.voxel.pitch_m).model_dump_json()
    person = Standing(cell, alone=False)
    with CellClient.for_role(cell.config) as own, ThreadPoolExecutor(1) as pool:
        walk = SpeedWalk(own, person, name="row.json", content=content.encode())
        (found,) = walk.run((pace,))
        assert (found.tried, found.stood) == (1, 1)
        assert cell.truth().violations[cell.held_before :] == ()
        trial = pool.submit(walk.run, (pace,))
        cell.wait("two that stand", lambda now: len(now.standing) == 2)
        cell.wait_mid_place()
        cell.world.inject("part_dropped")
        (found,) = trial.result(cell.patience_s)
    assert (found.tried, found.stood, person.removals) == (1, 0, 1)
    held = {told.kind for told in cell.truth().violations[cell.held_before :]}
    assert held <= {"picked_nothing"}  # the latch closed where the part should have stood
    cell.world.clear_workspace()
    assert cell.client.snapshot().standing == ()
    cell.assert_inventory_true()


@pytest.mark.wire
@pytest.mark.soak
@pytest.mark.timeout(900)
@pytest.mark.parametrize("model", ["ur10e", "ur10"])
def test_all_eight_cells_of_the_papers_table_come_out(model: str) -> None:
    robot = {"model": model} | ({"rtde_frequency_hz": 125} if model == "ur10" else {})
    version = "3.15" if model == "ur10" else "5.12"
    with running_cell(
        speed=10.0,
        limits={"inventory_parts": 16},
        robot=robot,
        emulation={"controller_version": version},
    ) as cell:
        found = walked(cell, PAPERS, parts=2)
    assert [one.stood == 1 for one in found] == list(STOOD)
    chosen = best(found)
    assert chosen is not None
    assert (chosen.pace.speed_m_s, chosen.pace.acceleration_m_s2) == (1.5, 1.5)


@pytest.mark.parametrize(
    ("cells", "robot", "why"),
    [
        (ROW, {}, r"part at \[3, 2, 1\] stands could not be felt"),
        ([(2, 2, 0)], {"touch_depth_m": 0.0}, "could not be felt"),
        ([(2, 0, 0)], {"joint_speed_fraction": 0.25}, "too fast for the arm's joints"),
    ],
)
def test_a_trial_that_would_tell_nothing_is_refused(
    cells: list[tuple[int, int, int]], robot: dict[str, float], why: str
) -> None:
    with pytest.raises(PlanError, match=why):
        trial_of(cells, cell_config(robot=robot, gripper={"port": None}))


def trial_of(cells: list[tuple[int, int, int]], config: CellConfig) -> BuildPlan:
    """These cells, in this order, at the paper's quickest pace."""
    steps = tuple(
        Step(index=i, kind=StepKind.PLACE, cell=Cell(*cell)) for i, cell in enumerate(cells)
    )
    assembly = Assembly.of(cells, pitch_m=config.voxel.pitch_m)
    plan = BuildPlan(
        plan_id="x", title="x", pitch_m=assembly.pitch_m, assembly=assembly, steps=steps, checks=()
    )
    return paced(plan, Pace(speed_m_s=2.5, acceleration_m_s2=2.5), config)


def test_what_must_not_be_pressed_on_is_tried_where_the_gripper_feels_its_part() -> None:
    told = [step.duration_s for step in trial_of(ROW, cell_config()).steps]
    assert None not in told
    *columns, row = (duration_s or 0.0 for duration_s in told)
    planner = RoutePlanner(cell_config())
    costs_s = planner.finding_s(Cell(*ROW[-1]), [Cell(*cell) for cell in ROW[:-1]])
    assert costs_s > 2.0 * cell_config().gripper.latch_s
    assert row > costs_s + 0.5 * min(columns)


def test_a_trial_stands_in_the_middle_where_the_arm_bears_every_pace() -> None:
    config = cell_config()
    plan = plan_file("column.json", column(config.voxel.pitch_m), config)
    places = {tuple(step.cell for step in plan_trial(plan, pace, config).steps) for pace in PAPERS}
    assert places == {(Cell(2, 2, 0), Cell(2, 2, 1))}
    paces = [Pace(speed_m_s=v, acceleration_m_s2=v) for v in (1.0, 1.5)]
    slow, quick = (plan_trial(plan, pace, config).steps[0].duration_s for pace in paces)
    assert slow is not None
    assert quick is not None
    assert quick < slow - 0.5


def test_a_job_that_is_recalled_after_a_death_has_its_pace() -> None:
    pace = Pace(speed_m_s=2.0, acceleration_m_s2=1.0)
    job = Job.of_file("column.json", column(0.1), Role.OPERATOR, pace)
    job.began_at = datetime.now(UTC)
    kept = job_of(job_row(job.record()))
    assert Job.recalled(kept, JobFiles(upload=job.upload), frozenset()).pace == pace


@pytest.fixture
def file(cell: RunningCell, tmp_path: Path) -> Path:
    path = tmp_path / "cell.toml"
    write_config(cell.config, path)
    return path


@pytest.mark.wire
@pytest.mark.shared_cell
@pytest.mark.soak
def test_an_operator_at_a_terminal_has_the_limit_written(cell: RunningCell, file: Path) -> None:
    paces = ("--pace", "2.5,2.5", "--pace", "1,1")
    with Terminal(file, "calibrate", "speed", *paces) as terminal:
        terminal.see("   2.5 m/s and 2.5 m/s2")
        terminal.see("Is everybody out of reach")
        terminal.type("y")
        cell.wait("a fault", lambda now: now.fault.entry is not None)
        terminal.see("Take away what fell")
        cell.world.clear_workspace()
        terminal.type("y")
        cell.wait("it apart", lambda now: now.job is not None and now.job.outcome == "taken_apart")
        terminal.see("1 m/s and 1 m/s2: 1 of 1 stood")
        terminal.see("Write this?")
        terminal.type("y")
        terminal.see("Written; the file as it was")
        assert terminal.status() == 0
    robot = load_config(file).robot
    assert (robot.carrying_speed_m_s, robot.carrying_acceleration_m_s2) == (1.0, 1.0)
    assert "column of two.json, 1 of 1 stood" in robot.carrying_measured
    cell.assert_inventory_true()


@pytest.mark.wire
@pytest.mark.shared_cell
@pytest.mark.soak
def test_an_interrupt_cancels_the_trial_and_writes_nothing(cell: RunningCell, file: Path) -> None:
    before = file.read_text()
    with Terminal(file, "calibrate", "speed", "--pace", "1,1") as terminal:
        cell.wait_mid_place()
        terminal.interrupt()
        terminal.see("Cancelling the trial.")
        assert terminal.status() != 0
    cell.wait("the end", lambda now: now.job is not None and now.job.outcome == "cancelled")
    assert file.read_text() == before
    cell.wait_state("idle")
    cell.assert_inventory_true()
