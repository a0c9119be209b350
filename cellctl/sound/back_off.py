"""When to try again what has failed."""

from __future__ import annotations

import time

WAITS_S = (0.25, 0.5, 1.0, 2.0)
"""Waits between attempts to open a device; the last one for ever (wall time)."""


class BackOff:
    """Attempts that wait longer after each failure."""

    def __init__(self) -> None:
        self._failures = 0
        self._next_s = 0.0

    @property
    def due(self) -> bool:
        """Whether the next attempt may be made."""
        return time.monotonic() >= self._next_s

    def failed(self) -> None:
        """It failed: wait before the next attempt."""
        self._next_s = time.monotonic() + WAITS_S[min(self._failures, len(WAITS_S) - 1)]
        self._failures += 1

    def worked(self) -> None:
        """It works: after a later failure the first wait is short again."""
        self._failures = 0

    def begin_anew(self) -> None:
        """Attempt it now, whatever failed before."""
        self._failures, self._next_s = 0, 0.0
