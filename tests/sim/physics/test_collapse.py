"""What stands and what falls, against closed forms and laws that must hold."""

from __future__ import annotations

import random
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.assembly import Cell
from cellctl.sim.physics import Material, collapse

from .structures import (
    WEIGHT_N,
    Contact,
    arm,
    bridge,
    cells,
    column,
    material,
    random_structure,
)

NEAR = 0.003
"""How near to a closed form the verdict turns, as a share of it."""


@pytest.mark.parametrize("length", [1, 2, 3, 4, 5])
def test_an_arm_of_n_needs_n_squared_weights(length: int) -> None:
    needed_n = length**2 * WEIGHT_N
    strong = material(needed_n * (1 + NEAR), friction=2.0)
    weak = material(needed_n * (1 - NEAR), friction=2.0)
    assert collapse(arm(length), strong) is None
    assert collapse(arm(length), weak) is not None


@pytest.mark.parametrize(("floor_grips", "height"), [(True, 1), (True, 4), (False, 1), (False, 4)])
@pytest.mark.parametrize("contact", ["diamond", "square"])
def test_a_column_bears_a_push_to_the_side(
    floor_grips: bool, height: int, contact: Contact
) -> None:
    """On a floor that grips half of (one weight + F / n), on a bare one half a weight."""
    pull_n = 22.0 if floor_grips else 0.0
    most_n = (WEIGHT_N + pull_n / height) / 2

    def verdict(share: float) -> object:
        stuff = material(floor_grips=floor_grips, friction=2.0, down_n=0.0, side_n=share * most_n)
        return collapse(
            column(height), replace(stuff, contact=contact), newest=Cell(0, 0, height - 1)
        )

    assert verdict(1 - NEAR) is None
    assert verdict(1 + NEAR) is not None


@pytest.mark.parametrize(("contact", "levers"), [("diamond", 2.0), ("square", 2.0**0.5)])
def test_an_arm_around_a_corner_needs_friction(contact: Contact, levers: float) -> None:
    """Its first joint bears three weights, and the twist of one with the lever of a whole part."""
    bent = arm(2) | cells((2, 1, 1))
    needed_n = (3 + levers) * WEIGHT_N / 0.5
    assert collapse(bent, material(needed_n * (1 + NEAR), contact=contact)) is None
    assert collapse(bent, material(needed_n * (1 - NEAR), contact=contact)) is not None


def test_the_defaults_hold_what_the_paper_saw_hold() -> None:
    for length in (1, 2, 3):
        assert collapse(arm(length), material(), Cell(length, 0, 1)) is None
    for height in (1, 2, 3, 4):
        assert collapse(column(height), material(), Cell(0, 0, height - 1)) is None
    assert collapse(arm(4), material()) is not None
    assert collapse(column(5), material()) is None
    assert collapse(column(5), material(), Cell(0, 0, 4)) is not None


def test_a_bridge_spans_more_than_an_arm_reaches() -> None:
    assert collapse(bridge(4), material()) is None
    assert collapse(bridge(12, z=3), material()) is None
    assert collapse(bridge(15, z=3), material()) is not None


def test_on_a_bare_floor_what_leans_too_far_tips_as_a_whole() -> None:
    bare = material(floor_grips=False)
    assert collapse(arm(1), bare) is None
    tipped = collapse(arm(2), bare)
    assert tipped is not None
    assert frozenset(tipped.moving) == arm(2)
    assert str(tipped.weakest) == "between the floor and cell (0, 0, 0)"


def test_only_what_breaks_off_falls_and_the_weakest_joint_is_named() -> None:
    beside = column(3, x=0, y=1) | column(1, x=5)
    found = collapse(arm(4, z=2) | beside, material())
    assert found is not None
    assert found.moving == tuple(Cell(x, 0, 2) for x in range(1, 5))
    assert str(found.weakest) == "between cells (0, 0, 2) and (1, 0, 2)"
    assert not found.pushed


def test_a_push_that_topples_a_column_leaves_its_neighbour_alone() -> None:
    found = collapse(column(5) | column(5, x=2), material(), newest=Cell(0, 0, 4))
    assert found is not None
    assert frozenset(found.moving) == column(5)
    assert found.pushed


def test_a_part_that_joins_others_at_its_side_is_not_pushed_aside() -> None:
    strong = material(side_n=1e3)
    assert collapse(arm(1), strong, newest=Cell(1, 0, 1)) is None
    assert collapse(arm(1), strong, newest=Cell(0, 0, 1)) is not None


def test_nothing_stands() -> None:
    assert collapse(frozenset(), material()) is None


@pytest.mark.parametrize("contact", ["diamond", "square"])
@pytest.mark.parametrize("floor_grips", [True, False])
@settings(deadline=None, max_examples=12)
@given(seed=st.integers(0, 10_000), parts=st.integers(2, 12))
def test_laws_that_every_verdict_keeps(
    contact: Contact, floor_grips: bool, seed: int, parts: int
) -> None:
    chance = random.Random(seed)  # noqa: S311 - repeatable chance
    structure = random_structure(chance, parts)
    stuff = replace(
        material(chance.choice([8.0, 15.0, 22.0]), floor_grips=floor_grips), contact=contact
    )
    newest = chance.choice([None, *sorted(structure)])
    found = collapse(structure, stuff, newest)
    # Turned by a quarter about the vertical, the same happens.
    quarter = {cell: Cell(-cell.y, cell.x, cell.z) for cell in structure}
    turned = collapse(frozenset(quarter.values()), stuff, quarter[newest] if newest else None)
    assert (found is None) == (turned is None)
    if found is None:
        # Stronger magnets and rougher faces hold as well, and so does the structure at rest.
        assert collapse(structure, stronger(stuff, 1.3), newest) is None
        assert collapse(structure, stuff) is None
        return
    assert set(found.moving) <= structure
    assert {found.weakest.lower, found.weakest.upper} & set(found.moving)
    assert collapse(structure, stronger(stuff, 1 / 1.3), newest) is not None
    if not found.pushed and turned is not None:
        assert {quarter[cell] for cell in found.moving} == set(turned.moving)


def stronger(stuff: Material, by: float) -> Material:
    return replace(
        stuff,
        magnet=stuff.magnet * by,
        floor_magnet=stuff.floor_magnet * by,
        friction=stuff.friction * by,
    )
