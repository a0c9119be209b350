"""The programs as they are in the sources, compiled once."""

from __future__ import annotations

import subprocess

import pytest

from tests.leaks import REPOSITORY


@pytest.fixture(scope="session", autouse=True)
def binaries() -> None:
    """``firmware/build`` holds what the sources say."""
    subprocess.run(
        ["make", "--no-print-directory", "-s", "-C", REPOSITORY / "firmware"],
        check=True,
        timeout=120,
    )
