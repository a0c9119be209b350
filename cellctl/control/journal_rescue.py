"""The way out of a damaged journal: set it aside, and save into a new one what can be read.

What the cell believes is saved only when all that it rests upon is there. Otherwise every part
counts as unknown, so that nothing can be built before an operator has looked and counted.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, field
from datetime import datetime
from itertools import count
from pathlib import Path
from typing import TypeVar

from cellctl.control.acts import Act, ActKind, JobRecord
from cellctl.control.journal_contents import faults_named
from cellctl.control.journal_lock import JournalLock
from cellctl.control.journal_rows import (
    ACT_COLUMNS,
    CHECKPOINT_COLUMNS,
    JOB_COLUMNS,
    Row,
    RowError,
    StoredFile,
    act_of,
    act_row,
    checkpoint_of,
    job_of,
    job_row,
)
from cellctl.control.journal_schema import beside, connect, create
from cellctl.control.ledger import Ledger
from cellctl.errors import UsageError
from cellctl.feeding.inventory import Counts, InventoryError

T = TypeVar("T")

_REASON = "The journal was damaged."
_MOST_GAPS = 2000
"""How many rows are skipped one by one where a table cannot be read."""


@dataclass
class Rescue:
    """What became of a damaged journal."""

    aside: Path
    """Where the old file is now, as it was."""
    ledger: Ledger
    """What the new one believes."""
    acts: int = 0
    """So many were saved."""
    jobs: int = 0
    complete: bool = True
    """Whether the new one believes what the old one did."""
    lost: list[str] = field(default_factory=list)
    """What was not saved, in words."""


def renew(path: Path, first_counts: Counts, now: datetime) -> Rescue:
    """Set a damaged journal aside and save what can be read; no daemon may use it meanwhile.

    Args:
        path: the journal; the old file's name gets ``.damaged-`` and the time at its end.
        first_counts: tells how many parts there are, if the file does not.
        now: calendar time.

    Raises:
        ConfigError: a daemon uses it, or this user cannot write there.
        UsageError: there is none.
        CellFault: ``journal_failed``: the new one cannot be written.
    """
    with JournalLock(path), faults_named(path):
        aside = _set_aside(path, "damaged", now)
        try:
            db = _opened(aside)
        except sqlite3.Error as error:
            ledger = Ledger(counts=Counts(unknown=first_counts.total))
            create(path, ledger, now)
            return Rescue(aside, ledger, complete=False, lost=[f"everything ({error})"])
        with closing(db):
            return _rescue(db, path, Rescue(aside, Ledger(counts=first_counts)), now)


def start_anew(path: Path, first_counts: Counts, now: datetime) -> Path:
    """Set a journal aside and begin with an empty one; no daemon may use it meanwhile.

    Returns:
        Where the old file is now.

    Raises:
        ConfigError, UsageError, CellFault: as for ``renew``.
    """
    with JournalLock(path), faults_named(path):
        aside = _set_aside(path, "old", now)
        create(path, Ledger(counts=first_counts), now)
    return aside


def _set_aside(path: Path, why: str, now: datetime) -> Path:
    """Rename the file and what SQLite keeps beside it.

    The file goes first: without it, the log that is left tells the daemon that something is wrong.
    """
    endings = ("", "-wal", "-shm")
    if not any(beside(path, ending).exists() for ending in endings):
        raise UsageError(f"{path}: there is no journal.", "The daemon makes it when it starts.")
    stem = beside(path, f".{why}-{now:%Y%m%dT%H%M%S}")
    aside = next(
        name
        for name in (beside(stem, f"-{number}" if number else "") for number in count())
        if not any(beside(name, ending).exists() for ending in endings)
    )
    for ending in endings:
        with suppress(FileNotFoundError):
            beside(path, ending).rename(beside(aside, ending))
    return aside


def _opened(path: Path) -> sqlite3.Connection:
    """The old file with its log, or without it when it cannot be opened so."""
    try:
        return connect(path, writable=False)
    except sqlite3.Error:
        if not beside(path, "-wal").exists():
            raise
        beside(path, "-wal").rename(beside(path, ".unread-wal"))
        return connect(path, writable=False)


def _rescue(db: sqlite3.Connection, path: Path, rescue: Rescue, now: datetime) -> Rescue:
    acts = dict(_saved(db, "acts", ACT_COLUMNS, act_of, rescue))
    checkpoints = [
        found for _, found in _saved(db, "checkpoints", CHECKPOINT_COLUMNS, checkpoint_of, rescue)
    ]
    for table in ("acts", "checkpoints"):
        if (answer := _check(db, table)) != "ok":
            rescue.lost.append(f"perhaps some {table} ({answer})")
    rescue.complete = not rescue.lost and bool(checkpoints)
    rescue.ledger = _believed(acts, checkpoints, rescue)
    last_order = max(
        [
            0,
            *(order for order, _, _ in checkpoints),
            *(order for _, order in acts.values() if order is not None),
        ]
    )
    if not rescue.complete:
        # Where the parts are is no longer known: what was under way cannot go on.
        for act_id, (act, order) in sorted(acts.items()):
            if order is None:
                last_order += 1
                acts[act_id] = (_cut_off(act, now), last_order)
    jobs = dict(_saved(db, "jobs", JOB_COLUMNS, job_of, rescue))

    def fill(new: sqlite3.Connection) -> None:
        marks = "?, ?, ?, ?, ?, ?"
        rows = [act_row(act, order) for act, order in acts.values()]
        new.executemany(f"INSERT INTO acts ({ACT_COLUMNS}) VALUES ({marks})", rows)  # noqa: S608
        for number, record in sorted(jobs.items()):
            _save_job(db, new, (number, record), rescue, now)

    create(
        path,
        rescue.ledger,
        now,
        settled_order=last_order,
        act_id=max([0, *acts, *(act_id for _, act_id, _ in checkpoints)]),
        fill=fill,
    )
    rescue.acts, rescue.jobs = len(acts), len(jobs)
    return rescue


def _saved(
    db: sqlite3.Connection,
    table: str,
    columns: str,
    decode: Callable[[Row], T],
    rescue: Rescue,
) -> Iterator[tuple[int, T]]:
    """All rows of a table that can be read, by their key."""
    for key, row in sorted(_rows(db, table, columns, rescue).items()):
        try:
            yield key, decode(row)
        except RowError as error:
            rescue.lost.append(str(error))


def _rows(db: sqlite3.Connection, table: str, columns: str, rescue: Rescue) -> dict[int, Row]:
    """The rows of a table: upwards past what cannot be read, then downwards up to it."""
    found: dict[int, Row] = {}
    start, problem = -1, ""
    select = f"SELECT rowid, {columns} FROM {table}"  # noqa: S608 - constants
    for _ in range(_MOST_GAPS):
        try:
            for key, *row in db.execute(f"{select} WHERE rowid > ? ORDER BY rowid", (start,)):
                found[key] = tuple(row)
                start = key
            break
        except sqlite3.Error as error:
            start, problem = start + 1, str(error)
            if getattr(error, "sqlite_errorcode", None) == sqlite3.SQLITE_ERROR:  # no such table
                break
    if problem:
        rescue.lost.append(f"some {table} ({problem})")
        with suppress(sqlite3.Error):
            for key, *row in db.execute(f"{select} ORDER BY rowid DESC"):
                found[key] = tuple(row)
    return found


def _check(db: sqlite3.Connection, table: str) -> str:
    try:
        return str(db.execute(f"PRAGMA quick_check('{table}')").fetchone()[0])
    except sqlite3.Error as error:
        return str(error)


def _believed(
    acts: dict[int, tuple[Act, int | None]],
    checkpoints: list[tuple[int, int, Ledger]],
    rescue: Rescue,
) -> Ledger:
    """What is believed; all parts are unknown when something is missing for that."""
    total = rescue.ledger.counts.total
    if checkpoints:
        first, _, ledger = max(checkpoints, key=lambda found: found[0])
        total = ledger.counts.total
        settled = sorted(
            ((order, act) for act, order in acts.values() if order is not None and order > first),
            key=lambda found: found[0],
        )
        try:
            for expected, (order, act) in zip(count(first + 1), settled) if rescue.complete else ():
                if order != expected:
                    rescue.lost.append(f"the outcome number {expected}")
                    rescue.complete = False
                    break
                ledger = ledger.after(act)
        except InventoryError as error:
            rescue.lost.append(f"the sense of the acts ({error.message})")
            rescue.complete = False
        if rescue.complete:
            return ledger
        owned = [act.counts for _, act in settled if act.kind is ActKind.OWN and act.counts]
        total = owned[-1].total if owned else total
    rescue.complete = False
    return Ledger(counts=Counts(unknown=total))


def _cut_off(act: Act, now: datetime) -> Act:
    return act.model_copy(update={"outcome": "interrupted", "settled_at": now, "detail": _REASON})


def _save_job(
    old: sqlite3.Connection,
    new: sqlite3.Connection,
    job: tuple[int, JobRecord],
    rescue: Rescue,
    now: datetime,
) -> None:
    number, record = job
    files, whole, versions = [], True, None
    with suppress(sqlite3.Error):  # they are information, and version 1 did not have them
        versions = old.execute(
            "SELECT cellctl_version, config_sha256 FROM jobs WHERE number = ?", (number,)
        ).fetchone()
    try:
        for kind, content, sha256 in old.execute(
            "SELECT kind, content, sha256 FROM files WHERE number = ?", (number,)
        ):
            file = StoredFile(kind, content, sha256)
            file.checked()
            files.append(file)
    except (sqlite3.Error, RowError) as error:
        rescue.lost.append(f"files of job {record.job_id} ({error})")
        whole = False
    if record.finished_at is None and not (whole and rescue.complete):
        update = {"finished_at": now, "outcome": "failed", "message": _REASON}
        record = record.model_copy(update=update)
    new.execute(
        f"INSERT INTO jobs (number, {JOB_COLUMNS}, "  # noqa: S608 - constants
        "cellctl_version, config_sha256) VALUES (?, ?, ?, ?, ?, ?, ?)",
        (number, *job_row(record), *(versions or ("", ""))),
    )
    new.executemany(
        "INSERT INTO files (number, kind, sha256, content) VALUES (?, ?, ?, ?)",
        [(number, file.kind, file.sha256, file.content) for file in files],
    )
