"""The process of the emulated cell: one asyncio loop, one clock, every emulator."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import time
from collections.abc import Callable

import structlog

from cellctl.config import CellConfig
from cellctl.errors import CellctlError, UsageError
from cellctl.sim.cell import EmulatedCell
from cellctl.sim.injection import InjectionServer
from cellctl.sim.pace import SLICE_WALL_S, SimClock
from cellctl.sim.world_values import Imperfections

TURN_S = 0.02
"""After so long (wall time) of catching up, sockets get their turn."""

log = structlog.get_logger(__name__)


async def run_cell(
    config: CellConfig,
    speed: float,
    ready: Callable[[], None] | None = None,
    imperfections: Imperfections | None = None,
    end_with_stdin: bool = False,
) -> None:
    """Run an emulated cell until SIGTERM, SIGINT or a client's ``shutdown``.

    Args:
        config: an emulated cell.
        speed: cell seconds per wall second; goes before ``cell.clock_rate``.
        ready: called once when every socket is open and the clock runs.
        imperfections: how far the belt and its parts are from perfect.
        end_with_stdin: end also when standard input closes, as when the parent process dies.

    Raises:
        UsageError: the cell is a real one, or one of its addresses is taken, or its boards cannot
            run as is asked for.
        BoardCrashedError: a board's compiled program crashed.
    """
    section = config.cell.model_copy(update={"clock_rate": speed})
    cell = EmulatedCell(config.model_copy(update={"cell": section}), imperfections)
    assert config.emulation is not None
    loop = asyncio.get_running_loop()
    ended = asyncio.Event()
    clock = SimClock(speed, time.monotonic())
    server = InjectionServer(cell, clock, ended.set)
    for number in (signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, ended.set)
    if end_with_stdin:
        loop.add_reader(sys.stdin.fileno(), _end_on_eof, ended)
    try:
        await cell.start()
        server.bind(config.emulation.control)
        async with asyncio.TaskGroup() as tasks:
            work = [
                tasks.create_task(_drive(cell, clock), name="drive"),
                tasks.create_task(server.serve(), name="serve"),
            ]
            log.info("ready", cell=config.cell.name, pid=os.getpid(), speed=speed)
            if ready is not None:
                ready()
            await _first(ended, work)
            for task in work:
                task.cancel()
    except ExceptionGroup as group:
        told = [error for error in group.exceptions if isinstance(error, CellctlError)]
        if not told:
            raise
        raise told[0] from None
    except OSError as error:
        raise UsageError(
            f"The emulated cell cannot start: {error}.",
            "Is another one running on these addresses? Stop it, or choose others.",
        ) from error
    finally:
        if end_with_stdin:
            loop.remove_reader(sys.stdin.fileno())
        server.close()
        await cell.stop()
        log.info("ended", cell=config.cell.name, cell_time_s=round(cell.world.time_s, 3))


async def _first(ended: asyncio.Event, work: list[asyncio.Task[None]]) -> None:
    """Wait for the end, or for work that failed (whose error the task group then raises)."""
    waiting = asyncio.create_task(ended.wait(), name="ended")
    try:
        await asyncio.wait([waiting, *work], return_when=asyncio.FIRST_COMPLETED)
    finally:
        waiting.cancel()


async def _drive(cell: EmulatedCell, clock: SimClock) -> None:
    """Advance the emulators as wall time passes."""
    lost_s = 0.0
    while True:
        turn_s = time.monotonic()
        for slice_s in clock.slices(turn_s):
            cell.advance(slice_s)
            if time.monotonic() - turn_s > TURN_S:
                # Boards that run compiled programs may take longer than their slice.
                await asyncio.sleep(0.0)
                turn_s = time.monotonic()
        if clock.lost_s > lost_s:
            log.warning("the emulation cannot keep up", lost_s=round(clock.lost_s, 3))
            lost_s = clock.lost_s
        await asyncio.sleep(0.0 if clock.behind else SLICE_WALL_S)


def _end_on_eof(ended: asyncio.Event) -> None:
    if not os.read(sys.stdin.fileno(), 4096):
        ended.set()
        asyncio.get_running_loop().remove_reader(sys.stdin.fileno())
