"""The programs as they are in the sources, compiled once."""

from __future__ import annotations

import pytest

from tests.firmware.loop.bench import compile_programs


@pytest.fixture(scope="session", autouse=True)
def binaries() -> None:
    """``firmware/build`` holds what the sources say."""
    compile_programs()
