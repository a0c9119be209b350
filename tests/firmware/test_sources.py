"""The C sources keep the measures that linters keep for the rest."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.leaks import REPOSITORY

SOURCES = sorted(
    path
    for folder in (
        "firmware/common",
        "firmware/gripper",
        "firmware/conveyor",
        "tests/firmware/host",
    )
    for path in (REPOSITORY / folder).glob("*.[ch]")
)


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_a_source_keeps_to_its_measures(path: Path) -> None:
    lines = path.read_text(encoding="ascii").splitlines()
    assert len(lines) <= 260
    for number, line in enumerate(lines, 1):
        assert len(line) <= 100, f"line {number} is too long"
        assert line == line.rstrip(), f"line {number} ends with spaces"
        assert "\t" not in line, f"line {number} has a tab"


def test_only_the_board_files_touch_registers() -> None:
    touching = {
        f"{path.parent.name}/{path.name}"
        for path in SOURCES
        if "#include <avr/" in path.read_text(encoding="ascii")
    }
    assert touching == {
        "common/chip.c",
        "common/main.c",
        "conveyor/board.c",
        "conveyor/pins.h",
        "gripper/board.c",
        "gripper/pins.h",
    }
