"""Recordings that came over the bus: on disk only while they are listened to."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def audio_file(wav: bytes) -> Iterator[Path]:
    """A private file that holds the recording, and is gone afterwards."""
    with tempfile.NamedTemporaryFile(prefix="cellctl-", suffix=".wav") as file:
        file.write(wav)
        file.flush()
        yield Path(file.name)
