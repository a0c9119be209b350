"""The journal's own thread's side: the connection, and what is written through it.

Nothing here knows of the event loop; everything runs in one thread, one call after another.
"""

from __future__ import annotations

import os
import sqlite3
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from cellctl import __version__
from cellctl.assembly import BuildPlan
from cellctl.control.acts import Act, JobFiles, JobRecord
from cellctl.control.journal_contents import Contents, faults_named, read_contents
from cellctl.control.journal_rows import (
    ACT_COLUMNS,
    CHECKPOINT_COLUMNS,
    JOB_COLUMNS,
    MESH,
    PLAN,
    UPLOAD,
    StoredFile,
    act_row,
    checkpoint_row,
    job_files,
    job_row,
    plan_file,
)
from cellctl.control.journal_schema import (
    beside,
    check,
    connect,
    create,
    migrate,
    transaction,
    version_of,
)
from cellctl.control.ledger import Ledger
from cellctl.errors import CellFault, ConfigError
from cellctl.feeding.inventory import Counts

_PRUNED_JOBS = 20
_PRUNED_ACTS = 2000
_FREED_PAGES = 500
"""How much one piece of pruning takes: an intent that comes in between waits for one piece."""

_KEEP_ACT = (
    f"INSERT INTO acts ({ACT_COLUMNS}) VALUES (?, ?, ?, ?, ?, ?) "  # noqa: S608 - constants
    "ON CONFLICT (act_id) DO UPDATE SET settled_order = excluded.settled_order, "
    "body = excluded.body, crc = excluded.crc"
)
_KEEP_JOB = (
    f"INSERT INTO jobs ({JOB_COLUMNS}, cellctl_version, config_sha256) "  # noqa: S608 - constants
    "VALUES (?, ?, ?, ?, ?, ?) ON CONFLICT (job_id) DO UPDATE SET "
    "finished_unix_s = excluded.finished_unix_s, body = excluded.body, crc = excluded.crc, "
    "cellctl_version = excluded.cellctl_version, config_sha256 = excluded.config_sha256 "
    "RETURNING number"
)


@dataclass(frozen=True)
class Batch:
    """What one transaction writes."""

    acts: tuple[tuple[Act, int | None], ...]
    """Acts with the place of their outcome in the order."""
    jobs: tuple[tuple[JobRecord, JobFiles | None], ...]
    saved_act_id: int
    """Highest act that an earlier transaction is known to have written."""


@dataclass(frozen=True)
class Policy:
    """What pruning keeps."""

    older_than: datetime
    """What began after this is kept."""
    keep_jobs: int
    """So many of the newest jobs are kept, however old."""


class JournalWriter:
    """A journal that is written.

    Args:
        path: the file.
        config_sha256: of the configuration, kept with every job.
    """

    def __init__(self, path: Path, config_sha256: str) -> None:
        self._path = path
        self._config_sha256 = config_sha256
        self._db: sqlite3.Connection | None = None
        self._file: os.stat_result | None = None
        self._plan: tuple[str, BuildPlan] | None = None
        """Job and plan that were written last."""
        self._in_doubt = False
        """The last transaction failed; parts of it may be in the file all the same."""

    def open(self, first_counts: Counts, now: datetime, recent: int) -> Contents:
        """Open or make the file, look at all of it, and bring it to this version.

        Raises:
            CellFault: ``journal_damaged``, ``journal_failed``.
            ConfigError: it cannot be read or written by this user, or is of a newer cellctl.
        """
        with faults_named(self._path):
            if not self._path.exists():
                self._make(first_counts, now)
            if not os.access(self._path, os.R_OK | os.W_OK):
                raise ConfigError(
                    f"{self._path}: cannot be written by this user.",
                    "Give it to the user that the daemon runs as.",
                )
            if self._path.stat().st_size == 0:
                raise CellFault("journal_damaged", f"{self._path}: the file is empty.")
            db = self._connected()
            version_of(self._path, db)
            check(self._path, db)
            db.execute("PRAGMA journal_mode = WAL").fetchone()  # a copy may have lost it
            migrate(self._path, db)
            return read_contents(db, recent)

    def _make(self, first_counts: Counts, now: datetime) -> None:
        orphan = beside(self._path, "-wal")
        if orphan.exists() and orphan.stat().st_size:
            raise CellFault(
                "journal_damaged", f"{self._path} is gone, and {orphan.name} is still there."
            )
        if not os.access(self._path.parent, os.W_OK):
            raise ConfigError(
                f"{self._path}: no file can be made there.",
                "Make its folder writable for this user, or name another journal.path.",
            )
        create(self._path, Ledger(counts=first_counts), now)

    def write(self, batch: Batch) -> None:
        """Write a batch, all or nothing; it survives a loss of power then.

        Raises:
            CellFault: ``journal_failed``, ``journal_damaged``.
        """
        try:
            with faults_named(self._path):
                db = self._connected()
                transaction(db, lambda: self._write(db, batch))
        except CellFault:
            self._in_doubt, self._plan = True, None
            self._disconnect()
            raise
        self._in_doubt = False

    def _write(self, db: sqlite3.Connection, batch: Batch) -> None:
        if self._in_doubt:
            # What failed may have reached the file, and may have been called off since.
            db.execute("DELETE FROM acts WHERE act_id > ?", (batch.saved_act_id,))
        db.executemany(_KEEP_ACT, [act_row(act, order) for act, order in batch.acts])
        for record, files in batch.jobs:
            row = (*job_row(record), __version__, self._config_sha256)
            ((number,),) = db.execute(_KEEP_JOB, row).fetchall()
            self._write_plan(db, number, record)
            if files is not None:
                db.execute(
                    "DELETE FROM files WHERE number = ? AND kind IN (?, ?)", (number, MESH, UPLOAD)
                )
                for file in job_files(files):
                    _write_file(db, number, file)

    def _write_plan(self, db: sqlite3.Connection, number: int, record: JobRecord) -> None:
        if record.plan is None:
            db.execute("DELETE FROM files WHERE number = ? AND kind = ?", (number, PLAN))
        elif self._plan is None or self._plan != (record.job_id, record.plan):
            _write_file(db, number, plan_file(record.plan))
            self._plan = (record.job_id, record.plan)

    def checkpoint(self, ledger: Ledger, settled_order: int, act_id: int, now: datetime) -> None:
        """Keep a ledger, so that the acts before it need not be folded any more.

        Raises:
            CellFault: ``journal_failed``, ``journal_damaged``.
        """
        with faults_named(self._path):
            db = self._connected()

            def write() -> None:
                db.execute(
                    f"INSERT OR REPLACE INTO checkpoints ({CHECKPOINT_COLUMNS}) "  # noqa: S608
                    "VALUES (?, ?, ?, ?, ?)",
                    checkpoint_row(settled_order, act_id, now, ledger),
                )
                db.execute("DELETE FROM checkpoints WHERE settled_order < ?", (settled_order,))

            transaction(db, write)

    def prune(self, policy: Policy) -> int:
        """Remove a piece of what the policy lets go; acts only that the checkpoint knows of.

        Returns:
            How many rows went; 0 when there is nothing left to remove.

        Raises:
            CellFault: ``journal_failed``, ``journal_damaged``.
        """
        with faults_named(self._path):
            db = self._connected()
            return transaction(db, lambda: _prune(db, policy))

    def shrink(self) -> bool:
        """Give a piece of what is free back to the disk; False when nothing is left to give.

        Raises:
            CellFault: ``journal_failed``, ``journal_damaged``.
        """
        with faults_named(self._path):
            db = self._connected()
            (before,) = db.execute("PRAGMA freelist_count").fetchone()
            db.execute(f"PRAGMA incremental_vacuum({_FREED_PAGES})").fetchall()
            (free,) = db.execute("PRAGMA freelist_count").fetchone()
            db.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()
            return bool(0 < free < before)

    def close(self) -> None:
        """Close the file; another one may be there when it is opened again."""
        self._disconnect()
        self._file = None

    def _connected(self) -> sqlite3.Connection:
        """The connection, opened again after a failure, to the file that is at the path.

        Raises:
            sqlite3.Error, OSError: there is none.
        """
        there = self._path.stat()
        if self._file is not None and not os.path.samestat(there, self._file):
            raise CellFault("journal_failed", f"{self._path} was replaced by another file.")
        if self._db is None:
            self._db = connect(self._path, writable=True)
            self._file = there
        return self._db

    def _disconnect(self) -> None:
        if self._db is not None:
            self._db.close()
            self._db = None


def _write_file(db: sqlite3.Connection, number: int, file: StoredFile) -> None:
    db.execute(
        "INSERT OR REPLACE INTO files (number, kind, sha256, content) VALUES (?, ?, ?, ?)",
        (number, file.kind, file.sha256, file.content),
    )


def _prune(db: sqlite3.Connection, policy: Policy) -> int:
    before_unix_s = policy.older_than.timestamp()
    jobs = db.execute(
        "DELETE FROM jobs WHERE number IN (SELECT number FROM jobs WHERE finished_unix_s < ? "
        "AND number NOT IN (SELECT number FROM jobs ORDER BY number DESC LIMIT ?) LIMIT ?)",
        (before_unix_s, policy.keep_jobs, _PRUNED_JOBS),
    ).rowcount
    acts = db.execute(
        "DELETE FROM acts WHERE act_id IN (SELECT act_id FROM acts WHERE intended_unix_s < ? "
        "AND settled_order <= (SELECT max(settled_order) FROM checkpoints) "
        "AND job_id NOT IN (SELECT job_id FROM jobs) LIMIT ?)",
        (before_unix_s, _PRUNED_ACTS),
    ).rowcount
    return int(jobs + acts)
