"""The archive: answers what is asked of jobs and of the cell, from memory or the journal's file.

Reading and packing happen in a thread, one answer after the other: the control loop goes on, and
however many ask, one thread is busy.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import zmq

from cellctl.assembly import Role
from cellctl.config import CellConfig
from cellctl.control.about import Present, about, limits
from cellctl.control.history import history, job_record
from cellctl.control.job import Job
from cellctl.control.job_files import Source, packed
from cellctl.control.journal_reader import JournalReader
from cellctl.control.recollection import Recollection
from cellctl.errors import RefusedError, UsageError
from cellctl.messages import (
    AskCommand,
    FileCommand,
    FileData,
    FileKind,
    HistoryCommand,
    Inquiry,
    JobCommand,
    ReplyData,
)

T = TypeVar("T")

Packed = tuple[FileData, zmq.Frame]


class Archive:
    """Answers questions about jobs and the cell.

    Args:
        config: the cell's configuration; names the journal's file.
        newest: gives the job under way, or the last one since the cell started.
        present: gives what is known of the cell now.
        recollection: what the daemon remembers of its own life.
    """

    def __init__(
        self,
        config: CellConfig,
        newest: Callable[[], Job | None],
        present: Callable[[], Present],
        recollection: Recollection,
    ) -> None:
        self._config = config
        self._journal = Path(config.journal.path)
        self._newest = newest
        self._present = present
        self.recollection = recollection
        self._turn = asyncio.Lock()
        # Each kind's newest file, packed, with what it was made from.
        self._kept: dict[FileKind, tuple[object, Packed]] = {}

    async def answer(self, asked: Inquiry, role: Role) -> tuple[ReplyData, zmq.Frame | None]:
        """What is asked, and the file that goes with it.

        Raises:
            RefusedError: that job's files need the operator.
            UsageError: there is no such job or no such file, or no journal yet.
            CellFault: ``journal_damaged``, ``journal_failed``.
        """
        if isinstance(asked, FileCommand):
            return await self._file(asked, role)
        return await self._told(asked), None

    async def _file(self, asked: FileCommand, role: Role) -> Packed:
        """A file of a job: what is told of it, and its content.

        A visitor may have those of the job under way, or of the last one, which everybody in the
        room sees; older ones are the operator's.
        """
        job = self._newest()
        if job is not None and asked.job_id in {"", job.job_id}:
            source = Source(job.job_id, job.generated, job.plan, job.upload_name, job.upload)
            async with self._turn:
                return await self._of_newest(source, asked.kind)
        if not asked.job_id:
            raise UsageError("There was no job since the cell started.")
        if role is not Role.OPERATOR:
            raise RefusedError(f"The files of job {asked.job_id} need the operator.")
        return await self._read(self._stored, asked.job_id, asked.kind)

    async def _told(self, asked: HistoryCommand | JobCommand | AskCommand) -> ReplyData:
        match asked:
            case HistoryCommand():
                return await self._read(history, self._journal, asked.limit, asked.before)
            case JobCommand():
                return await self._read(job_record, self._journal, asked.job_id)
        match asked.command:
            case "about":
                return await self._read(about, self._config, self._present())
            case "limits":
                return limits(self._config, self._present())
            case "log":
                return self.recollection.logs()
            case "audit":
                return self.recollection.audit()

    async def _read(self, read: Callable[..., T], *arguments: object) -> T:
        async with self._turn:
            return await asyncio.to_thread(read, *arguments)

    async def _of_newest(self, source: Source, kind: FileKind) -> Packed:
        made_from = source.of(kind)
        before, found = self._kept.get(kind, (None, None))
        if found is None or before is not made_from or found[0].job_id != source.job_id:
            found = await asyncio.to_thread(_framed, source, kind)
            self._kept[kind] = (made_from, found)
        return found

    def _stored(self, job_id: str, kind: FileKind) -> Packed:
        with JournalReader(self._journal) as journal:
            stored = journal.job(job_id)
        record, files = stored.record, stored.files
        source = Source(job_id, files.mesh, record.plan, record.upload_name, files.upload)
        return _framed(source, kind)


def _framed(source: Source, kind: FileKind) -> Packed:
    data, content = packed(source, kind)
    # A frame of libzmq is shared by all replies that carry it; bytes would be copied for each.
    return data, zmq.Frame(content, copy=True)
