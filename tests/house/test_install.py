"""Installing as a service: what lands where, what stays, what goes. Into a folder, without root."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.house.test_environment import entries
from tests.leaks import REPOSITORY

PYTHON = """#!/bin/bash
# Stands in for a Python that could do everything, and writes down what it was asked.
printf '%s\\n' "$*" >>"$LOG"
case "$*" in
    *"-m venv"*)
        mkdir -p "${@: -1}/bin" && cp "$0" "${@: -1}/bin/python"
        printf '#!%s/bin/python\\n' "${@: -1}" >"${@: -1}/bin/cellctl" ;;
    *) exit "${TOO_OLD:-0}" ;;
esac
"""
INSTALLED = {
    "etc/cellctl/cell.toml",
    "etc/systemd/system/cellctl-browser@.service",
    "etc/systemd/system/cellctl-kiosk.service",
    "etc/systemd/system/cellctl-models.service",
    "etc/systemd/system/cellctl-screen.service",
    "etc/systemd/system/cellctl.service",
    "etc/sysusers.d/cellctl.conf",
    "etc/tmpfiles.d/cellctl.conf",
    "etc/udev/rules.d/70-cellctl-boards.rules",
    "usr/local/bin/cellctl",
}
KEPT = {"etc/cellctl/cell.toml", "etc/udev/rules.d/70-cellctl-boards.rules"}


class Target:
    """A folder to install into."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / "root"
        self.root.mkdir()
        self.log = folder / "log"
        self.python = folder / "python3.11"
        self.python.write_text(PYTHON)
        self.python.chmod(0o755)

    def run(self, *command: str, **variables: str) -> subprocess.CompletedProcess[str]:
        """Run a make target or a script of the repository."""
        self.log.write_text("")
        return subprocess.run(
            command,
            cwd=REPOSITORY,
            env={
                "PATH": os.defpath,
                "LOG": str(self.log),
                "PYTHON": str(self.python),
                "DESTDIR": str(self.root),
                **variables,
            },
            capture_output=True,
            text=True,
            check=False,
            timeout=60,
        )

    def files(self) -> set[str]:
        """Files and links in it."""
        return {
            str(path.relative_to(self.root))
            for path in self.root.rglob("*")
            if path.is_symlink() or path.is_file()
        }


@pytest.fixture
def target(tmp_path: Path) -> Target:
    made = Target(tmp_path)
    result = made.run("make", "-s", "install")
    assert result.returncode == 0, result.stderr
    return made


def test_everything_lands_in_its_place_and_needs_the_repository_no_more(target: Target) -> None:
    files = target.files()
    assert files >= INSTALLED
    assert "opt/cellctl/venv/bin/cellctl" in files
    assert "opt/cellctl/docs/how-to/operator.md" in files
    assert "opt/cellctl/config/ur10.toml" in files
    others = {name for name in files - INSTALLED if not name.startswith("opt/cellctl/")}
    assert others == set()
    link = (target.root / "usr/local/bin/cellctl").readlink()
    assert link == Path("/opt/cellctl/venv/bin/cellctl")
    script = target.root / "opt/cellctl/venv/bin/cellctl"
    assert script.read_text() == "#!/opt/cellctl/venv/bin/python\n"
    installs = [line for line in target.log.read_text().splitlines() if "pip install" in line]
    assert len(installs) == 3
    assert "--require-hashes --no-deps -r requirements-build.lock" in installs[0]
    assert "--require-hashes" in installs[1]
    assert "requirements-service.lock" in installs[1]
    assert "--editable" not in installs[2]
    for name in INSTALLED - {"usr/local/bin/cellctl"}:
        text = (target.root / name).read_text()
        assert str(REPOSITORY) not in text
        assert str(target.root) not in text


def test_an_upgrade_leaves_what_a_person_wrote(target: Target) -> None:
    for name in KEPT:
        (target.root / name).write_text("mine")
    unit = target.root / "etc/systemd/system/cellctl.service"
    unit.write_text("old")
    result = target.run("make", "-s", "install")
    assert result.returncode == 0, result.stderr
    assert all((target.root / name).read_text() == "mine" for name in KEPT)
    assert "WatchdogSec=" in unit.read_text()
    assert "left /etc/cellctl/cell.toml as it is" in result.stderr


def test_uninstall_leaves_configuration_and_state_and_purge_does_not(target: Target) -> None:
    journal = target.root / "var/lib/cellctl/journal.db"
    journal.parent.mkdir(parents=True)
    journal.write_text("journal")
    result = target.run("make", "-s", "uninstall")
    assert result.returncode == 0, result.stderr
    assert target.files() == {*KEPT, "var/lib/cellctl/journal.db"}
    assert "left /etc/cellctl" in result.stderr
    result = target.run("make", "-s", "uninstall", "PURGE=1")
    assert result.returncode == 0, result.stderr
    assert target.files() == set()


def test_another_prefix_is_written_into_the_units(tmp_path: Path) -> None:
    target = Target(tmp_path)
    result = target.run("make", "-s", "install", PREFIX="/srv/cell")
    assert result.returncode == 0, result.stderr
    unit = (target.root / "etc/systemd/system/cellctl.service").read_text()
    assert "ExecStart=/srv/cell/venv/bin/cellctl run" in unit
    assert "/opt/cellctl" not in unit
    result = target.run("make", "-s", "install", PREFIX="relative")
    assert result.returncode != 0
    assert "PREFIX=relative must be an absolute path" in result.stderr


def test_a_python_that_the_service_could_not_use_is_refused(tmp_path: Path) -> None:
    target = Target(tmp_path)
    result = target.run("make", "-s", "install", TOO_OLD="1")
    assert result.returncode != 0
    assert "outside of home folders" in result.stderr
    assert target.files() == set()


def test_the_service_gets_the_versions_that_are_tested() -> None:
    tested = {str(requirement): hashes for requirement, hashes in entries("requirements.lock")}
    service = {str(wish): hashes for wish, hashes in entries("requirements-service.lock")}
    assert {name: tested.get(name) for name in service} == service
    names = {re.split(r"[=;\s]", name)[0] for name in service}
    assert names.isdisjoint({"pytest", "mypy", "ruff", "hypothesis"})
