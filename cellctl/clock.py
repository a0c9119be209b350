"""Time, injected: nothing in cellctl reads the system's clock directly.

Cell time is what the robot, the belt and the visitor's report are measured in. On a real cell it
runs at the rate of wall time. An emulated cell may run faster; its clock is then scaled once, here,
so that every time-out and every reported duration keeps its meaning in cell seconds.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from datetime import UTC, datetime
from typing import Protocol


class Clock(Protocol):
    """Monotonic cell time in seconds, and ways to wait in it."""

    def now_s(self) -> float:
        """Cell seconds since an arbitrary start; never goes back."""
        ...

    def wall_time(self) -> datetime:
        """The calendar time, in UTC, for people and journals; may jump."""
        ...

    async def sleep(self, duration_s: float) -> None:
        """Wait for a duration in cell seconds."""
        ...

    def timeout(self, duration_s: float) -> AbstractAsyncContextManager[None]:
        """``async with clock.timeout(5.0):`` raises TimeoutError after that many cell seconds."""
        ...


class SystemClock:
    """The clock of a running daemon: cell time is wall time multiplied by ``rate``.

    Args:
        rate: cell seconds per wall second; 1.0 on every real cell.
    """

    def __init__(self, rate: float = 1.0) -> None:
        if not rate > 0.0:
            raise ValueError(f"clock rate must be greater than 0, not {rate}")
        self.rate = rate
        self._start_s = time.monotonic()

    def now_s(self) -> float:
        return (time.monotonic() - self._start_s) * self.rate

    def wall_time(self) -> datetime:
        return datetime.now(UTC)

    async def sleep(self, duration_s: float) -> None:
        await asyncio.sleep(max(0.0, duration_s) / self.rate)

    @asynccontextmanager
    async def _timeout(self, duration_s: float) -> AsyncIterator[None]:
        async with asyncio.timeout(duration_s / self.rate):
            yield

    def timeout(self, duration_s: float) -> AbstractAsyncContextManager[None]:
        return self._timeout(duration_s)
