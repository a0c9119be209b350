"""What stands in a journal's file, folded and checked."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from cellctl.control.acts import Act, JobFiles, JobRecord
from cellctl.control.journal_rows import (
    ACT_COLUMNS,
    CHECKPOINT_COLUMNS,
    JOB_COLUMNS,
    PLAN,
    RowError,
    StoredFile,
    act_of,
    checkpoint_of,
    files_of,
    job_of,
    plan_of,
)
from cellctl.control.journal_schema import fault_of
from cellctl.control.ledger import Ledger
from cellctl.errors import CellFault
from cellctl.feeding.inventory import InventoryError


@dataclass(frozen=True)
class Contents:
    """What a daemon goes on with."""

    ledger: Ledger
    settled_order: int
    """Of the newest act that is settled."""
    act_id: int
    """The highest that was ever used."""
    unsettled: tuple[Act, ...]
    """Oldest first."""
    recent: tuple[Act, ...]
    """Oldest first."""
    open_jobs: tuple[tuple[JobRecord, JobFiles], ...]
    """In the order in which they began."""


@contextmanager
def faults_named(path: Path) -> Iterator[None]:
    """Turn what can go wrong with the file into faults.

    Raises:
        CellFault: ``journal_damaged`` or ``journal_failed``.
    """
    try:
        yield
    except RowError as error:
        raise CellFault("journal_damaged", f"{path}: {error}.") from error
    except InventoryError as error:
        detail = f"{path}: its acts contradict each other ({error.message})"
        raise CellFault("journal_damaged", detail) from error
    except (sqlite3.Error, OSError) as error:
        raise fault_of(path, error) from error


def read_contents(db: sqlite3.Connection, recent: int) -> Contents:
    """Fold what is in the file.

    Args:
        db: a connection that is in no transaction.
        recent: how many of the newest acts to read.

    Raises:
        RowError, InventoryError, sqlite3.Error: the file is damaged.
    """
    db.execute("BEGIN")
    try:
        ledger, order, act_id = fold(db)
        unsettled = _acts(db, "WHERE settled_order IS NULL ORDER BY act_id")
        newest = _acts(db, "ORDER BY act_id DESC LIMIT ?", recent)
        jobs = db.execute(
            f"SELECT number, {JOB_COLUMNS} FROM jobs "  # noqa: S608 - constants
            "WHERE finished_unix_s IS NULL ORDER BY number"
        ).fetchall()
        open_jobs = tuple(read_job(db, number, tuple(row)) for number, *row in jobs)
    finally:
        db.execute("ROLLBACK")
    return Contents(ledger, order, act_id, unsettled, newest[::-1], open_jobs)


def fold(db: sqlite3.Connection) -> tuple[Ledger, int, int]:
    """The ledger, the newest outcome's place in the order, and the highest act's id.

    Raises:
        RowError, InventoryError, sqlite3.Error: the file is damaged.
    """
    row = db.execute(
        f"SELECT {CHECKPOINT_COLUMNS} FROM checkpoints "  # noqa: S608 - constants
        "ORDER BY settled_order DESC LIMIT 1"
    ).fetchone()
    if row is None:
        raise RowError("there is no inventory in it")
    order, act_id, ledger = checkpoint_of(row)
    for found in db.execute(
        f"SELECT {ACT_COLUMNS} FROM acts "  # noqa: S608 - constants
        "WHERE settled_order > ? ORDER BY settled_order",
        (order,),
    ):
        act, place = act_of(found)
        if place != order + 1:
            raise RowError(f"the outcome number {order + 1} is not there")
        ledger, order = ledger.after(act), place
    (highest,) = db.execute("SELECT max(act_id) FROM acts").fetchone()
    return ledger, order, max(act_id, highest or 0)


def _acts(db: sqlite3.Connection, which: str, *values: object) -> tuple[Act, ...]:
    rows = db.execute(f"SELECT {ACT_COLUMNS} FROM acts {which}", values)  # noqa: S608 - constants
    return tuple(act_of(row)[0] for row in rows)


def read_job(
    db: sqlite3.Connection, number: int, row: tuple[object, ...], *, with_files: bool = True
) -> tuple[JobRecord, JobFiles]:
    """A job with its plan and its files, their checksums verified.

    Args:
        db: an open journal.
        number: of the job.
        row: its ``JOB_COLUMNS``.
        with_files: whether its large parts are wanted, too.

    Raises:
        RowError, sqlite3.Error: the file is damaged.
    """
    record = job_of(row)
    stored = {
        kind: StoredFile(kind, content, sha256)
        for kind, content, sha256 in db.execute(
            "SELECT kind, content, sha256 FROM files WHERE number = ? AND (? OR kind = ?)",
            (number, with_files, PLAN),
        )
    }
    try:
        if PLAN in stored:
            record = record.model_copy(update={"plan": plan_of(stored[PLAN])})
        return record, files_of(stored)
    except RowError as error:
        raise RowError(f"job {record.job_id}: {error}") from error
