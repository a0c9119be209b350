"""Cell time that a test bench advances by hand, so that a busy machine changes no outcome."""

from __future__ import annotations

import asyncio
import heapq
import itertools
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager, contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


class PacedClock:
    """A ``Clock`` that stands still between calls of ``step``."""

    def __init__(self) -> None:
        self._now_s = 0.0
        self._alarms: list[tuple[float, int, Callable[[], None]]] = []
        self._numbers = itertools.count()

    def step(self, dt_s: float) -> None:
        """Let time pass and wake whoever waits for it."""
        self._now_s += dt_s
        while self._alarms and self._alarms[0][0] <= self._now_s:
            heapq.heappop(self._alarms)[2]()

    def now_s(self) -> float:
        return self._now_s

    def wall_time(self) -> datetime:
        return datetime.now(UTC)

    async def sleep(self, duration_s: float) -> None:
        over = asyncio.Event()
        with self._alarm(duration_s, over.set):
            await over.wait()

    def timeout(self, duration_s: float) -> AbstractAsyncContextManager[None]:
        return self._timeout(duration_s)

    @asynccontextmanager
    async def _timeout(self, duration_s: float) -> AsyncIterator[None]:
        loop = asyncio.get_running_loop()
        async with asyncio.timeout(None) as timeout:
            with self._alarm(duration_s, lambda: timeout.reschedule(loop.time())):
                yield

    @contextmanager
    def _alarm(self, duration_s: float, ring: Callable[[], None]) -> Iterator[None]:
        alarm = (self._now_s + duration_s, next(self._numbers), ring)
        heapq.heappush(self._alarms, alarm)
        try:
            yield
        finally:
            if alarm in self._alarms:
                self._alarms.remove(alarm)
                heapq.heapify(self._alarms)
