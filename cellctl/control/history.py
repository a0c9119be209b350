"""The journal's jobs as the bus tells them. Reads the file, so that it belongs into a thread."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from cellctl.control.acts import Act
from cellctl.control.journal_reader import JournalReader, StoredJob
from cellctl.messages import ActData, HistoryData, JobRecordData, JobSummary

_MOST_ACTS: Final = 5000
"""The newest so many acts of one job are told; a build has four for a part."""


def history(journal: Path, limit: int, before: int | None) -> HistoryData:
    """A page of jobs, newest first.

    Args:
        journal: the journal's file.
        limit: how many at most.
        before: only those that began before the job of this number.

    Raises:
        UsageError: there is no journal, or it cannot be read by this user.
        CellFault: ``journal_damaged``, ``journal_failed``.
    """
    with JournalReader(journal) as reader:
        total = reader.count()
        jobs = reader.jobs(limit + 1, before)
    more = len(jobs) > limit
    return HistoryData(
        jobs=tuple(summary(stored) for stored in jobs[:limit]),
        total=total,
        next_before=jobs[limit - 1].number if more else None,
    )


def job_record(journal: Path, job_id: str) -> JobRecordData:
    """One job with its plan and acts.

    Raises:
        UsageError: there is no such job.
        CellFault: ``journal_damaged``, ``journal_failed``.
    """
    with JournalReader(journal) as reader:
        stored, acts = reader.job(job_id), reader.acts(job_id)
    return JobRecordData(
        job=summary(stored),
        plan=stored.record.plan,
        parts=stored.record.parts,
        acts=tuple(_act(act) for act in acts[-_MOST_ACTS:]),
        has_mesh=stored.files.mesh is not None,
    )


def summary(stored: StoredJob) -> JobSummary:
    """A job in short."""
    record = stored.record
    plan = record.plan
    what = record.utterance.text if record.utterance is not None else record.upload_name
    if not what and record.request is not None:
        what = record.request.text
    return JobSummary(
        number=stored.number,
        job_id=record.job_id,
        role=record.role,
        began_at=record.began_at,
        finished_at=record.finished_at,
        what=what,
        title=plan.title if plan is not None else "",
        phase=record.phase,
        outcome=record.outcome,
        message=record.message,
        parts_done=len(record.parts),
        steps=len(plan.steps) if plan is not None else 0,
        seconds=round(sum(part.seconds for part in record.parts), 3),
        cellctl_version=stored.cellctl_version,
        config_sha256=stored.config_sha256,
    )


def _act(act: Act) -> ActData:
    return ActData(
        act_id=act.act_id,
        kind=act.kind.value,
        step=act.step,
        cell=act.cell,
        intended_at=act.intended_at,
        settled_at=act.settled_at,
        outcome=act.outcome,
        detail=act.detail,
        moves=tuple(move.value for move in act.moves),
    )
