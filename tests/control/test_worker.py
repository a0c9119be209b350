"""The worker process: results, refusals, defects, time-outs, and no process left behind."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import pytest

from cellctl.errors import CellFault, PlanError
from cellctl.worker import WorkerError, WorkerProcess


def double(value: int) -> int:
    return 2 * value


def narrate(progress: Callable[[str], None]) -> str:
    progress("first")
    progress("second")
    return "done"


def refuse() -> None:
    raise PlanError("It has no floor.", "Give it one.")


def stop_with_fault() -> None:
    raise CellFault("belt_jam", "part 3")


def break_down() -> None:
    raise ZeroDivisionError("1/0")


def hang() -> None:
    signal.pause()


def die() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


@asynccontextmanager
async def working() -> AsyncIterator[WorkerProcess]:
    worker = WorkerProcess("tester")
    try:
        yield worker
    finally:
        await worker.close()


async def exercise() -> None:
    async with working() as worker:
        assert await worker.call(double, 21, timeout_s=30) == 42
        pid = worker.pid
        heard: list[str] = []
        assert await worker.call(narrate, timeout_s=30, progress=heard.append) == "done"
        assert heard == ["first", "second"]
        with pytest.raises(PlanError, match=r"no floor\. Give it one\."):
            await worker.call(refuse, timeout_s=30)
        with pytest.raises(CellFault, match="part 3"):
            await worker.call(stop_with_fault, timeout_s=30)
        with pytest.raises(WorkerError, match="ZeroDivisionError"):
            await worker.call(break_down, timeout_s=30)
        assert worker.pid == pid


def test_a_worker_returns_results_refusals_and_defects() -> None:
    asyncio.run(exercise())


async def outlast() -> None:
    async with working() as worker:
        with pytest.raises(WorkerError, match="longer than 1 s"):
            await worker.call(hang, timeout_s=1)
        assert worker.pid is None
        with pytest.raises(WorkerError, match="died in the middle"):
            await worker.call(die, timeout_s=30)
        assert await worker.call(double, 4, timeout_s=30) == 8


def test_a_worker_that_hangs_or_dies_is_replaced() -> None:
    asyncio.run(outlast())


async def cancel_a_call() -> None:
    async with working() as worker:
        assert await worker.call(double, 1, timeout_s=30) == 2
        call = asyncio.create_task(worker.call(hang, timeout_s=30))
        await asyncio.sleep(0)
        call.cancel()
        with pytest.raises(asyncio.CancelledError):
            await call
        assert worker.pid is None
        assert await worker.call(double, 2, timeout_s=30) == 4


def test_a_call_whose_caller_goes_away_costs_the_process() -> None:
    asyncio.run(cancel_a_call())
