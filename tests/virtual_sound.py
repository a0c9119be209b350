"""A sound server for tests, which this process and its children use instead of the computer's."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from cellctl.sim.microphone import VirtualMicrophone


@contextmanager
def virtual_sound() -> Iterator[VirtualMicrophone]:
    """Run one, and end it."""
    with (
        tempfile.TemporaryDirectory(prefix="vsnd-") as folder,
        VirtualMicrophone(Path(folder)) as virtual,
        pytest.MonkeyPatch.context() as patch,
    ):
        for name, value in virtual.environment.items():
            patch.setenv(name, value)
        yield virtual
