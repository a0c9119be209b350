"""Programs that are compiled once for all tests that use them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.firmware.host_program import compile_program


@pytest.fixture(scope="session")
def programs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of compiled programs for this computer."""
    return tmp_path_factory.mktemp("host")


@pytest.fixture(scope="session")
def lines(programs: Path) -> Path:
    """``host/lines.c``, compiled."""
    return compile_program("lines", programs)


@pytest.fixture(scope="session")
def gripper_program(programs: Path) -> Path:
    """``host/gripper_board.c``, compiled."""
    return compile_program("gripper_board", programs)


@pytest.fixture(scope="session")
def conveyor_program(programs: Path) -> Path:
    """``host/conveyor_board.c``, compiled."""
    return compile_program("conveyor_board", programs)
