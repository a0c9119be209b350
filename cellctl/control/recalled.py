"""The job that an earlier daemon did not finish."""

from __future__ import annotations

import structlog

from cellctl.assembly import Cell
from cellctl.clock import Clock
from cellctl.control.job import Job, Phase
from cellctl.control.journal import Journal

log = structlog.get_logger(__name__)


def recalled_job(
    journal: Journal, clock: Clock, standing: frozenset[Cell], interrupted: str
) -> Job | None:
    """The job that is open in the journal; None for none.

    One of which nothing is known but that somebody spoke is closed.

    Args:
        journal: where jobs are written.
        clock: tells the calendar time.
        standing: cells of the workspace that hold a part.
        interrupted: what is said of a job that is closed.
    """
    kept = journal.open_job()
    if kept is None:
        return None
    job = Job.recalled(*kept, standing=standing)
    if job.phase is Phase.HEARING and job.utterance is None:
        job.outcome, job.message = "failed", interrupted
        job.finished_at = clock.wall_time()
        journal.keep_job(job.record())
        return None
    if job.phase is Phase.HEARING:
        job.phase = Phase.INTERPRETING
    log.info("job recalled", job=job.job_id, phase=job.phase, placed=job.placed)
    return job
