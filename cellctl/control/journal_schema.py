"""The journal's file: its tables, and how a file of an older version becomes one of this version.

The file is SQLite in WAL mode (https://sqlite.org/wal.html) with ``synchronous=FULL``: what is
committed survives a loss of power. ``PRAGMA user_version`` holds the version of the tables.

SQLite does not notice a flipped bit in a row, so every row carries a checksum of its own.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Callable
from contextlib import closing
from datetime import datetime
from pathlib import Path
from typing import Final, TypeVar
from urllib.parse import quote

import structlog

from cellctl.control.journal_lock import give_to_owner_of_folder
from cellctl.control.journal_rows import checkpoint_row
from cellctl.control.ledger import Ledger
from cellctl.errors import CellFault, ConfigError

log = structlog.get_logger(__name__)

T = TypeVar("T")

APPLICATION_ID: Final = 0x43454C4C
"""Marks a SQLite file as a journal of cellctl."""

_BUSY_S: Final = 5.0
"""Longest wait for another connection, in wall time; readers never make a writer wait."""

MIGRATIONS: Final[tuple[tuple[str, ...], ...]] = (
    (
        # body: Act as JSON. settled_order: 1, 2, 3, ... without a gap; the order of the fold.
        "CREATE TABLE acts (act_id INTEGER PRIMARY KEY, settled_order INTEGER, "
        "job_id TEXT NOT NULL, intended_unix_s REAL NOT NULL, body TEXT NOT NULL, "
        "crc INTEGER NOT NULL) STRICT",
        "CREATE INDEX acts_by_order ON acts (settled_order)",
        "CREATE INDEX acts_by_job ON acts (job_id)",
        # The ledger after the act with that settled_order; act_id: the highest one until then.
        "CREATE TABLE checkpoints (settled_order INTEGER PRIMARY KEY, act_id INTEGER NOT NULL, "
        "made_at TEXT NOT NULL, ledger TEXT NOT NULL, crc INTEGER NOT NULL) STRICT",
        # body: JobRecord as JSON, without its plan. number: the order in which jobs began.
        "CREATE TABLE jobs (number INTEGER PRIMARY KEY, job_id TEXT NOT NULL UNIQUE, "
        "finished_unix_s REAL, body TEXT NOT NULL, crc INTEGER NOT NULL) STRICT",
        # kind: plan (canonical JSON), mesh (npz) or upload (the file as it came).
        "CREATE TABLE files (number INTEGER NOT NULL REFERENCES jobs ON DELETE CASCADE, "
        "kind TEXT NOT NULL, sha256 TEXT NOT NULL, content BLOB NOT NULL, "
        "PRIMARY KEY (number, kind)) STRICT",
    ),
    (
        # What the job was built with.
        "ALTER TABLE jobs ADD COLUMN cellctl_version TEXT NOT NULL DEFAULT ''",
        "ALTER TABLE jobs ADD COLUMN config_sha256 TEXT NOT NULL DEFAULT ''",
    ),
)
"""From each version of the tables to the next; the first one makes them. Never edited, only
appended to."""

SCHEMA_VERSION: Final = len(MIGRATIONS)

_NO_WAY_TO_WRITE: Final = frozenset(
    {
        sqlite3.SQLITE_FULL,
        sqlite3.SQLITE_IOERR,
        sqlite3.SQLITE_READONLY,
        sqlite3.SQLITE_CANTOPEN,
        sqlite3.SQLITE_PERM,
        sqlite3.SQLITE_AUTH,
        sqlite3.SQLITE_BUSY,
        sqlite3.SQLITE_LOCKED,
        sqlite3.SQLITE_PROTOCOL,
        sqlite3.SQLITE_NOMEM,
    }
)


def fault_of(path: Path, error: Exception) -> CellFault:
    """The fault that an error of SQLite or of the file system is."""
    code = getattr(error, "sqlite_errorcode", None)
    damaged = isinstance(error, sqlite3.Error) and (
        code is None
        or code == sqlite3.SQLITE_IOERR_SHORT_READ
        or code & 0xFF not in _NO_WAY_TO_WRITE
    )
    reason = error.strerror if isinstance(error, OSError) and error.strerror else error
    return CellFault("journal_damaged" if damaged else "journal_failed", f"{path}: {reason}.")


def connect(path: Path, *, writable: bool) -> sqlite3.Connection:
    """Open a journal that exists; transactions are begun by name.

    A journal that nobody writes can be read without the right to write in its folder.

    Raises:
        sqlite3.Error: it cannot be opened.
    """
    where = f"file:{quote(str(path.absolute()))}"
    if writable:
        return _configured(f"{where}?mode=rw")
    try:
        return _configured(f"{where}?mode=ro")
    except sqlite3.OperationalError:
        if beside(path, "-wal").exists():
            raise
        return _configured(f"{where}?mode=ro&immutable=1")


def _configured(uri: str) -> sqlite3.Connection:
    db = sqlite3.connect(uri, uri=True, isolation_level=None, timeout=_BUSY_S)
    try:
        db.execute("PRAGMA foreign_keys = ON")
        db.execute("PRAGMA synchronous = FULL")
        db.execute("PRAGMA trusted_schema = OFF")
        db.execute("PRAGMA cell_size_check = ON")
        db.execute("SELECT count(*) FROM sqlite_schema").fetchone()
    except BaseException:
        db.close()
        raise
    return db


def version_of(path: Path, db: sqlite3.Connection) -> int:
    """The version of its tables.

    Raises:
        CellFault: ``journal_damaged``: it is a database, but no journal.
        ConfigError: a newer cellctl wrote it.
    """
    (application,) = db.execute("PRAGMA application_id").fetchone()
    (version,) = db.execute("PRAGMA user_version").fetchone()
    if application != APPLICATION_ID or version < 1:
        raise CellFault("journal_damaged", f"{path} is no journal of cellctl.")
    if version > SCHEMA_VERSION:
        raise ConfigError(
            f"{path}: was written by a newer cellctl (version {version} of its tables; this one "
            f"knows {SCHEMA_VERSION}).",
            "Install that cellctl again, or restore a journal of this one.",
        )
    return int(version)


def check(path: Path, db: sqlite3.Connection) -> None:
    """Look at every page.

    Raises:
        CellFault: ``journal_damaged``.
    """
    (answer,) = db.execute("PRAGMA quick_check(1)").fetchone()
    if answer != "ok":
        raise CellFault("journal_damaged", f"{path}: {answer}.")
    if orphan := db.execute("PRAGMA foreign_key_check").fetchone():
        raise CellFault("journal_damaged", f"{path}: a row of {orphan[0]} belongs to no job.")


def migrate(
    path: Path,
    db: sqlite3.Connection,
    migrations: tuple[tuple[str, ...], ...] = MIGRATIONS,
) -> None:
    """Bring the tables to the newest version, all or nothing; a copy is made first.

    The copy's name is that of the journal with ``.before-`` and the new version.

    Raises:
        sqlite3.Error: it cannot be done; the file is as it was.
    """
    (version,) = db.execute("PRAGMA user_version").fetchone()
    if version >= len(migrations):
        return
    copy = beside(path, f".before-{len(migrations)}")
    copy_journal(db, copy)
    _apply(db, migrations, version)
    log.info("journal migrated", before=version, after=len(migrations), copy=str(copy))


def _apply(db: sqlite3.Connection, migrations: tuple[tuple[str, ...], ...], version: int) -> None:
    transaction(db, lambda: _apply_inside(db, migrations, version))


def _apply_inside(
    db: sqlite3.Connection, migrations: tuple[tuple[str, ...], ...], version: int
) -> None:
    for statements in migrations[version:]:
        for statement in statements:
            db.execute(statement)
    db.execute(f"PRAGMA user_version = {len(migrations)}")


def transaction(db: sqlite3.Connection, work: Callable[[], T]) -> T:
    """Do something in one transaction, all or nothing.

    Raises:
        sqlite3.Error: nothing of it is in the file, unless the disk lies.
    """
    db.execute("BEGIN IMMEDIATE")
    try:
        result = work()
        db.execute("COMMIT")
    except BaseException:
        if db.in_transaction:
            db.execute("ROLLBACK")
        raise
    return result


def create(
    path: Path,
    ledger: Ledger,
    made_at: datetime,
    *,
    settled_order: int = 0,
    act_id: int = 0,
    migrations: tuple[tuple[str, ...], ...] = MIGRATIONS,
    fill: Callable[[sqlite3.Connection], None] | None = None,
) -> None:
    """Make a journal; the file is there with all that it needs, or not at all.

    Args:
        path: where; nothing may be there.
        ledger: what is believed at first.
        made_at: calendar time.
        settled_order: of the newest act that the ledger knows of.
        act_id: the highest one that was used before.
        migrations: the tables.
        fill: writes what else shall be in it, in a transaction of its own.

    Raises:
        sqlite3.Error, OSError: it cannot be done.
    """
    draft = beside(path, ".new")
    for leftover in (draft, beside(draft, "-wal"), beside(draft, "-shm")):
        leftover.unlink(missing_ok=True)
    draft.touch(mode=0o640)
    try:
        with closing(connect(draft, writable=True)) as db:
            db.execute("PRAGMA auto_vacuum = INCREMENTAL")
            db.execute("PRAGMA journal_mode = WAL")
            db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
            _apply(db, migrations, 0)
            row = checkpoint_row(settled_order, act_id, made_at, ledger)
            db.execute("INSERT INTO checkpoints VALUES (?, ?, ?, ?, ?)", row)
            if fill is not None:
                db.execute("BEGIN")
                fill(db)
                db.execute("COMMIT")
        give_to_owner_of_folder(draft)
        _sync(draft)
        draft.rename(path)
        _sync(path.parent)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def copy_journal(db: sqlite3.Connection, target: Path) -> None:
    """Copy a journal that is open, its newest acts included; an older copy is replaced.

    Raises:
        sqlite3.Error, OSError: it cannot be done; an older copy is still there.
    """
    draft = beside(target, ".new")
    draft.unlink(missing_ok=True)
    draft.touch(mode=0o640)
    try:
        with closing(sqlite3.connect(draft)) as copy:
            db.backup(copy)
        give_to_owner_of_folder(draft)
        _sync(draft)
        draft.rename(target)
        _sync(target.parent)
    except BaseException:
        draft.unlink(missing_ok=True)
        raise


def beside(path: Path, ending: str) -> Path:
    """The file of that name with an ending after it."""
    return path.with_name(path.name + ending)


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
