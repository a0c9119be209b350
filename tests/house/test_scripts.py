"""The scripts that set up and check: what they do, and what they leave alone the second time."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.leaks import REPOSITORY

PYTHON = """#!/bin/bash
# Stands in for a Python that could do everything, and writes down what it was asked.
printf '%s\\n' "$*" >>"$LOG"
case "$*" in
    *"-m venv"*) mkdir -p .venv/bin && cp "$0" .venv/bin/python ;;
    *version_info*) exit "${TOO_OLD:-0}" ;;
esac
"""

BUILD = """#!/bin/bash
# Stands in for the building of the simulator, once.
[[ -e $1/simulator ]] || { mkdir "$1/simulator" && echo "pip install simulator" >>"$LOG"; }
"""


class Project:
    """A copy of what ``scripts/setup`` looks at, with a Python that only takes notes."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.log = root / "log"
        (root / "scripts").mkdir()
        (root / "bin").mkdir()
        simulator = root / "firmware" / "simulator"
        simulator.mkdir(parents=True)
        (simulator / "build").write_text(BUILD)
        (simulator / "build").chmod(0o755)
        shutil.copy(REPOSITORY / "scripts" / "setup", root / "scripts" / "setup")
        for name in ("pyproject.toml", "requirements.lock", "requirements-build.lock"):
            (root / name).write_text(name)
        python = root / "bin" / "python3.11"
        python.write_text(PYTHON)
        python.chmod(0o755)

    def setup(self, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
        """Run it in an almost empty environment; the log starts anew."""
        self.log.write_text("")
        return subprocess.run(
            ["bash", "scripts/setup", *arguments],
            cwd=self.root,
            env={"PATH": f"{self.root}/bin:/usr/bin:/bin", "LOG": str(self.log), **variables},
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )

    @property
    def installs(self) -> list[str]:
        return [line for line in self.log.read_text().splitlines() if "pip install" in line]


@pytest.fixture
def project(tmp_path: Path) -> Project:
    return Project(tmp_path)


def test_setup_installs_from_the_locks_by_hash(project: Project) -> None:
    result = project.setup()
    assert result.returncode == 0, result.stderr
    build, locked, itself = project.installs
    assert "--require-hashes --no-deps -r requirements-build.lock" in build
    assert "--require-hashes --no-deps --no-build-isolation -r requirements.lock" in locked
    assert "--no-index --editable ." in itself
    assert "making .venv" in result.stderr
    assert "installing the locked Python packages" in result.stderr


def test_only_the_tests_need_the_simulator(project: Project) -> None:
    project.setup()
    assert "pip install simulator" not in project.installs
    assert project.setup("--test").returncode == 0
    assert project.installs == ["pip install simulator"]


@pytest.mark.parametrize("arguments", [(), ("--test",)])
def test_a_second_run_installs_nothing_and_says_nothing(
    project: Project, arguments: tuple[str, ...]
) -> None:
    project.setup(*arguments)
    result = project.setup(*arguments)
    assert result.returncode == 0
    assert project.installs == []
    assert result.stdout + result.stderr == ""


@pytest.mark.parametrize("name", ["requirements.lock", "requirements-build.lock", "pyproject.toml"])
def test_a_change_of_what_is_wanted_installs_again(project: Project, name: str) -> None:
    project.setup()
    (project.root / name).write_text("changed")
    result = project.setup()
    assert len(project.installs) == 3
    assert "making .venv" not in result.stderr


def test_a_run_that_was_cut_off_is_repeated(project: Project) -> None:
    project.setup()
    (project.root / ".venv" / "cellctl-setup").unlink()
    project.setup()
    assert len(project.installs) == 3


def test_a_python_that_does_not_fit_is_named(project: Project) -> None:
    result = project.setup(PYTHON="python3.11", TOO_OLD="1")
    assert result.returncode == 1
    assert "PYTHON=python3.11 is not a Python 3.11, 3.12 or 3.13" in result.stderr
    assert project.installs == []


CI_MAKEFILE = """test:
\t@echo "data: $(CELLCTL_TEST_DATA)"
\t@exit $(STATUS)
"""


@pytest.mark.parametrize("status", [0, 3])
@pytest.mark.parametrize("at_hand", [True, False])
def test_ci_finds_the_data_and_fails_when_a_test_does(
    tmp_path: Path, status: int, at_hand: bool
) -> None:
    root = tmp_path / "project"
    (root / ".ci").mkdir(parents=True)
    shutil.copy(REPOSITORY / ".ci" / "run", root / ".ci" / "run")
    (root / "Makefile").write_text(CI_MAKEFILE)
    data = tmp_path / "shared" / "data"
    if at_hand:
        data.mkdir(parents=True)
    result = subprocess.run(
        [root / ".ci" / "run"],
        cwd="/",
        env={"PATH": os.defpath, "STATUS": str(status)},
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert (result.returncode == 0) == (status == 0)
    assert result.stdout.splitlines()[0] == f"data: {data if at_hand else ''}"


def test_make_alone_lists_the_targets() -> None:
    result = subprocess.run(
        ["make", "-s"],
        cwd=REPOSITORY,
        env={"PATH": os.defpath},
        capture_output=True,
        text=True,
        check=True,
    )
    for target in ("demo", "test", "soak", "lint", "format", "docs", "lock", "clean"):
        assert f"make {target} " in result.stdout
