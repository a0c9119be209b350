"""Wishes that wait for their turn: a pure list, and its form on disk."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import Path

import structlog
from pydantic import TypeAdapter, ValidationError

from cellctl.assembly import Utterance, Value
from cellctl.messages import QueueEntry

log = structlog.get_logger(__name__)


class Waiting(Value):
    """One wish that waits."""

    entry: QueueEntry
    """What everybody may know of it."""
    utterance: Utterance
    copies: int = 1
    """How many of it are still wanted."""


_FILE = TypeAdapter(tuple[Waiting, ...])


class WaitingList:
    """Wishes in the order in which they came.

    Args:
        limit: how many may wait; 0 takes none.
        per_visitor: how many of them may be one visitor's.
        expires_s: after so long an abandoned wish is forgotten (calendar time).
        path: where the list outlives the daemon.
    """

    def __init__(self, limit: int, per_visitor: int, expires_s: float, path: Path) -> None:
        self._limit = limit
        self._per_visitor = per_visitor
        self._expires = timedelta(seconds=expires_s)
        self._path = path
        self._waiting: tuple[Waiting, ...] = ()
        self._last_ticket = 0

    @property
    def entries(self) -> tuple[QueueEntry, ...]:
        """What everybody may know of them, the next one first."""
        return tuple(one.entry for one in self._waiting)

    def __len__(self) -> int:
        return len(self._waiting)

    def is_full_for(self, owner: str) -> bool:
        """Whether that visitor's wish cannot be taken."""
        own = sum(one.entry.owner == owner for one in self._waiting)
        return len(self._waiting) >= self._limit or own >= self._per_visitor

    def add(
        self,
        utterance: Utterance,
        wish: str,
        *,
        owner: str,
        name: str,
        now: datetime,
        copies: int = 1,
    ) -> QueueEntry:
        """Put a wish at the end; ``is_full_for`` its owner must be false."""
        assert not self.is_full_for(owner), "who may add was asked before"
        self._last_ticket += 1
        entry = QueueEntry(ticket=self._last_ticket, wish=wish, owner=owner, name=name, since=now)
        self._keep((*self._waiting, Waiting(entry=entry, utterance=utterance, copies=copies)))
        return entry

    def take_next(self) -> Waiting | None:
        """The wish whose turn it is; it leaves the list, but for the copies that follow it."""
        if not self._waiting:
            return None
        first, *others = self._waiting
        if first.copies > 1:
            others.append(first.model_copy(update={"copies": first.copies - 1}))
        self._keep(tuple(others))
        return first

    def put_back(self, one: Waiting) -> None:
        """What was taken could not be begun: it is the next one again, with all its copies."""
        rest = tuple(kept for kept in self._waiting if kept.entry.ticket != one.entry.ticket)
        self._keep((one, *rest))

    def drop(self, owner: str) -> QueueEntry | None:
        """Forget that visitor's newest wish."""
        for index in range(len(self._waiting) - 1, -1, -1):
            if self._waiting[index].entry.owner == owner:
                dropped = self._waiting[index].entry
                self._keep(self._waiting[:index] + self._waiting[index + 1 :])
                return dropped
        return None

    def remove(self, ticket: int) -> QueueEntry | None:
        """Forget one wish by its number; None when there is none."""
        found = next((one.entry for one in self._waiting if one.entry.ticket == ticket), None)
        if found is not None:
            self._keep(tuple(one for one in self._waiting if one.entry.ticket != ticket))
        return found

    def call(self, owner: str, name: str) -> None:
        """That visitor wants to be called so."""
        self._keep(
            tuple(
                one.model_copy(update={"entry": one.entry.model_copy(update={"name": name})})
                if one.entry.owner == owner
                else one
                for one in self._waiting
            )
        )

    def expire(self, now: datetime) -> tuple[QueueEntry, ...]:
        """Forget what nobody has come back for; returns what that was."""
        gone = tuple(e for e in self.entries if now - e.since > self._expires)
        if gone:
            self._keep(tuple(one for one in self._waiting if one.entry not in gone))
        return gone

    def recall(self) -> None:
        """Read what an earlier daemon kept; a file that cannot be read counts as empty."""
        try:
            self._waiting = _FILE.validate_json(self._path.read_bytes())
        except FileNotFoundError:
            return
        except (OSError, ValidationError) as error:
            log.warning("waiting list cannot be read", path=str(self._path), reason=str(error))
            return
        self._last_ticket = max((entry.ticket for entry in self.entries), default=0)

    def _keep(self, waiting: tuple[Waiting, ...]) -> None:
        """Change the list, and write it down: a name that is moved over the old one."""
        if waiting == self._waiting:
            return
        self._waiting = waiting
        fresh = self._path.with_suffix(".new")
        try:
            fresh.write_bytes(_FILE.dump_json(waiting))
            fresh.replace(self._path)
        except OSError as error:
            log.warning("waiting list cannot be kept", path=str(self._path), reason=str(error))
