"""How the daemon itself is doing: how long its loop was blocked, and how full its inbox is."""

from __future__ import annotations

import asyncio
import time
from collections import deque

from cellctl.messages import HealthData

_PERIOD_S = 0.01
_WINDOW_S = 60.0


class LoopMonitor:
    """Measures how late the event loop wakes a task that asked for 10 ms (wall time)."""

    def __init__(self) -> None:
        self._late_s: deque[float] = deque(maxlen=int(_WINDOW_S / _PERIOD_S))
        self._started_s = time.monotonic()
        self._max_s = 0.0

    async def run(self) -> None:
        """Measure until cancelled."""
        while True:
            due_s = time.monotonic() + _PERIOD_S
            await asyncio.sleep(_PERIOD_S)
            late_s = max(0.0, time.monotonic() - due_s)
            self._late_s.append(late_s)
            self._max_s = max(self._max_s, late_s)

    def health(self, inbox: int) -> HealthData:
        """The figures of the last minute; the maximum is of the whole life."""
        ordered = sorted(self._late_s)
        p99_s = ordered[int(0.99 * (len(ordered) - 1))] if ordered else 0.0
        return HealthData(
            uptime_s=time.monotonic() - self._started_s,
            loop_blocked_p99_s=round(p99_s, 6),
            loop_blocked_max_s=round(self._max_s, 6),
            inbox=inbox,
        )
