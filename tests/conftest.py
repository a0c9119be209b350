"""What every test gets: the watch over what is left behind, and the shared evaluation data."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

pytest_plugins = ["tests.leaks"]


@pytest.fixture(scope="session")
def test_data() -> Path:
    """The folder of recorded speech, meshes and requests that ``$CELLCTL_TEST_DATA`` names."""
    folder = os.environ.get("CELLCTL_TEST_DATA")
    if not folder:
        pytest.skip("CELLCTL_TEST_DATA is not set: the evaluation data is not at hand")
    path = Path(folder)
    if not path.is_dir():
        pytest.fail(f"CELLCTL_TEST_DATA={folder} is not a folder")
    return path
