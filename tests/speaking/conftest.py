"""A private sound server with a loudspeaker, and the mouth behind it."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from cellctl.sim.microphone import VirtualMicrophone
from tests.virtual_sound import virtual_sound


@pytest.fixture
def room() -> Iterator[VirtualMicrophone]:
    """A sound server that this process and its children use."""
    with virtual_sound() as virtual:
        yield virtual
