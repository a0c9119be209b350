"""Reading a journal without writing to it: beside a running daemon, or when none runs."""

from __future__ import annotations

import os
import sqlite3
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from cellctl.control.acts import Act, JobFiles, JobRecord
from cellctl.control.journal_contents import faults_named, fold, read_job
from cellctl.control.journal_rows import ACT_COLUMNS, JOB_COLUMNS, act_of
from cellctl.control.journal_schema import SCHEMA_VERSION, check, connect, version_of
from cellctl.control.ledger import Ledger
from cellctl.errors import ConfigError, UsageError


@dataclass(frozen=True)
class StoredJob:
    """One job as it stands in the journal."""

    number: int
    """Grows from job to job."""
    record: JobRecord
    files: JobFiles
    cellctl_version: str
    """Of the cellctl that wrote it last."""
    config_sha256: str
    """Of that cellctl's configuration."""


@dataclass(frozen=True)
class Soundness:
    """What a journal that is sound holds."""

    version: int
    """Of its tables."""
    acts: int
    jobs: int
    ledger: Ledger


class JournalReader:
    """A journal that is read, as a context: one moment of it, whatever a daemon writes meanwhile.

    Args:
        path: the file.

    Raises, in every method and on entering:
        CellFault: ``journal_damaged``, ``journal_failed``.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._db: sqlite3.Connection

    def __enter__(self) -> Self:
        """Open it.

        Raises:
            UsageError: there is none.
            ConfigError: another version of cellctl wrote it.
        """
        if not self._path.exists():
            raise UsageError(
                f"{self._path}: there is no journal yet.", "The daemon makes it when it starts."
            )
        if not os.access(self._path, os.R_OK):
            raise UsageError(
                f"{self._path}: cannot be read by this user.", "Ask as a member of its group."
            )
        with faults_named(self._path):
            self._db = connect(self._path, writable=False)
            try:
                self._refuse_older()
                self._db.execute("BEGIN")
            except BaseException:
                self._db.close()
                raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._db.close()

    def ledger(self) -> Ledger:
        """What is believed of the cell."""
        with faults_named(self._path):
            return fold(self._db)[0]

    def jobs(self, limit: int, before: int | None = None) -> tuple[StoredJob, ...]:
        """The newest jobs, newest first, without their files; or those before the one of that
        number."""
        which = "WHERE number < coalesce(?, number + 1) ORDER BY number DESC LIMIT ?"
        return self._jobs(which, before, limit, with_files=False)

    def count(self) -> int:
        """How many jobs there are."""
        with faults_named(self._path):
            (jobs,) = self._db.execute("SELECT count(*) FROM jobs").fetchone()
            return int(jobs)

    def job(self, job_id: str) -> StoredJob:
        """One job.

        Raises:
            UsageError: there is none of that name.
        """
        found = self._jobs("WHERE job_id = ?", job_id)
        if not found:
            raise UsageError(
                f"There is no job {job_id} in {self._path}.", "`cellctl history` lists them."
            )
        return found[0]

    def acts(self, job_id: str) -> tuple[Act, ...]:
        """The acts of a job, in their order."""
        return self._acts("WHERE job_id = ? ORDER BY act_id", job_id)

    def unsettled(self) -> tuple[Act, ...]:
        """Acts without an outcome, oldest first."""
        return self._acts("WHERE settled_order IS NULL ORDER BY act_id")

    def check(self) -> Soundness:
        """Look at every page, every row and every checksum."""
        with faults_named(self._path):
            check(self._path, self._db)
            version = version_of(self._path, self._db)
        acts, jobs = self._acts("ORDER BY act_id"), self._jobs("ORDER BY number")
        return Soundness(version, len(acts), len(jobs), self.ledger())

    def _refuse_older(self) -> None:
        if version_of(self._path, self._db) < SCHEMA_VERSION:
            raise ConfigError(
                f"{self._path}: was written by an older cellctl.",
                "Start the daemon once: it brings the journal to this version.",
            )

    def _acts(self, which: str, *values: object) -> tuple[Act, ...]:
        with faults_named(self._path):
            rows = self._db.execute(
                f"SELECT {ACT_COLUMNS} FROM acts {which}",  # noqa: S608 - constants
                values,
            )
            return tuple(act_of(row)[0] for row in rows)

    def _jobs(self, which: str, *values: object, with_files: bool = True) -> tuple[StoredJob, ...]:
        with faults_named(self._path):
            rows = self._db.execute(
                f"SELECT number, cellctl_version, config_sha256, {JOB_COLUMNS} "  # noqa: S608
                f"FROM jobs {which}",
                values,
            ).fetchall()
            return tuple(
                StoredJob(
                    number,
                    *read_job(self._db, number, tuple(row), with_files=with_files),
                    version,
                    config,
                )
                for number, version, config, *row in rows
            )
