"""``scripts/flash``: what it has the programmer do, and what it refuses to begin."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.leaks import REPOSITORY

AVRDUDE = """#!/bin/bash
printf '%s\\n' "$@" >"$LOG"
"""
FUSES = bytes.fromhex("0645020000c5070000")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A copy of the script with compiled images and a programmer that only takes notes."""
    (tmp_path / "scripts").mkdir()
    (tmp_path / "bin").mkdir()
    shutil.copy(REPOSITORY / "scripts" / "flash", tmp_path / "scripts" / "flash")
    avrdude = tmp_path / "bin" / "avrdude"
    avrdude.write_text(AVRDUDE)
    avrdude.chmod(0o755)
    images = tmp_path / "firmware" / "build"
    images.mkdir(parents=True)
    for board in ("gripper", "conveyor"):
        (images / f"{board}.hex").write_text("")
        (images / f"{board}.fuses").write_bytes(FUSES)
    return tmp_path


def flash(project: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        ["bash", project / "scripts" / "flash", *arguments],
        env={"PATH": f"{project}/bin:/usr/bin:/bin", "LOG": str(project / "log")},
        capture_output=True,
        text=True,
        check=False,
        timeout=30,
    )


@pytest.mark.parametrize(("board", "chip"), [("gripper", "t412"), ("conveyor", "t1604")])
def test_it_writes_fuses_and_program_by_serial_updi(project: Path, board: str, chip: str) -> None:
    ours, theirs = os.openpty()
    try:
        port = os.ttyname(theirs)
        assert flash(project, board, port).returncode == 0
    finally:
        os.close(ours)
        os.close(theirs)
    said = (project / "log").read_text().split()
    assert said[:7] == ["-c", "serialupdi", "-p", chip, "-P", port, "-e"]
    assert said[7::2] == ["-U"] * 8
    assert said[8::2] == [
        *(f"fuse{number}:w:0x{FUSES[number]:02x}:m" for number in (0, 1, 2, 5, 6, 7, 8)),
        f"flash:w:firmware/build/{board}.hex:i",
    ]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("arm", "/dev/null"), "there is no board 'arm'"),
        (("gripper",), "which port?"),
        (("gripper", ""), "which port?"),
        (("gripper", "/dev/no-such-port"), "is no serial port"),
        (("gripper", "/etc/passwd"), "is no serial port"),
    ],
)
def test_it_says_what_is_wrong_and_writes_nothing(
    project: Path, arguments: tuple[str, ...], message: str
) -> None:
    done = flash(project, *arguments)
    assert done.returncode == 1
    assert message in done.stderr
    assert not (project / "log").exists()


def test_it_asks_for_images_that_are_missing(project: Path) -> None:
    (project / "firmware" / "build" / "gripper.hex").unlink()
    done = flash(project, "gripper", "/dev/null")
    assert done.returncode == 1
    assert "run make firmware" in done.stderr
