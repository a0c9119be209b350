"""Whose turn it is: the waiting list, and when the next wish may begin."""

from __future__ import annotations

from pathlib import Path

from cellctl.assembly import Utterance
from cellctl.clock import Clock
from cellctl.config import CellConfig
from cellctl.control.dialogue.waiting_list import Waiting, WaitingList
from cellctl.messages import QueueEntry


class Turns:
    """The wishes that wait, and the time since the cell came to rest.

    Args:
        config: the cell.
        clock: cell time, and the calendar.
    """

    def __init__(self, config: CellConfig, clock: Clock) -> None:
        talk = config.dialogue
        self._clock = clock
        self._grace_s = talk.take_along_s
        path = Path(config.journal.path).with_name("waiting.json")
        self._list = WaitingList(
            talk.queue_limit, talk.queue_per_visitor, talk.queue_expires_s, path
        )
        self._rested_s: float | None = None

    @property
    def entries(self) -> tuple[QueueEntry, ...]:
        """The wishes that wait, the next one first."""
        return self._list.entries

    def recall(self) -> None:
        """Take up what an earlier daemon kept."""
        self._list.recall()

    def waits_before(self, owner: str) -> bool:
        """Whether others' wishes wait, so that this visitor's comes after them."""
        return any(entry.owner != owner for entry in self._list.entries)

    def is_full_for(self, owner: str) -> bool:
        """Whether that visitor's wish cannot be taken."""
        return self._list.is_full_for(owner)

    def add(
        self, utterance: Utterance, wish: str, *, owner: str, name: str, copies: int = 1
    ) -> QueueEntry:
        """Put a wish at the end."""
        now = self._clock.wall_time()
        return self._list.add(utterance, wish, owner=owner, name=name, now=now, copies=copies)

    def drop(self, owner: str) -> QueueEntry | None:
        """Forget that visitor's newest wish."""
        return self._list.drop(owner)

    def remove(self, ticket: int) -> QueueEntry | None:
        """Forget one wish by its number."""
        return self._list.remove(ticket)

    def put_back(self, turn: Waiting) -> None:
        """It could not be begun: it is the next one again."""
        self._list.put_back(turn)

    def call(self, owner: str, name: str) -> None:
        """That visitor wants to be called so."""
        self._list.call(owner, name)

    def expire(self) -> tuple[QueueEntry, ...]:
        """Forget what nobody has come back for; returns what that was."""
        return self._list.expire(self._clock.wall_time())

    def next(self, *, at_rest: bool, standing: bool) -> Waiting | None:
        """The wish whose turn it is now; it leaves the list.

        What stands is left to its owner for a while, who may want to take it along.

        Args:
            at_rest: the cell waits for a wish.
            standing: something stands in the workspace.
        """
        now_s = self._clock.now_s()
        if not at_rest:
            self._rested_s = None
            return None
        if self._rested_s is None:
            self._rested_s = now_s
        if standing and now_s - self._rested_s < self._grace_s:
            return None
        return self._list.take_next()
