"""``cellctl history``, ``journal`` and ``inventory`` as a person types them."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
import structlog

from cellctl.assembly import BuildPlan
from cellctl.cli.app import main
from cellctl.cli.plan_command import make_plan
from cellctl.config import load_config
from cellctl.control.acts import ActKind, JobFiles
from cellctl.feeding.inventory import Move
from cellctl.mesh import GeneratedMesh
from cellctl.sim.isolation import write_config
from cellctl.validating.files import load_mesh, load_plan
from tests.control.journals import CELLS, JumpingClock, opened, place, record, tower
from tests.leaks import REPOSITORY

CONFIG = load_config(REPOSITORY / "config" / "sim.toml")


class Terminal:
    """A person at a terminal, with a configuration whose journal lies in a folder."""

    def __init__(self, folder: Path, capture: pytest.CaptureFixture[str]) -> None:
        self._capture = capture
        self.journal = folder / "journal.db"
        self.config = folder / "cell.toml"
        section = CONFIG.journal.model_copy(update={"path": str(self.journal), "keep_days": 1.0})
        bus = CONFIG.bus.model_copy(
            update={name: f"ipc://{folder}/{name}" for name in ("status", "visitor", "operator")}
        )
        write_config(CONFIG.model_copy(update={"journal": section, "bus": bus}), self.config)

    def type(self, *arguments: str, status: int = 0) -> str:
        """Run a command; returns what it printed, errors included."""
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv("CELLCTL_CONFIG", str(self.config))
            patch.setattr(sys, "argv", ["cellctl", *arguments])
            with pytest.raises(SystemExit) as ended:
                main()
        printed = self._capture.readouterr()
        assert (ended.value.code or 0) == status, printed
        return printed.out + printed.err


@pytest.fixture
def terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Iterator[Terminal]:
    yield Terminal(tmp_path, capsys)
    structlog.reset_defaults()  # a command may have set the log up


def fill(path: Path, plan: BuildPlan) -> None:
    """A stool that was built, and a job that is not finished."""
    corners = np.array([[0.0, 0, 0], [0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.1]])
    mesh = GeneratedMesh(
        vertices=corners,
        faces=np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
        metric=True,
        title="stool",
        provenance="a test",
        stated_dimensions_m={},
    )

    async def work() -> None:
        clock = JumpingClock(datetime(2026, 5, 1, tzinfo=UTC))
        async with opened(path, clock) as journal:
            journal.keep_job(record("stool", plan=plan), JobFiles(mesh=mesh))
            await place(journal, CELLS[0], "stool")
            clock.jump(minutes=5)
            ended = record("stool", plan=plan, finished_at=clock.now, outcome="built")
            journal.keep_job(ended)
            await journal.record(ActKind.MISSING, cell=CELLS[0], moves=(Move.LOSE_PLACED,))
            journal.keep_job(record("open", plan=None, phase="generating"))

    asyncio.run(work())


def test_history_lists_jobs_and_acts(terminal: Terminal) -> None:
    fill(terminal.journal, tower(3))
    newest, oldest = json.loads(terminal.type("history", "--json"))
    assert (newest["job_id"], oldest["job_id"]) == ("open", "stool")
    assert oldest["what"] == '"Build me a tower."'
    assert oldest["config_sha256"] == "c0ffee" * 10
    lines = terminal.type("history", "--limit", "1").splitlines()
    assert len(lines) == 2
    assert "open (generating)" in lines[1]
    shown = terminal.type("history", "stool")
    assert "release part 1 at [0, 0, 0]: done (place)" in shown
    assert "built" in shown
    assert "no job nonsense" in terminal.type("history", "nonsense", status=2)


def test_a_job_can_be_built_again(terminal: Terminal, tmp_path: Path) -> None:
    plan = make_plan("Build me a stool with three legs.", CONFIG)
    fill(terminal.journal, plan)
    again, mesh = tmp_path / "again.json", tmp_path / "again.ply"
    terminal.type("history", "stool", "--save-plan", str(again), "--save-mesh", str(mesh))
    assert load_plan(again) == plan
    replanned = make_plan(str(again), CONFIG)
    assert replanned.plan_id == plan.plan_id
    for step, before in zip(replanned.steps, plan.steps, strict=True):
        # The order is judged anew, and what was proven in its mirror image anew as well.
        assert step.margin == pytest.approx(before.margin, rel=0.05)
        assert step == before.model_copy(update={"margin": step.margin})
    found = load_mesh(mesh)
    assert found.vertices.max(axis=0) == pytest.approx([0.3, 0.2, 0.1])
    glb = tmp_path / "again.glb"
    terminal.type("history", "stool", "--save-mesh", str(glb))
    assert load_mesh(glb).vertices.max(axis=0) == pytest.approx([0.3, 0.2, 0.1])


def test_the_journal_is_looked_after_offline(terminal: Terminal) -> None:
    assert "there is no journal yet" in terminal.type("journal", "check", status=2)
    fill(terminal.journal, tower(3))
    assert "sound. 2 jobs, 4 acts, 40 parts" in terminal.type("journal", "check")
    assert "nothing to save" in terminal.type("journal", "new", "--yes", status=2)
    # The jobs are among the newest; what belongs to none is older than a day.
    assert terminal.type("journal", "prune") == "1 jobs and acts were removed.\n"
    counted = json.loads(terminal.type("inventory", "--json"))
    assert (counted["belt"], counted["unknown"], counted["total"]) == (29, 1, 40)

    async def daemon() -> str:
        async with opened(terminal.journal):
            return terminal.type("journal", "new", "--forget", "--yes", status=2)

    assert f"process {os.getpid()} uses this journal" in asyncio.run(daemon())


def test_a_damaged_journal_is_saved_by_a_person_only(terminal: Terminal) -> None:
    fill(terminal.journal, tower(3))
    content = terminal.journal.read_bytes()
    damaged = content.replace(b'"act_id":2', b'"act_id":9')
    terminal.journal.write_bytes(damaged)
    shown = terminal.type("journal", "check", status=5)
    assert "checksum of act 2 is wrong" in shown
    assert "cellctl journal new" in shown
    assert terminal.journal.read_bytes() == damaged
    shown = terminal.type("journal", "new", "--yes")
    assert "Saved: 2 jobs, 3 acts, 40 parts (40 unknown)." in shown
    assert "cellctl inventory set" in shown
    assert "sound" in terminal.type("journal", "check")
    (aside,) = terminal.journal.parent.glob("journal.db.damaged-*[0-9]")
    assert aside.read_bytes() == damaged
    shown = terminal.type("journal", "new", "--forget", "--yes")
    assert "40 parts (40 belt)" in shown
