"""The ledger: what is believed, as a fold over acts that keeps the number of parts."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cellctl.assembly import Cell
from cellctl.control.acts import Act, ActKind
from cellctl.control.ledger import Ledger
from cellctl.feeding.inventory import Counts, InventoryError, Move

NOW = datetime(2026, 5, 1, tzinfo=UTC)
HERE = Cell(1, 2, 0)


def act(kind: ActKind, *moves: Move, **values: Any) -> Act:
    return Act(
        **{
            "act_id": 1,
            "kind": kind,
            "intended_at": NOW,
            "settled_at": NOW,
            "outcome": "done",
            "moves": moves,
            **values,
        }
    )


PICK = act(ActKind.PICK, Move.PICK, belt_indexes=7)
PLACE = act(ActKind.PLACE)
RELEASE = act(ActKind.RELEASE, Move.PLACE, cell=HERE)


def after(*acts: Act, start: Counts | None = None) -> Ledger:
    ledger = Ledger(counts=start or Counts(belt=3, stock=2))
    for one in acts:
        ledger = ledger.after(one)
    return ledger


acts = st.builds(
    act,
    st.sampled_from(ActKind),
    st.sampled_from(Move),
    outcome=st.sampled_from(["done", "failed", "interrupted"]),
    cell=st.builds(Cell, st.integers(0, 1), st.integers(0, 1), st.just(0)),
)


@given(st.lists(acts, max_size=30))
def test_no_sequence_of_acts_makes_or_loses_a_part(history: list[Act]) -> None:
    ledger = Ledger(counts=Counts(stock=2, belt=4, handed_over=1, unknown=1))
    for one in history:
        try:
            ledger = ledger.after(one)
        except InventoryError:
            continue
        assert ledger.counts.total == 8
        assert len(ledger.standing) == ledger.counts.structure
        assert Ledger.model_validate_json(ledger.model_dump_json()) == ledger


def test_a_part_goes_from_the_belt_to_its_cell() -> None:
    held = after(PICK)
    assert held.holding
    assert held.lift_unchecked
    assert held.belt_indexes == 7
    carried = held.after(PLACE)
    assert not carried.lift_unchecked
    stands = carried.after(RELEASE)
    assert not stands.holding
    assert stands.standing == frozenset({HERE})


def test_a_missed_part_is_at_the_station_until_it_is_picked() -> None:
    missed = after(PICK, act(ActKind.PLACE, Move.MISS, outcome="failed"))
    assert missed.missed
    assert not missed.holding
    assert not missed.after(PICK).missed


def test_two_parts_cannot_stand_in_one_cell() -> None:
    with pytest.raises(InventoryError, match="Two parts would stand"):
        after(PICK, PLACE, RELEASE, PICK, PLACE, RELEASE)


def test_what_is_counted_in_the_structure_is_what_stands() -> None:
    with pytest.raises(InventoryError, match="0 cells hold one"):
        after(act(ActKind.COUNT, counts=Counts(stock=2, belt=2, structure=1)))


def test_only_buying_and_selling_changes_how_many_there_are() -> None:
    with pytest.raises(InventoryError, match="5 parts would become 6"):
        after(act(ActKind.COUNT, counts=Counts(stock=6)))
    assert after(act(ActKind.OWN, counts=Counts(stock=6))).counts.total == 6


def test_a_part_that_is_missing_leaves_its_cell() -> None:
    gone = after(PICK, PLACE, RELEASE, act(ActKind.MISSING, Move.LOSE_PLACED, cell=HERE))
    assert gone.standing == frozenset()
    assert gone.counts.unknown == 1


def test_a_part_that_falls_when_it_is_let_go_stands_nowhere() -> None:
    fell = act(ActKind.RELEASE, Move.PLACE, Move.LOSE_PLACED, cell=HERE, outcome="failed")
    ledger = after(PICK, PLACE, fell)
    assert ledger.standing == frozenset()
    assert ledger.counts.unknown == 1
    assert not ledger.holding
    assert not ledger.missed
    assert ledger.after(PICK).after(PLACE).after(RELEASE).standing == frozenset({HERE})


def test_clearing_takes_everything_out() -> None:
    clear = act(ActKind.CLEAR, Move.TAKE_APART)
    assert after(PICK, PLACE, RELEASE, clear) == after(PICK, PLACE, RELEASE, clear).model_copy(
        update={"standing": frozenset(), "counts": Counts(belt=2, stock=3)}
    )
