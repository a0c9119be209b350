"""Trouble with the file: full and vanished disks, damage, other versions, two daemons."""

from __future__ import annotations

import asyncio
import os
import random
import resource
import shutil
import sqlite3
import subprocess
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, closing, contextmanager
from datetime import UTC, datetime
from pathlib import Path

import pytest

from cellctl.clock import SystemClock
from cellctl.control.acts import ActKind
from cellctl.control.journal_lock import JournalLock
from cellctl.control.journal_reader import JournalReader
from cellctl.control.journal_rescue import Rescue, renew
from cellctl.control.journal_rows import JOB_COLUMNS, act_row, job_row
from cellctl.control.journal_schema import MIGRATIONS, SCHEMA_VERSION, create, migrate
from cellctl.control.journal_store import SqliteJournal
from cellctl.control.ledger import Ledger
from cellctl.errors import CellFault, ConfigError
from cellctl.feeding.inventory import Counts, Move
from tests.control.journals import CELLS, FIRST, belief, files, opened, place, record

NOW = datetime(2026, 5, 1, tzinfo=UTC)
Trouble = Callable[[Path], AbstractContextManager[None]]


def filled(path: Path, jobs: int = 3) -> dict[str, object]:
    """A journal of a cell that has built something, closed; returns what it believes."""

    async def work() -> dict[str, object]:
        async with opened(path) as journal:
            for number in range(jobs):
                job_id = f"job-{number}"
                journal.keep_job(record(job_id), files(number))
                for cell in CELLS[number * 3 : number * 3 + 3]:
                    await place(journal, cell, job_id)
                if number < jobs - 1:
                    journal.keep_job(record(job_id, finished_at=NOW, outcome="built"))
            await journal.intend(ActKind.PICK, f"job-{jobs - 1}", 2, CELLS[30])
            return belief(journal)

    return asyncio.run(work())


def believed(path: Path) -> dict[str, object]:
    async def work() -> dict[str, object]:
        async with opened(path) as journal:
            return belief(journal)

    return asyncio.run(work())


# Nothing can be written.


@contextmanager
def small_disk(folder: Path) -> Iterator[Path]:
    """A file system of its own, of half a megabyte."""
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=512k", "tmpfs", str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        pytest.skip(f"no file system can be mounted here: {done.stderr.strip()}")
    try:
        yield folder
    finally:
        subprocess.run(["umount", str(folder)], check=True)


@contextmanager
def full(path: Path) -> Iterator[None]:
    """The disk has no room left."""
    filler = path.with_name("filler")
    with filler.open("wb", buffering=0) as sink:
        while True:
            try:
                sink.write(bytes(512))
            except OSError:
                break
    yield
    filler.unlink()


@contextmanager
def limited(path: Path) -> Iterator[None]:
    """No file may grow."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    sizes = [path.with_name(path.name + ending).stat().st_size for ending in ("", "-wal")]
    resource.setrlimit(resource.RLIMIT_FSIZE, (min(sizes), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@contextmanager
def vanished(path: Path) -> Iterator[None]:
    """The file is elsewhere for a while, as when a disk drops out."""
    elsewhere = path.with_name("elsewhere")
    path.rename(elsewhere)
    yield
    elsewhere.rename(path)


@contextmanager
def replaced(path: Path) -> Iterator[None]:
    """Another journal lies in its place for a while."""
    with vanished(path):
        create(path, Ledger(counts=Counts(belt=1)), NOW)
        yield
        path.unlink()


async def _live_through(path: Path, trouble: Trouble) -> None:
    async with opened(path) as journal:
        await place(journal, CELLS[0])
        act = await journal.intend(ActKind.PICK, "job", 1, CELLS[1])
        with trouble(path):
            journal.settle(act, "done", moves=(Move.PICK,))
            journal.keep_job(record(), files(triangles=20_000))
            for _ in range(3):
                with pytest.raises(CellFault) as caught:
                    await journal.intend(ActKind.PLACE, "job", 1, CELLS[1])
                assert caught.value.code == "journal_failed"
                assert str(path) in caught.value.detail
            with pytest.raises(CellFault):
                await journal.record(ActKind.REFILL, moves=(Move.LAY,))
            with pytest.raises(CellFault):
                await journal.flush()
            assert journal.ledger.holding  # what happened is believed
            assert journal.ledger.counts.stock == FIRST.stock  # what was refused is not
            assert journal.unsettled() == ()
        act = await journal.intend(ActKind.RELEASE, "job", 1, CELLS[1])
        journal.settle(act, "done", moves=(Move.PLACE,))
        await journal.record(ActKind.REFILL, moves=(Move.LAY,))
        before = belief(journal)
    async with opened(path) as journal:
        assert belief(journal) == before
        assert journal.ledger.standing == frozenset(CELLS[:2])
        assert [entry.kind for entry in journal.recent(3)] == [
            ActKind.REFILL,
            ActKind.RELEASE,
            ActKind.PICK,
        ]


@pytest.mark.parametrize("trouble", [limited, vanished, replaced])
def test_nothing_is_lost_while_nothing_can_be_written(tmp_path: Path, trouble: Trouble) -> None:
    asyncio.run(_live_through(tmp_path / "journal.db", trouble))


def test_nothing_is_lost_on_a_full_disk(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk") as folder:
        path = folder / "journal.db"

        async def work() -> None:
            async with opened(path) as journal:
                await place(journal, CELLS[0])
                with full(path):
                    journal.keep_job(record(), files(triangles=3000))
                    with pytest.raises(CellFault, match="full") as caught:
                        await journal.intend(ActKind.PICK, "job", 1, CELLS[1])
                    assert caught.value.code == "journal_failed"
                act = await journal.intend(ActKind.RETREAT, "job")
                journal.settle(act, "done")
                before = belief(journal)
            async with opened(path) as journal:
                assert belief(journal) == before

        asyncio.run(work())


# Damage.


def test_no_flipped_byte_is_believed(tmp_path: Path) -> None:
    """Each is either refused, and the file left alone, or harmless."""
    sound, path = tmp_path / "sound.db", tmp_path / "journal.db"
    before = filled(sound, jobs=1)
    content = sound.read_bytes()
    chance = random.Random(5)  # noqa: S311 - a test
    refused, codes = 0, set()
    for offset in [*range(0, 100, 7), *chance.sample(range(100, len(content)), 80)]:
        damaged = bytearray(content)
        damaged[offset] ^= 1 << chance.randrange(8)
        path.write_bytes(damaged)
        try:
            assert believed(path) == before, f"offset {offset}"
        except ConfigError:
            refused += 1
        except CellFault as fault:
            codes.add(fault.code)
            refused += 1
        else:
            continue
        assert path.read_bytes() == damaged, f"offset {offset}"
    assert codes == {"journal_damaged"}
    assert refused > 30


def test_no_shortened_file_is_believed(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"
    filled(path)
    content = path.read_bytes()
    for size in (0, 50, 100, 4096, 5000, len(content) // 2, len(content) - 4096, len(content) - 1):
        path.write_bytes(content[:size])
        with pytest.raises(CellFault) as caught:
            believed(path)
        assert caught.value.code == "journal_damaged"
        assert path.read_bytes() == content[:size]


def test_other_things_at_its_place_are_left_alone(tmp_path: Path) -> None:
    text, other = tmp_path / "text.db", tmp_path / "other.db"
    text.write_text("Not a journal. " * 1000)
    with closing(sqlite3.connect(other)) as db:
        db.execute("CREATE TABLE acts (act_id)")
    for path in (text, other):
        content = path.read_bytes()
        with pytest.raises(CellFault, match="journal"):
            believed(path)
        assert path.read_bytes() == content


def test_acts_that_contradict_each_other_are_damage(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"
    filled(path)
    with closing(sqlite3.connect(path)) as db:
        db.execute("DELETE FROM acts WHERE act_id = 5")
        db.commit()
    with pytest.raises(CellFault, match="outcome number 5 is not there"):
        believed(path)
    with closing(sqlite3.connect(path)) as db:
        db.execute("UPDATE acts SET settled_order = settled_order - 1 WHERE settled_order > 5")
        db.commit()
    with pytest.raises(CellFault, match="checksum of act 6 is wrong"):
        believed(path)


def _damage(path: Path, pattern: bytes) -> None:
    """Spoil the file wherever a text stands in it."""
    content = path.read_bytes()
    assert pattern in content
    path.write_bytes(content.replace(pattern, b"\0" * len(pattern)))


def test_damage_to_a_finished_job_costs_that_job_only(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"
    before = filled(path)
    with closing(sqlite3.connect(path)) as db:
        (digest,) = db.execute(
            "SELECT sha256 FROM files JOIN jobs USING (number) "
            "WHERE job_id = 'job-0' AND kind = 'mesh'"
        ).fetchone()
    _damage(path, digest.encode())
    with JournalReader(path) as reader, pytest.raises(CellFault, match="job-0: the checksum"):
        reader.check()
    content = path.read_bytes()
    rescue = renew(path, FIRST, NOW)
    assert rescue.complete
    assert rescue.jobs == 3
    assert rescue.lost == ["files of job job-0 (the checksum of a mesh is wrong)"]
    assert rescue.aside.read_bytes() == content
    assert rescue.aside.name == "journal.db.damaged-20260501T000000"
    assert believed(path) == before
    with JournalReader(path) as reader:
        assert reader.check().acts == rescue.acts


def test_damage_to_acts_makes_every_part_unknown(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"
    filled(path)
    _damage(path, b'"act_id":7,"kind":"pick"')
    with pytest.raises(CellFault, match="checksum of act 7"):
        believed(path)
    rescue = renew(path, FIRST, NOW)
    assert not rescue.complete
    assert rescue.lost == ["the checksum of act 7 is wrong"]
    assert (rescue.acts, rescue.jobs) == (27, 3)

    async def go_on() -> None:
        async with opened(path) as journal:
            assert journal.ledger == Ledger(counts=Counts(unknown=FIRST.total))
            assert journal.unsettled() == ()
            assert journal.open_job() is None
            await journal.record(ActKind.COUNT, counts=journal.ledger.counts.counted(belt=38))
            assert journal.ledger.counts == Counts(belt=38, unknown=2)

    asyncio.run(go_on())
    with JournalReader(path) as reader:
        assert {stored.record.outcome for stored in reader.jobs(9)} == {"built", "failed"}
        assert [act.detail for act in reader.acts("job-2")][-1] == "The journal was damaged."


def test_a_daemon_goes_on_when_its_journal_was_replaced(tmp_path: Path) -> None:
    """The one that found it damaged has let go of it, and starts again with the new one."""
    path = tmp_path / "journal.db"
    filled(path)
    _damage(path, b'"act_id":7,"kind":"pick"')

    async def work() -> None:
        journal = SqliteJournal(path, SystemClock(), FIRST)
        for _ in range(2):
            with pytest.raises(CellFault, match="checksum of act 7"):
                await journal.start()
        await journal.close()
        renew(path, FIRST, NOW)
        await journal.start()
        try:
            assert journal.ledger.counts.unknown == FIRST.total
            await journal.record(ActKind.SETTLE, moves=(Move.FIND,))
        finally:
            await journal.close()

    asyncio.run(work())


@pytest.mark.parametrize("size", [0, 3000, 20_000])
def test_what_is_left_of_a_shortened_file_is_saved(tmp_path: Path, size: int) -> None:
    path = tmp_path / "journal.db"
    filled(path)
    os.truncate(path, size)
    rescue = renew(path, FIRST, NOW)
    assert not rescue.complete
    assert rescue.lost
    assert rescue.aside.stat().st_size == size
    assert rescue.ledger == Ledger(counts=Counts(unknown=FIRST.total))
    assert believed(path)["ledger"] == rescue.ledger


def test_a_log_without_its_file_is_damage(tmp_path: Path) -> None:
    path, log = tmp_path / "journal.db", tmp_path / "journal.db-wal"
    log.write_bytes(b"what was written last")
    with pytest.raises(CellFault, match="is gone") as caught:
        believed(path)
    assert caught.value.code == "journal_damaged"
    rescue: Rescue = renew(path, FIRST, NOW)
    assert not rescue.complete
    assert believed(path)["ledger"] == rescue.ledger


# Versions.


def test_a_journal_of_an_older_version_is_brought_up_to_date(tmp_path: Path) -> None:
    path, model = tmp_path / "journal.db", tmp_path / "model.db"
    before = filled(model)
    old = MIGRATIONS[:1]

    def fill(db: sqlite3.Connection) -> None:
        with JournalReader(model) as reader:
            jobs = reader.jobs(9)
            acts = [act for stored in jobs for act in reader.acts(stored.record.job_id)]
        order = 0
        for act in sorted(acts, key=lambda act: act.act_id):
            order += act.outcome is not None
            row = act_row(act, order if act.outcome is not None else None)
            db.execute("INSERT INTO acts VALUES (?, ?, ?, ?, ?, ?)", row)
        for stored in reversed(jobs):
            row = job_row(stored.record)
            db.execute(f"INSERT INTO jobs ({JOB_COLUMNS}) VALUES (?, ?, ?, ?)", row)  # noqa: S608

    create(path, Ledger(counts=FIRST), NOW, migrations=old, fill=fill)
    with pytest.raises(ConfigError, match="older cellctl"), JournalReader(path):
        pass
    found = believed(path)
    assert found["ledger"] == before["ledger"]
    assert found["unsettled"] == before["unsettled"]
    assert found["job"] == record("job-2", plan=None)
    with JournalReader(path) as reader:
        assert reader.check().version == SCHEMA_VERSION
    with closing(sqlite3.connect(tmp_path / f"journal.db.before-{SCHEMA_VERSION}")) as db:
        assert db.execute("PRAGMA user_version").fetchone() == (1,)
        assert db.execute("SELECT count(*) FROM acts").fetchone() == (28,)


def test_a_migration_that_fails_changes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"
    before = filled(path)
    broken = (*MIGRATIONS, ("CREATE TABLE more (one)", "CREATE TABLE acts (two)"))
    with (
        closing(sqlite3.connect(path, isolation_level=None)) as db,
        pytest.raises(sqlite3.OperationalError, match="already exists"),
    ):
        migrate(path, db, broken)
    assert believed(path) == before
    shutil.copy(tmp_path / f"journal.db.before-{len(broken)}", path)
    assert believed(path) == before


def test_a_journal_of_a_newer_version_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"
    filled(path)
    with closing(sqlite3.connect(path)) as db:
        db.execute(f"PRAGMA user_version = {SCHEMA_VERSION + 1}")
    content = path.read_bytes()
    with pytest.raises(ConfigError, match="newer cellctl"):
        believed(path)
    assert path.read_bytes() == content


# Two at once.


def test_two_daemons_cannot_have_one_journal(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"

    async def work() -> None:
        async with opened(path) as journal:
            assert JournalLock(path).holder() == os.getpid()
            with pytest.raises(ConfigError, match=f"process {os.getpid()} uses this journal"):
                async with opened(path):
                    pytest.fail("it opened")
            with pytest.raises(ConfigError, match="uses this journal"):
                renew(path, FIRST, NOW)
            await place(journal, CELLS[0])
        assert JournalLock(path).holder() is None
        async with opened(path) as journal:
            assert len(journal.ledger.standing) == 1

    asyncio.run(work())


def test_a_reader_sees_a_sound_journal_at_any_moment(tmp_path: Path) -> None:
    path = tmp_path / "journal.db"

    async def work() -> None:
        async with opened(path) as journal:
            journal.keep_job(record(), files())
            await journal.flush()
            with JournalReader(path) as early:
                assert early.check().acts == 0
                for number, cell in enumerate(CELLS[:8]):
                    await place(journal, cell)
                    with JournalReader(path) as reader:
                        found = await asyncio.to_thread(_checked, path)
                        assert reader.ledger().counts.total == FIRST.total
                    assert found >= 3 * number + 2
                assert early.check().acts == 0  # one moment, whatever is written meanwhile

    asyncio.run(work())


def _checked(path: Path) -> int:
    with JournalReader(path) as reader:
        return reader.check().acts


def test_a_folder_that_cannot_be_made_is_a_wrong_setting(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match=r"journal\.path"):
        believed(tmp_path / "file" / "journal.db")
