"""``make test-hil`` by itself: the same suites, on an emulated cell that ``cellctl sim`` runs."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from cellctl.sim.client import SimClient
from cellctl.sim.isolation import isolated, write_config
from cellctl.sim.spawn import emulated_cell
from tests.cell.harness import cell_config
from tests.firmware.loop.bench import compile_programs
from tests.leaks import REPOSITORY

pytestmark = [pytest.mark.wire, pytest.mark.timeout(330)]

SPEED = 3.0
"""Slow enough that the belt is still under way when it has missed its host for long enough."""
PATIENCE_S = 150.0
MOVING = 4
"""Tests that ask before something moves."""


@contextmanager
def cell(speed: float = SPEED, **emulation: str) -> Iterator[tuple[SimClient, Path]]:
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        own = isolated(cell_config(emulation=emulation), Path(name), speed)
        path = Path(name) / "cell.toml"
        write_config(own, path)
        with emulated_cell(own, speed) as world:
            yield world, path


def suites(path: Path, answer: str) -> subprocess.CompletedProcess[str]:
    """Run them with an operator who always answers the same."""
    return subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-s", "-p", "no:cacheprovider", "tests/hil"],
        cwd=REPOSITORY,
        env={**os.environ, "CELLCTL_HIL_CONFIG": str(path)},
        input=f"{answer}\n" * 10,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )


def test_the_suites_move_nothing_unasked_and_pass_on_an_emulated_cell() -> None:
    with cell() as (world, path):
        before = world.truth()
        refused = suites(path, "no")
        between = world.truth()
        allowed = suites(path, "yes")
        after = world.truth()
    assert refused.returncode == 0, refused.stdout + refused.stderr
    assert f"{MOVING} skipped" in refused.stdout.splitlines()[-1], refused.stdout
    assert between.conveyor["motions"] == 0
    assert between.latch == before.latch
    assert between.robot["outputs"] == before.robot["outputs"]
    assert between.parts == before.parts
    assert allowed.returncode == 0, allowed.stdout + allowed.stderr
    assert "skipped" not in allowed.stdout.splitlines()[-1], allowed.stdout
    assert allowed.stdout.count("[yes/no]") == MOVING + 1
    assert len(after.built) == 1, "no part was placed"
    assert not after.violations


@pytest.mark.soak
def test_the_suites_pass_on_the_compiled_programs_at_real_speed() -> None:
    compile_programs()
    with cell(1.0, firmware="elf") as (world, path):
        done = suites(path, "yes")
        truth = world.truth()
    assert done.returncode == 0, done.stdout + done.stderr
    assert "skipped" not in done.stdout.splitlines()[-1], done.stdout
    assert len(truth.built) == 1, "no part was placed"
    assert not truth.violations
