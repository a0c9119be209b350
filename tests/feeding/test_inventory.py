"""The inventory: a fold over acts that neither makes nor loses a part."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cellctl.feeding.inventory import Act, Counts, Inventory, InventoryError, Place

counts = st.builds(
    Counts,
    **{
        place.value: st.integers(0, 1 if place is Place.GRIPPER else 3)
        for place in Place
    },
)  # fmt: skip


@given(counts, st.lists(st.sampled_from(Act), max_size=40))
def test_the_sum_is_constant_and_no_count_is_ever_impossible(
    start: Counts, acts: list[Act]
) -> None:
    inventory = Inventory(start)
    for act in acts:
        before = inventory.counts
        possible = getattr(before, act.source) > 0 and not (
            act.target is Place.GRIPPER and before.gripper == 1
        )
        if possible:
            inventory.apply(act)
            assert getattr(inventory.counts, act.source) == getattr(before, act.source) - 1
            assert getattr(inventory.counts, act.target) == getattr(before, act.target) + 1
        else:
            with pytest.raises(InventoryError):
                inventory.apply(act)
            assert inventory.counts == before
        assert inventory.counts.total == start.total
        assert Counts.model_validate(inventory.counts.model_dump()) == inventory.counts


def test_a_history_folds_to_what_stands() -> None:
    history = [Act.PICK, Act.PLACE, Act.PICK, Act.MISS, Act.PICK, Act.PLACE, Act.PICK]
    folded = Counts(belt=5).after_all(history)
    assert folded == Counts(belt=2, gripper=1, structure=2)


def test_available_is_what_can_be_placed_without_help() -> None:
    inventory = Inventory.full(40)
    assert inventory.available == 40
    inventory.apply(Act.PICK)
    assert inventory.available == 40
    inventory.apply(Act.PLACE)
    assert inventory.available == 39


def test_an_impossible_act_says_what_is_wrong() -> None:
    with pytest.raises(InventoryError, match="pick: the inventory counts no part in belt"):
        Counts().after(Act.PICK)
    with pytest.raises(InventoryError, match="already"):
        Counts(belt=1, gripper=1).after(Act.PICK)
