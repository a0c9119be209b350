"""Faults of the journal, each in a daemon of its own: the way out needs no restart of it."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import psutil
import pytest

from cellctl.config import CellConfig
from cellctl.sim.client import SimClient
from cellctl.sim.isolation import isolated
from cellctl.sim.spawn import emulated_cell
from tests.cell.faulty import begin, expect_fault, finish_as_planned, reset_and_resume
from tests.cell.harness import RunningCell, cell_config, watched_daemon

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]

FULL_AT_BYTES = 1 << 16
"""The journal of a new daemon is larger after some acts, and its log is smaller."""


class Workplace:
    """One emulated cell, whose daemons come and go."""

    def __init__(self, config: CellConfig, folder: Path, world: SimClient) -> None:
        self.config = config
        self.folder = folder
        self.world = world
        self.journal = Path(self.config.journal.path)

    def daemon(self) -> AbstractContextManager[RunningCell]:
        """One that has just begun to start."""
        return watched_daemon(self.config, self.folder, self.world)

    def cellctl(self, *arguments: str) -> str:
        """What the command prints, beside the daemon."""
        done = subprocess.run(
            [sys.executable, "-m", "cellctl", *arguments, "--config", self.folder / "cell.toml"],
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout


@pytest.fixture(scope="module")
def workplace() -> Iterator[Workplace]:
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        config = isolated(cell_config(), Path(name), 10.0)
        with emulated_cell(config, 10.0) as world:
            yield Workplace(config, Path(name), world)


def test_a_full_disk_in_mid_build(workplace: Workplace) -> None:
    with workplace.daemon() as cell:
        cell.wait_state("idle")
        daemon = psutil.Process(cell.daemon.process.pid)
        daemon.rlimit(psutil.RLIMIT_FSIZE, (FULL_AT_BYTES, psutil.RLIM_INFINITY))
        begin(cell, nz=4)
        expect_fault(cell, "journal_failed")
        assert (workplace.folder / "daemon.log").stat().st_size < FULL_AT_BYTES
        reset_and_resume(cell)  # what has happened is written down
        expect_fault(cell, "journal_failed")  # and nothing more can be: nobody has made room
        daemon.rlimit(psutil.RLIMIT_FSIZE, (psutil.RLIM_INFINITY, psutil.RLIM_INFINITY))
        reset_and_resume(cell)
        finish_as_planned(cell)
        cell.clear_workspace()


def test_a_damaged_journal(workplace: Workplace) -> None:
    with workplace.daemon() as cell:
        cell.wait_state("idle")
        begin(cell)
        cell.wait_mid_place()
    workplace.journal.write_bytes(b"not a journal" * 5_000)
    with workplace.daemon() as cell:
        expect_fault(cell, "journal_damaged")
        cell.client.command("reset")
        expect_fault(cell, "journal_damaged")
        assert "Take out what stands" in workplace.cellctl("journal", "new", "--yes")
        reset_and_resume(cell)
        # The new one does not know of the part that was on its way.
        expect_fault(cell, "gripper_holds")
        cell.world.inject("part_dropped")  # the operator holds it
        cell.world.inject("output_changed", line=0, high=True)
        reset_and_resume(cell)
        cell.wait_state("idle")
        cell.clear_workspace()
        cell.begin_test()
        begin(cell)
        finish_as_planned(cell)
