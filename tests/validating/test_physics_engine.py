"""The engine that judges the judges, against closed forms."""

from __future__ import annotations

from typing import Any

import pytest

from cellctl.assembly import Cell
from tests.physics_engine import Contact, Push, least_force_n, stands

WEIGHT_N = 0.15 * 9.80665
PARTS: dict[str, Any] = {"mass_kg": 0.15, "pitch_m": 0.1}


def row(length: int, z: int = 1) -> frozenset[Cell]:
    """A column, and so many cells in a row that reach out from its top."""
    return column(z + 1) | {Cell(x, 0, z) for x in range(1, length + 1)}


def column(height: int, x: int = 0) -> frozenset[Cell]:
    return frozenset(Cell(x, 0, z) for z in range(height))


@pytest.mark.parametrize("length", [2, 3])
def test_a_cantilever_of_n_needs_n_squared_weights(length: int) -> None:
    found = least_force_n(row(length), friction=0.8, contact="diamond", floor_grips=True, **PARTS)
    assert found == pytest.approx(length**2 * WEIGHT_N, rel=0.04)


@pytest.mark.parametrize(("floor_grips", "height"), [(True, 1), (True, 4), (False, 1), (False, 4)])
@pytest.mark.parametrize("contact", ["diamond", "square"])
def test_a_column_bears_a_push_to_the_side(
    floor_grips: bool, height: int, contact: Contact
) -> None:
    """On a floor that grips half of (one weight + F / n), on a bare one half a weight."""
    most_n = (WEIGHT_N + (22.0 / height if floor_grips else 0.0)) / 2

    def bears(share: float) -> bool:
        return stands(
            column(height),
            magnet_force_n=22.0,
            friction=1.0,
            contact=contact,
            floor_grips=floor_grips,
            push=Push(Cell(0, 0, height - 1), (share * most_n, 0.0, 0.0)),
            **PARTS,
        )

    assert bears(0.94)
    assert not bears(1.06)


@pytest.mark.parametrize(("contact", "levers"), [("diamond", 2.0), ("square", 2.0**0.5)])
def test_an_arm_around_a_corner_needs_friction(contact: Contact, levers: float) -> None:
    """Its first joint bears three weights, and the twist of one with the lever of a whole part."""
    bent = row(2) | {Cell(2, 1, 1)}
    found = least_force_n(bent, friction=0.5, contact=contact, floor_grips=True, **PARTS)
    assert found == pytest.approx((3 + levers) * WEIGHT_N / 0.5, rel=0.06)


def test_a_bridge_spans_more_than_a_cantilever_reaches() -> None:
    def holds(cells: frozenset[Cell]) -> bool:
        return stands(
            cells, magnet_force_n=22.0, friction=0.5, contact="diamond", floor_grips=True, **PARTS
        )

    assert not holds(row(5))
    assert holds(row(5) | column(2, x=6))


def test_parts_that_nothing_holds_fall() -> None:
    apart = column(1) | {Cell(2, 0, 2)}
    needed = least_force_n(apart, friction=0.5, contact="diamond", floor_grips=True, **PARTS)
    assert needed == float("inf")
