"""Acts: intent before, outcome after."""

from __future__ import annotations

import pytest

from cellctl.assembly import Cell
from cellctl.clock import SystemClock
from cellctl.control.journal import ActKind, MemoryJournal


def journal(capacity: int = 100) -> MemoryJournal:
    return MemoryJournal(SystemClock(), capacity)


def test_an_intent_is_unsettled_until_it_has_an_outcome() -> None:
    book = journal()
    act = book.intend(ActKind.PICK, "job", 3, Cell(1, 2, 0))
    assert [entry.act_id for entry in book.unsettled()] == [act]
    book.settle(act, "done")
    assert book.unsettled() == ()
    (entry,) = book.recent(5)
    assert (entry.kind, entry.step, entry.cell, entry.outcome) == (
        ActKind.PICK,
        3,
        Cell(1, 2, 0),
        "done",
    )
    assert entry.settled_at is not None
    assert entry.settled_at >= entry.intended_at


def test_an_outcome_is_final() -> None:
    book = journal()
    act = book.intend(ActKind.PLACE, "job")
    book.settle(act, "interrupted", "stop")
    with pytest.raises(ValueError, match="has the outcome interrupted already"):
        book.settle(act, "done")


def test_an_unknown_act_is_an_error() -> None:
    with pytest.raises(KeyError):
        journal().settle(7, "done")


def test_ids_grow_and_unsettled_acts_outlive_the_limit() -> None:
    book = journal(capacity=3)
    first = book.intend(ActKind.PICK, "job")
    ids = [first]
    for _ in range(10):
        ids.append(book.intend(ActKind.FEED, "job"))
        book.settle(ids[-1], "done")
    assert ids == sorted(set(ids))
    assert [entry.act_id for entry in book.unsettled()] == [first]
    assert [entry.act_id for entry in book.recent(2)] == ids[:-3:-1]
