"""How long the journal takes: ``python -m benchmarks.journal [--acts N] [--folder FOLDER]``.

Prints the 50th and 99th percentile of an act (intent on disk, outcome in memory), of the event
loop's longest silence meanwhile, and of opening the journal again.
"""

from __future__ import annotations

import argparse
import asyncio
import statistics
import sys
import tempfile
import time
from pathlib import Path

from cellctl.assembly import Cell
from cellctl.clock import SystemClock
from cellctl.control.acts import ActKind
from cellctl.control.journal_store import SqliteJournal
from cellctl.feeding.inventory import Counts, Move


def show(what: str, durations_s: list[float]) -> None:
    """Print percentiles, in milliseconds."""
    cuts = statistics.quantiles(durations_s, n=100, method="inclusive")
    longest_ms = max(durations_s) * 1000
    print(  # noqa: T201 - a program for people
        f"{what}: p50 {cuts[49] * 1000:.2f} ms, p99 {cuts[98] * 1000:.2f} ms, "
        f"longest {longest_ms:.2f} ms"
    )


async def watch(silences_s: list[float]) -> None:
    """Note how late the loop is each millisecond."""
    while True:
        began_s = time.perf_counter()
        await asyncio.sleep(0.001)
        silences_s.append(time.perf_counter() - began_s - 0.001)


async def measure(path: Path, acts: int) -> None:
    """Write acts as a build does, one after the other."""
    first = Counts(belt=1)
    journal = await SqliteJournal.open(path, SystemClock(), first)
    silences_s: list[float] = []
    watcher = asyncio.create_task(watch(silences_s))
    durations_s: list[float] = []
    for number in range(acts):
        kind, move = (ActKind.PICK, Move.PICK) if number % 2 == 0 else (ActKind.HAND, Move.MISS)
        began_s = time.perf_counter()
        act_id = await journal.intend(kind, "job", number, Cell(0, 0, 0))
        journal.settle(act_id, "done", moves=(move,))
        durations_s.append(time.perf_counter() - began_s)
    watcher.cancel()
    await asyncio.gather(watcher, return_exceptions=True)
    await journal.close()
    show(f"intend and settle, {acts} acts", durations_s)
    show("the event loop's lateness", silences_s)
    openings_s: list[float] = []
    for _ in range(5):
        began_s = time.perf_counter()
        journal = await SqliteJournal.open(path, SystemClock(), first)
        openings_s.append(time.perf_counter() - began_s)
        await journal.close()
    show(f"opening with {acts} acts to fold", openings_s)


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--acts", type=int, default=500)
    parser.add_argument("--folder", type=Path, help="on the disk to measure; else a temporary one")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=arguments.folder) as folder:
        asyncio.run(measure(Path(folder) / "journal.db", arguments.acts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
