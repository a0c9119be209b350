"""A private sound server with a loudspeaker, and the mouth behind it."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from cellctl.sim.microphone import VirtualMicrophone


@pytest.fixture
def room(monkeypatch: pytest.MonkeyPatch) -> Iterator[VirtualMicrophone]:
    """A sound server that this process and its children use."""
    folder = Path(tempfile.mkdtemp(prefix="vspk-"))
    try:
        with VirtualMicrophone(folder) as virtual:
            for name, value in virtual.environment.items():
                monkeypatch.setenv(name, value)
            yield virtual
    finally:
        shutil.rmtree(folder)
