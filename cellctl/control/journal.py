"""What the cell did: every physical act as an intent before it and an outcome after it.

An act that has an intent and no outcome is what a crash leaves behind.
"""

from __future__ import annotations

from collections import OrderedDict
from datetime import datetime
from enum import StrEnum
from typing import Literal, Protocol

from cellctl.assembly import Cell, Value
from cellctl.clock import Clock

Outcome = Literal["done", "failed", "interrupted"]


class ActKind(StrEnum):
    """The physical acts that a journal knows."""

    FEED = "feed"
    PICK = "pick"
    PLACE = "place"
    RELEASE = "release"
    RETREAT = "retreat"
    CLEAR = "clear"


class Act(Value):
    """One physical act."""

    act_id: int
    kind: ActKind
    job_id: str
    step: int | None
    cell: Cell | None
    intended_at: datetime
    settled_at: datetime | None = None
    outcome: Outcome | None = None
    """None while the act is under way, or was cut off."""
    detail: str = ""


class Journal(Protocol):
    """Where acts are written down."""

    def intend(
        self, kind: ActKind, job_id: str, step: int | None = None, cell: Cell | None = None
    ) -> int:
        """Write an intent and return the act's id; ids grow and are never used twice."""
        ...

    def settle(self, act_id: int, outcome: Outcome, detail: str = "") -> None:
        """Write the outcome of an act.

        Raises:
            KeyError: there is no such act.
            ValueError: the act has an outcome already.
        """
        ...

    def unsettled(self) -> tuple[Act, ...]:
        """Acts without an outcome, oldest first."""
        ...

    def recent(self, limit: int) -> tuple[Act, ...]:
        """The newest acts, newest first."""
        ...


class MemoryJournal:
    """A journal that lives as long as its process.

    Args:
        clock: gives the calendar time of intents and outcomes.
        capacity: how many settled acts are kept; unsettled ones are always kept.
    """

    def __init__(self, clock: Clock, capacity: int = 10_000) -> None:
        self._clock = clock
        self._capacity = capacity
        self._next_id = 1
        self._acts: OrderedDict[int, Act] = OrderedDict()

    def intend(
        self, kind: ActKind, job_id: str, step: int | None = None, cell: Cell | None = None
    ) -> int:
        act_id = self._next_id
        self._next_id += 1
        self._acts[act_id] = Act(
            act_id=act_id,
            kind=kind,
            job_id=job_id,
            step=step,
            cell=cell,
            intended_at=self._clock.wall_time(),
        )
        self._prune()
        return act_id

    def settle(self, act_id: int, outcome: Outcome, detail: str = "") -> None:
        act = self._acts[act_id]
        if act.outcome is not None:
            raise ValueError(f"act {act_id} has the outcome {act.outcome} already")
        self._acts[act_id] = act.model_copy(
            update={
                "outcome": outcome,
                "settled_at": self._clock.wall_time(),
                "detail": detail,
            }
        )

    def unsettled(self) -> tuple[Act, ...]:
        return tuple(act for act in self._acts.values() if act.outcome is None)

    def recent(self, limit: int) -> tuple[Act, ...]:
        return tuple(list(self._acts.values())[: -limit - 1 : -1])

    def _prune(self) -> None:
        if len(self._acts) <= self._capacity:
            return
        oldest = next((i for i, act in self._acts.items() if act.outcome is not None), None)
        if oldest is not None:
            del self._acts[oldest]
