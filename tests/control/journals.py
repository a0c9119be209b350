"""Journals for tests: where they lie, what they begin with, and how to tell two beliefs apart."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from cellctl.assembly import Assembly, BuildPlan, Cell, Role, Step, StepKind, Utterance
from cellctl.clock import SystemClock
from cellctl.control.acts import ActKind, JobFiles, JobRecord
from cellctl.control.journal_store import SqliteJournal
from cellctl.feeding.inventory import Counts, Move
from cellctl.mesh import GeneratedMesh

FIRST = Counts.at_first(40, 30)
CELLS = [Cell(x, y, z) for z in range(4) for x in range(3) for y in range(3)]


class JumpingClock(SystemClock):
    """A calendar that goes where a test says; it stands still in between."""

    def __init__(self, now: datetime = datetime(2026, 5, 1, tzinfo=UTC)) -> None:
        super().__init__()
        self.now = now

    def wall_time(self) -> datetime:
        return self.now

    def jump(self, **by: float) -> None:
        """By ``days=``, ``hours=`` and so on."""
        self.now += timedelta(**by)


@asynccontextmanager
async def opened(path: Path, clock: SystemClock | None = None) -> AsyncIterator[SqliteJournal]:
    """A journal that is open for as long as the context lasts."""
    journal = await SqliteJournal.open(
        path, clock or SystemClock(), FIRST, config_sha256="c0ffee" * 10
    )
    try:
        yield journal
    finally:
        await journal.close()


def belief(journal: SqliteJournal) -> dict[str, Any]:
    """All that a daemon would go on with."""
    job = journal.open_job()
    return {
        "ledger": journal.ledger,
        "unsettled": journal.unsettled(),
        "job": job[0] if job is not None else None,
        "upload": job[1].upload if job is not None else None,
    }


async def place(journal: SqliteJournal, cell: Cell, job_id: str = "job") -> None:
    """Build one part as the cell does."""
    act = await journal.intend(ActKind.PICK, job_id, 0, cell)
    journal.settle(act, "done", moves=(Move.PICK,), belt_indexes=act)
    act = await journal.intend(ActKind.PLACE, job_id, 0, cell)
    journal.settle(act, "done")
    act = await journal.intend(ActKind.RELEASE, job_id, 0, cell)
    journal.settle(act, "done", moves=(Move.PLACE,))


def record(job_id: str = "job", **changes: Any) -> JobRecord:
    """A job that is being built."""
    values: dict[str, Any] = {
        "job_id": job_id,
        "role": Role.VISITOR,
        "began_at": datetime(2026, 5, 1, 12, tzinfo=UTC),
        "phase": "building",
        "utterance": Utterance(text="Build me a tower.", source="text"),
        "plan": tower(3),
    }
    return JobRecord(**{**values, **changes})


def tower(height: int) -> BuildPlan:
    """Cells on top of each other."""
    cells = [Cell(0, 0, z) for z in range(height)]
    return BuildPlan(
        plan_id=f"tower-{height}",
        title="tower",
        pitch_m=0.1,
        assembly=Assembly.of(cells, 0.1),
        steps=tuple(
            Step(index=z, kind=StepKind.PLACE, cell=cell, duration_s=0.1 * z)
            for z, cell in enumerate(cells)
        ),
        checks=(),
    )


def files(seed: int = 1, triangles: int = 500) -> JobFiles:
    """A mesh of chance, and an upload."""
    chance = np.random.default_rng(seed)
    mesh = GeneratedMesh(
        vertices=chance.normal(size=(triangles, 3)),
        faces=chance.integers(0, triangles, size=(triangles, 3)),
        metric=True,
        title="tower",
        provenance="a test",
        stated_dimensions_m={"height": 0.3},
    )
    return JobFiles(mesh=mesh, upload=chance.bytes(3000))
