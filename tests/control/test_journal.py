"""The journal at work: intents and outcomes, jobs and their files, pruning, calendars that jump."""

from __future__ import annotations

import asyncio
import sqlite3
from contextlib import closing
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.assembly import Cell
from cellctl.control.acts import ActKind, JobFiles
from cellctl.control.journal_reader import JournalReader
from cellctl.control.journal_store import REMEMBERED_ACTS
from cellctl.feeding.inventory import Counts, InventoryError, Move
from tests.control.journals import (
    CELLS,
    FIRST,
    JumpingClock,
    belief,
    files,
    opened,
    place,
    record,
    tower,
)


def test_an_intent_is_unsettled_until_it_has_an_outcome(tmp_path: Path) -> None:
    async def work() -> None:
        async with opened(tmp_path / "journal.db") as journal:
            act = await journal.intend(ActKind.PICK, "job", 3, Cell(1, 2, 0))
            assert [entry.act_id for entry in journal.unsettled()] == [act]
            journal.settle(act, "done", "as wished", (Move.PICK,), belt_indexes=12)
            assert journal.unsettled() == ()
            (entry,) = journal.recent(5)
            assert (entry.kind, entry.step, entry.cell, entry.outcome) == (
                ActKind.PICK,
                3,
                Cell(1, 2, 0),
                "done",
            )
            assert journal.ledger.counts == Counts(stock=10, belt=29, gripper=1)
            with pytest.raises(KeyError):
                journal.settle(act, "done")

    asyncio.run(work())


def test_an_outcome_that_cannot_be_changes_nothing(tmp_path: Path) -> None:
    async def work() -> None:
        async with opened(tmp_path / "journal.db") as journal:
            act = await journal.intend(ActKind.RELEASE, "job", 0, CELLS[0])
            with pytest.raises(InventoryError, match="no part in gripper"):
                journal.settle(act, "done", moves=(Move.PLACE,))
            with pytest.raises(InventoryError, match="would become"):
                await journal.record(ActKind.COUNT, counts=Counts(stock=1))
            assert [entry.act_id for entry in journal.unsettled()] == [act]
            assert journal.ledger.counts == FIRST
        async with opened(tmp_path / "journal.db") as journal:
            assert [entry.act_id for entry in journal.unsettled()] == [act]
            assert journal.ledger.counts == FIRST

    asyncio.run(work())


def test_everything_is_there_after_a_restart(tmp_path: Path) -> None:
    async def work() -> None:
        async with opened(tmp_path / "journal.db") as journal:
            journal.keep_job(record(), files())
            for cell in CELLS[:3]:
                await place(journal, cell)
            await journal.record(ActKind.REFILL, moves=(Move.LAY,) * 2, detail="two laid")
            cut_off = await journal.intend(ActKind.FEED, "job", 3)
            journal.keep_job(record(phase="retreating"))
            before, acts = belief(journal), journal.recent(100)
        async with opened(tmp_path / "journal.db") as journal:
            assert belief(journal) == before
            assert journal.recent(100) == acts
            assert [entry.act_id for entry in journal.unsettled()] == [cut_off]
            found = journal.open_job()
            assert found is not None
            assert found[0] == record(phase="retreating")
            kept, first = found[1], files()
            assert kept.upload == first.upload
            assert kept.mesh is not None
            assert first.mesh is not None
            assert np.array_equal(kept.mesh.vertices, first.mesh.vertices)
            assert np.array_equal(kept.mesh.faces, first.mesh.faces)
            assert kept.mesh.stated_dimensions_m == first.mesh.stated_dimensions_m
            assert await journal.intend(ActKind.FEED, "job") > cut_off

    asyncio.run(work())


def test_a_job_that_has_finished_is_not_open(tmp_path: Path) -> None:
    async def work() -> None:
        clock = JumpingClock()
        async with opened(tmp_path / "journal.db", clock) as journal:
            journal.keep_job(record("first"))
            journal.keep_job(record("second", plan=None))
            found = journal.open_job()
            assert found == (record("second", plan=None), JobFiles())
            journal.keep_job(record("second", finished_at=clock.now, outcome="built"))
            found = journal.open_job()
            assert found is not None
            assert found[0].job_id == "first"
        async with opened(tmp_path / "journal.db", clock) as journal:
            found = journal.open_job()
            assert found is not None
            assert found[0] == record("first")
        with JournalReader(tmp_path / "journal.db") as reader:
            newest, oldest = reader.jobs(5)
            assert (newest.record.job_id, oldest.record.job_id) == ("second", "first")
            assert newest.record.plan == tower(3)
            assert newest.config_sha256 == "c0ffee" * 10

    asyncio.run(work())


def test_the_loop_goes_on_while_the_disk_is_slow(tmp_path: Path) -> None:
    """Another connection holds the file: nothing is acknowledged, nothing blocks, all is kept."""
    path = tmp_path / "journal.db"

    async def work() -> None:
        async with opened(path) as journal:
            first = await journal.intend(ActKind.PICK, "job", 0, CELLS[0])
            with closing(sqlite3.connect(path, isolation_level=None)) as other:
                other.execute("BEGIN IMMEDIATE")
                journal.settle(first, "done", moves=(Move.PICK,))
                waiting = asyncio.create_task(journal.intend(ActKind.PLACE, "job", 0, CELLS[0]))
                unwanted = asyncio.create_task(journal.intend(ActKind.FEED, "job"))
                journal.keep_job(record())
                for _ in range(1000):
                    await asyncio.sleep(0)
                assert not waiting.done()
                unwanted.cancel()
                with pytest.raises(asyncio.CancelledError):
                    await unwanted
                with JournalReader(path) as reader:
                    assert [entry.act_id for entry in reader.unsettled()] == [first]
                other.execute("ROLLBACK")
            second = await waiting
            assert [entry.act_id for entry in journal.unsettled()] == [second]
            await journal.flush()
            with JournalReader(path) as reader:
                assert [entry.act_id for entry in reader.unsettled()] == [second]
                assert reader.ledger() == journal.ledger
                assert reader.job("job").record == record()

    asyncio.run(work())


def test_an_outcome_reaches_the_disk_by_itself(tmp_path: Path) -> None:
    async def work() -> None:
        async with opened(tmp_path / "journal.db") as journal:
            act = await journal.intend(ActKind.RETREAT, "job")
            journal.settle(act, "done")
            async with asyncio.timeout(20):
                while True:
                    with JournalReader(tmp_path / "journal.db") as reader:
                        if not reader.unsettled():
                            return
                    await asyncio.sleep(0.01)

    asyncio.run(work())


def test_memory_holds_the_newest_acts_only(tmp_path: Path) -> None:
    async def work() -> None:
        async with opened(tmp_path / "journal.db") as journal:
            first = await journal.intend(ActKind.FEED, "job")
            pending = [journal.intend(ActKind.FEED, "job") for _ in range(REMEMBERED_ACTS + 50)]
            acts = await asyncio.gather(*pending)
            for act in acts:
                journal.settle(act, "done")
            remembered = journal.recent(2 * REMEMBERED_ACTS)
            assert len(remembered) == REMEMBERED_ACTS
            assert [entry.act_id for entry in remembered[:3]] == acts[:-4:-1]
            assert [entry.act_id for entry in journal.unsettled()] == [first]

    asyncio.run(work())


def test_pruning_keeps_what_counts_and_gives_the_space_back(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"

    async def work() -> None:
        clock = JumpingClock()
        async with opened(path, clock) as journal:
            journal.keep_job(record("open"), files())
            cut_off = await journal.intend(ActKind.FEED, "open")
            for number in range(30):
                job_id = f"job-{number}"
                journal.keep_job(record(job_id), files(number))
                await place(journal, CELLS[number], job_id)
                journal.keep_job(record(job_id, finished_at=clock.now, outcome="built"))
                clock.jump(days=1)
            clock.jump(days=100)
            await journal.record(ActKind.CLEAR, moves=(Move.TAKE_APART,) * 30)
            before, newest = belief(journal), journal.recent(1)[0].act_id
            assert await journal.prune(keep_days=110, keep_jobs=3) > 0
            with JournalReader(path) as reader:
                kept = {stored.record.job_id for stored in reader.jobs(100)}
                assert kept == {"open", *(f"job-{number}" for number in range(20, 30))}
                assert len(reader.acts("job-25")) == 3
                assert reader.acts("job-5") == ()
            large = path.stat().st_size
            clock.jump(days=1000)
            await journal.prune(keep_days=110, keep_jobs=3)
            with JournalReader(path) as reader:
                kept = {stored.record.job_id for stored in reader.jobs(100)}
                assert kept == {"open", "job-27", "job-28", "job-29"}
                reader.check()
            assert path.stat().st_size < large * 2 / 3
            assert await journal.prune(keep_days=110, keep_jobs=3) == 0
            assert belief(journal) == before
        async with opened(path, clock) as journal:
            assert belief(journal) == before
            assert [entry.act_id for entry in journal.unsettled()] == [cut_off]
            assert await journal.intend(ActKind.FEED, "open") > newest

    asyncio.run(work())


@settings(max_examples=5, deadline=None)
@given(st.lists(st.integers(-4000, 4000), min_size=6, max_size=6))
def test_a_calendar_that_jumps_harms_nothing(
    tmp_path_factory: pytest.TempPathFactory, jumps: list[int]
) -> None:
    path = tmp_path_factory.mktemp("jumps") / "journal.db"

    async def work() -> None:
        clock = JumpingClock()
        async with opened(path, clock) as journal:
            for cell, days in zip(CELLS, jumps, strict=False):
                await place(journal, cell)
                clock.jump(days=days)
            await journal.prune(keep_days=1, keep_jobs=1)
            for cell, days in zip(CELLS[6:], jumps, strict=False):
                clock.jump(days=days)
                await place(journal, cell)
            ids = [act.act_id for act in journal.recent(100)]
            assert ids == sorted(ids, reverse=True)
            before = journal.ledger
            assert len(before.standing) == 12
        clock.now -= timedelta(days=9000)
        async with opened(path, clock) as journal:
            assert journal.ledger == before
            assert await journal.intend(ActKind.FEED, "job") > ids[0]

    asyncio.run(work())
