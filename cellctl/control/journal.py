"""What the cell did: every physical act as an intent before it and an outcome after it.

What is believed of the cell is a ``Ledger``, a fold over the acts that are settled. An act that has
an intent and no outcome is what a crash leaves behind.
"""

from __future__ import annotations

from typing import Protocol

from cellctl.assembly import Cell
from cellctl.control.acts import Act, ActKind, JobFiles, JobRecord, Outcome
from cellctl.control.ledger import Ledger
from cellctl.feeding.inventory import Counts, Move


class Journal(Protocol):
    """Where acts and jobs are written down, in the order of the calls."""

    @property
    def ledger(self) -> Ledger:
        """What is believed of the cell, after all acts that are settled."""
        ...

    @property
    def is_open(self) -> bool:
        """Whether it has started, and its file was not damaged since."""
        ...

    async def start(self) -> None:
        """Open it; does nothing when it is open.

        Raises:
            ConfigError: another daemon uses it, or this one cannot.
            CellFault: ``journal_damaged``, ``journal_failed``.
        """
        ...

    async def intend(
        self, kind: ActKind, job_id: str, step: int | None = None, cell: Cell | None = None
    ) -> int:
        """Write an intent; when this returns, it and all before it survive a loss of power.

        Returns:
            The act's id.

        Raises:
            CellFault: ``journal_failed``: nothing may move, for it could not be written down.
        """
        ...

    def settle(
        self,
        act_id: int,
        outcome: Outcome,
        detail: str = "",
        moves: tuple[Move, ...] = (),
        belt_indexes: int | None = None,
    ) -> None:
        """Give an act its outcome. The ledger has it at once, the disk before the next intent.

        Raises:
            KeyError: there is no such act without an outcome.
            InventoryError: the moves are impossible; the act stays without an outcome.
        """
        ...

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
        """Write an act that is over already, as what a person did; durable when this returns.

        Raises:
            InventoryError: the moves are impossible; nothing was written.
            CellFault: ``journal_failed``.
        """
        ...

    def unsettled(self) -> tuple[Act, ...]:
        """Acts without an outcome, oldest first."""
        ...

    def recent(self, limit: int) -> tuple[Act, ...]:
        """The newest acts, newest first; those whose writing is still under way included."""
        ...

    def keep_job(self, record: JobRecord, files: JobFiles | None = None) -> None:
        """Write a job's record, on disk before the next intent; no ``files`` leaves them as they
        are."""
        ...

    def open_job(self) -> tuple[JobRecord, JobFiles] | None:
        """The newest job that has not finished."""
        ...

    async def flush(self) -> None:
        """Wait until everything is on disk.

        Raises:
            CellFault: ``journal_failed``.
        """
        ...
