"""The archive: answers what is asked of jobs, from memory or from the journal's file.

Reading and packing happen in a thread, one answer after the other: the control loop goes on, and
however many ask, one thread is busy.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

import zmq

from cellctl.assembly import Role
from cellctl.control.job import Job
from cellctl.control.job_files import Source, packed
from cellctl.control.journal_reader import JournalReader
from cellctl.errors import RefusedError, UsageError
from cellctl.messages import FileCommand, FileData, FileKind

Packed = tuple[FileData, zmq.Frame]


class Archive:
    """Answers questions about jobs.

    Args:
        newest: gives the job under way, or the last one since the cell started.
        journal: the journal's file.
    """

    def __init__(self, newest: Callable[[], Job | None], journal: Path) -> None:
        self._newest = newest
        self._journal = journal
        self._turn = asyncio.Lock()
        # Each kind's newest file, packed, with what it was made from.
        self._kept: dict[FileKind, tuple[object, Packed]] = {}

    async def file(self, asked: FileCommand, role: Role) -> Packed:
        """A file of a job: what is told of it, and its content.

        A visitor may have those of the job under way, or of the last one, which everybody in the
        room sees; older ones are the operator's.

        Raises:
            RefusedError: that job's files need the operator.
            UsageError: there is no such job, or it has no such file, or one that is too large.
            CellFault: ``journal_damaged``, ``journal_failed``.
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
        async with self._turn:
            return await asyncio.to_thread(self._stored, asked.job_id, asked.kind)

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
