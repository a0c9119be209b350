"""The inventory: a fold over moves that neither makes nor loses a part."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cellctl.feeding.inventory import Counts, InventoryError, Move, Place

counts = st.builds(
    Counts,
    **{
        place.value: st.integers(0, 1 if place is Place.GRIPPER else 3)
        for place in Place
    },
)  # fmt: skip


@given(counts, st.lists(st.sampled_from(Move), max_size=40))
def test_the_sum_is_constant_and_no_count_is_ever_impossible(
    start: Counts, moves: list[Move]
) -> None:
    now = start
    for move in moves:
        before = now
        possible = getattr(before, move.source) > 0 and not (
            move.target is Place.GRIPPER and before.gripper == 1
        )
        if possible:
            now = before.after(move)
            assert getattr(now, move.source) == getattr(before, move.source) - 1
            assert getattr(now, move.target) == getattr(before, move.target) + 1
        else:
            with pytest.raises(InventoryError):
                before.after(move)
        assert now.total == start.total
        assert Counts.model_validate(now.model_dump()) == now


def test_a_history_folds_to_what_stands() -> None:
    history = [Move.PICK, Move.PLACE, Move.PICK, Move.MISS, Move.PICK, Move.PLACE, Move.PICK]
    folded = Counts(belt=5).after_all(history)
    assert folded == Counts(belt=2, gripper=1, structure=2)


def test_available_is_what_an_object_may_have() -> None:
    full = Counts.at_first(40, 30)
    assert (full.belt, full.stock, full.available) == (30, 10, 40)
    picked = full.after(Move.PICK)
    assert picked.available == 40
    placed = picked.after(Move.PLACE)
    assert placed.available == 39
    assert placed.after(Move.TAKE_APART).available == 40
    for move in (Move.HAND_OVER, Move.LOSE_PLACED):
        assert placed.after(move).available == 39


def test_a_new_cell_has_its_parts_on_the_belt_as_far_as_they_go() -> None:
    assert Counts.at_first(10, 40) == Counts(belt=10)
    assert Counts.at_first(40, 40) == Counts(belt=40)


@given(counts, st.fixed_dictionaries({}, optional={
    place.value: st.integers(0, 4)
    for place in (Place.STOCK, Place.BELT, Place.HANDED_OVER, Place.SCRAP)
}))  # fmt: skip
def test_what_was_counted_holds_and_what_is_missing_then_is_unknown(
    start: Counts, counted: dict[str, int]
) -> None:
    sure = {place: counted.get(place, getattr(start, place)) for place in Place}
    seen = sum(sure.values()) - sure[Place.UNKNOWN]
    if seen > start.total:
        with pytest.raises(InventoryError, match=f"{seen - start.total} more than"):
            start.counted(**counted)
        return
    after = start.counted(**counted)
    assert after.total == start.total
    assert after.unknown == start.total - seen
    for place in Place:
        if place is not Place.UNKNOWN:
            assert getattr(after, place) == sure[place]


@given(counts, st.integers(0, 30))
def test_parts_are_bought_into_the_stock_and_sold_out_of_it(start: Counts, total: int) -> None:
    if total < start.total - start.stock:
        with pytest.raises(InventoryError, match=f"the stock has {start.stock}"):
            start.owning(total)
        return
    after = start.owning(total)
    assert after.total == total
    assert after.model_copy(update={"stock": start.stock}) == start


def test_an_impossible_move_says_what_is_wrong() -> None:
    with pytest.raises(InventoryError, match="pick: the inventory counts no part in belt"):
        Counts().after(Move.PICK)
    with pytest.raises(InventoryError, match="already"):
        Counts(belt=1, gripper=1).after(Move.PICK)
