"""The journal: a file of SQLite, written by a thread of its own, believed from memory.

An intent waits until it is on disk; outcomes and jobs are believed at once and reach the disk with
the next intent, or shortly after by themselves. All that waits is written in one transaction, so a
crash leaves a state that the cell was in.

When writing fails nothing is forgotten: what happened is kept in memory, in its order, and written
as soon as the disk takes it. Only what had not begun yet is called off.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from functools import reduce
from pathlib import Path
from typing import Final, Self, TypeVar

import structlog

from cellctl.assembly import Cell
from cellctl.clock import Clock
from cellctl.control.acts import Act, ActKind, JobFiles, JobRecord, Outcome
from cellctl.control.journal_lock import JournalLock
from cellctl.control.journal_writer import Batch, JournalWriter, Policy
from cellctl.control.ledger import Ledger
from cellctl.errors import CellFault
from cellctl.feeding.inventory import Counts, InventoryError, Move

log = structlog.get_logger(__name__)

T = TypeVar("T")

REMEMBERED_ACTS: Final = 1000
"""How many of the newest acts are at hand in memory."""
_LINGER_S: Final = 0.02
"""So long an outcome waits for an intent that takes it along (wall time)."""
_PATIENCE_S: Final = 10.0
"""Longest wait for the disk (wall time)."""
_RETRY_S: Final = 5.0
"""Time from a failed attempt to write to the next one that nobody asked for (wall time)."""


class SqliteJournal:
    """The ``Journal`` of a daemon: ``start`` it, and ``close`` it.

    Until it has started it believes in ``first_counts``, and takes nothing.

    Args:
        path: the file; its folder is made if need be.
        clock: gives the calendar time of acts, which is for people: it may jump.
        first_counts: where the parts are when the journal is new.
        config_sha256: of the configuration, kept with every job.
    """

    def __init__(
        self, path: Path, clock: Clock, first_counts: Counts, *, config_sha256: str = ""
    ) -> None:
        self._path = path
        self._clock = clock
        self._first_counts = first_counts
        self._lock = JournalLock(path)
        self._writer = JournalWriter(path, config_sha256)
        self._thread: ThreadPoolExecutor | None = None
        """None until it has started, and after damage until it is started again."""
        self._damage: CellFault | None = None
        self._ledger = self._saved_ledger = Ledger(counts=first_counts)
        self._saved_order = self._saved_act_id = self._last_act_id = 0
        self._recent: dict[int, Act] = {}
        self._unsettled: dict[int, Act] = {}
        self._open_jobs: dict[str, tuple[JobRecord, JobFiles]] = {}
        # What the file does not have yet.
        self._new_intents: dict[int, Act] = {}
        self._new_outcomes: list[Act] = []
        """In the order in which they became known."""
        self._new_jobs: dict[str, tuple[JobRecord, JobFiles | None]] = {}
        # Changes are counted; the file has all up to ``_saved``.
        self._changes = self._saved = self._tried = 0
        self._attempt: asyncio.Task[None] | None = None
        self._alarm: asyncio.TimerHandle | None = None
        self._failing = False

    @classmethod
    async def open(
        cls, path: Path, clock: Clock, first_counts: Counts, *, config_sha256: str = ""
    ) -> Self:
        """A journal that has started; see ``start``."""
        journal = cls(path, clock, first_counts, config_sha256=config_sha256)
        await journal.start()
        return journal

    async def start(self) -> None:
        """Open the file, or make a new one; lock it against other daemons until ``close``. Does
        nothing when it has started.

        A file that was damaged while it was open is let go of, so that it can be mended; starting
        again believes what stands there then, and nothing else.

        All of the file is looked at, and one of an older version is brought to this one.

        Raises:
            ConfigError: another daemon uses it (the message names its process), this user cannot
                write there, or a newer cellctl wrote it.
            CellFault: ``journal_damaged``: it is left as it is; ``journal_failed``.
        """
        if self._thread is not None:
            return
        self._lock.acquire()
        thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="journal")
        try:
            contents = await asyncio.get_running_loop().run_in_executor(
                thread,
                self._writer.open,
                self._first_counts,
                self._clock.wall_time(),
                REMEMBERED_ACTS,
            )
        except BaseException:
            thread.submit(self._writer.close)
            thread.shutdown()
            self._lock.release()
            raise
        self._thread, self._damage = thread, None
        for unwritten in (self._new_intents, self._new_outcomes, self._new_jobs):
            unwritten.clear()
        self._saved = self._tried = self._changes
        self._failing = False
        self._ledger = self._saved_ledger = contents.ledger
        self._saved_order = contents.settled_order
        self._saved_act_id = self._last_act_id = contents.act_id
        self._recent = {act.act_id: act for act in contents.recent}
        self._unsettled = {act.act_id: act for act in contents.unsettled}
        self._open_jobs = {record.job_id: (record, files) for record, files in contents.open_jobs}

    async def close(self) -> None:
        """Write what is left, and let go of the file; a failure is logged."""
        if self._thread is None:
            return
        try:
            await self.flush()
        except CellFault as fault:
            log.error("journal closed with unwritten acts", reason=str(fault))  # noqa: TRY400
        finally:
            if self._alarm is not None:
                self._alarm.cancel()
            await asyncio.gather(*filter(None, [self._attempt]), return_exceptions=True)
            await self._in_thread(self._writer.close)
            self._thread.shutdown()
            self._thread = None
            self._lock.release()

    @property
    def is_open(self) -> bool:
        """Whether it has started, and its file was not damaged since."""
        return self._thread is not None

    # --- what is believed ---------------------------------------------------------------------

    @property
    def ledger(self) -> Ledger:
        """What is believed of the cell, after all acts that are settled."""
        return self._ledger

    def unsettled(self) -> tuple[Act, ...]:
        """Acts without an outcome, oldest first."""
        return tuple(self._unsettled.values())

    def recent(self, limit: int) -> tuple[Act, ...]:
        """The newest acts, newest first; at most ``REMEMBERED_ACTS``."""
        return tuple(reversed(self._recent.values()))[:limit]

    def open_job(self) -> tuple[JobRecord, JobFiles] | None:
        """The newest job that has not finished."""
        return next(reversed(self._open_jobs.values()), None)

    # --- what is written ----------------------------------------------------------------------

    async def intend(
        self, kind: ActKind, job_id: str, step: int | None = None, cell: Cell | None = None
    ) -> int:
        """See ``Journal.intend``; whoever is cancelled while waiting has not begun."""
        act = Act(
            act_id=self._next_act_id(),
            kind=kind,
            job_id=job_id,
            step=step,
            cell=cell,
            intended_at=self._clock.wall_time(),
        )
        self._new_intents[act.act_id] = self._unsettled[act.act_id] = act
        self._remember(act)
        self._changes += 1
        try:
            await self.flush()
        except BaseException:
            self._call_off(act)
            raise
        return act.act_id

    def settle(
        self,
        act_id: int,
        outcome: Outcome,
        detail: str = "",
        moves: tuple[Move, ...] = (),
        belt_indexes: int | None = None,
    ) -> None:
        """See ``Journal.settle``."""
        act = self._unsettled[act_id].model_copy(
            update={
                "settled_at": self._clock.wall_time(),
                "outcome": outcome,
                "detail": detail,
                "moves": moves,
                "belt_indexes": belt_indexes,
            }
        )
        self._believe(act)
        del self._unsettled[act_id]
        self._new_intents.pop(act_id, None)
        self._write_soon(_LINGER_S)

    async def record(
        self,
        kind: ActKind,
        *,
        job_id: str = "",
        cell: Cell | None = None,
        detail: str = "",
        moves: tuple[Move, ...] = (),
        counts: Counts | None = None,
    ) -> None:
        """See ``Journal.record``; nothing of it is believed when it cannot be written."""
        now = self._clock.wall_time()
        act = Act(
            act_id=self._last_act_id + 1,
            kind=kind,
            job_id=job_id,
            cell=cell,
            intended_at=now,
            settled_at=now,
            outcome="done",
            detail=detail,
            moves=moves,
            counts=counts,
        )
        self._believe(act)
        self._next_act_id()
        try:
            await self.flush()
        except CellFault:
            self._take_back(act)
            raise

    def keep_job(self, record: JobRecord, files: JobFiles | None = None) -> None:
        """See ``Journal.keep_job``."""
        job_id = record.job_id
        _, known = self._open_jobs.get(job_id, (None, JobFiles()))
        _, waiting = self._new_jobs.get(job_id, (None, None))
        self._new_jobs[job_id] = (record, files if files is not None else waiting)
        if record.finished_at is None:
            self._open_jobs[job_id] = (record, files if files is not None else known)
        else:
            self._open_jobs.pop(job_id, None)
        self._changes += 1
        self._write_soon(_LINGER_S)

    async def flush(self) -> None:
        """Wait until everything is on disk.

        Raises:
            CellFault: ``journal_failed``, ``journal_damaged``.
        """
        wanted = self._changes
        while self._saved < wanted:
            try:
                async with asyncio.timeout(_PATIENCE_S):
                    await asyncio.shield(self._attempt or self._begin_attempt())
            except TimeoutError:
                raise CellFault(
                    "journal_failed", f"{self._path}: the disk does not answer."
                ) from None
            except CellFault:
                # An attempt that began before this change was made says nothing about it.
                if self._attempt is None and self._tried >= wanted:
                    raise

    async def prune(self, keep_days: float, keep_jobs: int) -> int:
        """Let go of what is old; the file gives its space back to the disk.

        What stays: jobs that finished within so many days, the newest jobs however old, jobs that
        have not finished, the acts of all of them, acts without an outcome, and the inventory.

        Returns:
            How many jobs and acts were removed.

        Raises:
            CellFault: ``journal_failed``, ``journal_damaged``.
        """
        await self.flush()
        now = self._clock.wall_time()
        policy = Policy(now - timedelta(days=keep_days), keep_jobs)
        await self._in_thread(
            self._writer.checkpoint,
            self._saved_ledger,
            self._saved_order,
            self._saved_act_id,
            now,
        )
        total = 0
        while removed := await self._in_thread(self._writer.prune, policy):
            total += removed
        while await self._in_thread(self._writer.shrink):
            pass
        if total:
            log.info("journal pruned", removed=total)
        return total

    # --- inside -------------------------------------------------------------------------------

    def _next_act_id(self) -> int:
        self._last_act_id += 1
        return self._last_act_id

    def _believe(self, act: Act) -> None:
        """Take an outcome into the ledger.

        Raises:
            InventoryError: it cannot be; nothing has changed.
        """
        self._ledger = self._ledger.after(act)
        self._new_outcomes.append(act)
        self._remember(act)
        self._changes += 1

    def _remember(self, act: Act) -> None:
        self._recent[act.act_id] = act
        if len(self._recent) > REMEMBERED_ACTS:
            del self._recent[next(iter(self._recent))]

    def _call_off(self, act: Act) -> None:
        """An intent was not waited for: nothing has begun."""
        if act.act_id not in self._unsettled:
            return
        if self._attempt is None and act.act_id in self._new_intents:
            for acts in (self._unsettled, self._new_intents, self._recent):
                acts.pop(act.act_id, None)
        else:
            self.settle(act.act_id, "interrupted", "It was called off before it began.")

    def _take_back(self, act: Act) -> None:
        """Forget an act that could not be written, unless later ones build upon it."""
        others = [other for other in self._new_outcomes if other is not act]
        try:
            ledger = reduce(Ledger.after, others, self._saved_ledger)
        except InventoryError:
            return
        self._ledger, self._new_outcomes = ledger, others
        self._recent.pop(act.act_id, None)

    def _write_soon(self, delay_s: float) -> None:
        if self._alarm is None:
            self._alarm = asyncio.get_running_loop().call_later(delay_s, self._write_now)

    def _write_now(self) -> None:
        self._alarm = None
        if self._attempt is None and self._saved < self._changes:
            self._begin_attempt()

    def _begin_attempt(self) -> asyncio.Task[None]:
        attempt = asyncio.create_task(self._write(), name="journal")
        attempt.add_done_callback(_failure_is_known)
        self._attempt = attempt
        return attempt

    async def _write(self) -> None:
        """One attempt to write all that the file does not have yet."""
        intents, outcomes = dict(self._new_intents), tuple(self._new_outcomes)
        jobs, ledger, last_act_id = dict(self._new_jobs), self._ledger, self._last_act_id
        self._tried = self._changes
        orders = range(self._saved_order + 1, self._saved_order + 1 + len(outcomes))
        batch = Batch(
            acts=(
                *((act, None) for act in intents.values()),
                *zip(outcomes, orders, strict=True),
            ),
            jobs=tuple(jobs.values()),
            saved_act_id=self._saved_act_id,
        )
        try:
            await self._in_thread(self._writer.write, batch)
        except CellFault as fault:
            if not self._failing:
                log.error("journal cannot be written", reason=str(fault))  # noqa: TRY400
            self._failing = True
            if fault.code == "journal_damaged":
                await self._let_go(fault)
            else:
                self._write_soon(_RETRY_S)
            raise
        finally:
            self._attempt = None
        if self._failing:
            log.info("journal can be written again", acts=len(batch.acts))
        self._failing = False
        self._saved, self._saved_ledger, self._saved_act_id = self._tried, ledger, last_act_id
        self._saved_order += len(outcomes)
        # Meanwhile new ones may have come; none of these was called off.
        del self._new_outcomes[: len(outcomes)]
        for act_id in intents:
            self._new_intents.pop(act_id, None)
        for job_id, kept in jobs.items():
            if self._new_jobs.get(job_id) is kept:
                del self._new_jobs[job_id]
        if self._saved < self._changes:
            self._write_soon(_LINGER_S)

    async def _let_go(self, damage: CellFault) -> None:
        """Close a file that is of no use, and leave it to whoever can mend it."""
        self._damage = CellFault(damage.code, damage.detail)
        await self._in_thread(self._writer.close)
        if self._thread is not None:
            self._thread.shutdown(wait=False)
        self._thread = None
        self._lock.release()

    async def _in_thread(self, work: Callable[..., T], *arguments: object) -> T:
        if self._thread is None:
            raise self._damage or CellFault("journal_failed", f"{self._path}: it is not open.")
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._thread, lambda: work(*arguments))


def _failure_is_known(attempt: asyncio.Task[None]) -> None:
    """Those who wait for it get it, and it was logged."""
    if not attempt.cancelled():
        attempt.exception()
