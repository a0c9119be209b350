"""Likeness: 1 for the same shape, less for every difference."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.assembly import Cell
from cellctl.generating.boxes import Box
from cellctl.validating.repairing.score import Wanted
from cellctl.validating.repairing.symmetry import orbits, symmetries
from cellctl.validating.rules import Cells
from tests.validating.furniture import LETTER_T, SHELF, TABLE
from tests.validating.shapes import cells_of

cells = st.frozensets(
    st.builds(Cell, st.integers(0, 3), st.integers(0, 3), st.integers(0, 3)),
    min_size=1,
    max_size=20,
)


def corner(found: Cells) -> Cells:
    low = [min(axis) for axis in zip(*found, strict=True)]
    return frozenset(Cell(c.x - low[0], c.y - low[1], c.z - low[2]) for c in found)


@given(cells, cells)
@settings(max_examples=100, deadline=None)
def test_likeness_is_one_for_the_same_cells_only(one: Cells, other: Cells) -> None:
    one, other = corner(one), corner(other)
    score = Wanted(one).score(other)
    assert 0.0 < score <= 1.0 + 1e-12
    assert (score > 1.0 - 1e-9) == (one == other)


@given(cells, st.integers(1, 3))
@settings(max_examples=50, deadline=None)
def test_only_the_size_differs_where_every_cell_is_doubled(one: Cells, times: int) -> None:
    larger = cells_of(
        *(Box(times * c.x, times * c.y, times * c.z, times, times, times) for c in one)
    )
    likeness = Wanted(corner(one)).likeness(larger)
    assert likeness.volume == pytest.approx((1.0, 1.0))
    assert likeness.outlines == pytest.approx((1.0, 1.0))
    assert likeness.score == pytest.approx(1.0 / times)


def test_likeness_by_hand() -> None:
    # A row of two against one of its cells: half of the length; stretched, the same.
    row = frozenset({Cell(0, 0, 0), Cell(1, 0, 0)})
    assert Wanted(row).score(frozenset({Cell(0, 0, 0)})) == pytest.approx(0.5 ** (1 / 3))
    # A corner of three cells against the full square: volume 3/3 over 4/3, the outline from above
    # likewise, those from the front and the side the same.
    square = cells_of(Box(0, 0, 0, 2, 2, 1))
    shared, covered = 1.0 + 1.0, 4 / 3 + (1.0 + 1.0 + 4 / 3) / 3
    assert Wanted(square - {Cell(1, 1, 0)}).score(square) == pytest.approx(shared / covered)


@given(cells, st.integers(1, 4), st.integers(1, 4), st.integers(1, 4))
@settings(max_examples=50, deadline=None)
def test_every_part_of_the_wanted_shape_falls_into_some_cell(
    one: Cells, nx: int, ny: int, nz: int
) -> None:
    terms = Wanted(corner(one)).terms((nx, ny, nz))
    assert terms.volume.sum() == pytest.approx(1.0)
    assert sum(outline.sum() for outline in terms.outlines) == pytest.approx(1.0)
    assert np.all(terms.volume <= terms.cell + 1e-12)


def test_symmetries_are_seen() -> None:
    assert [s.name for s in symmetries(cells_of(*LETTER_T), (3, 1, 6))] == [
        "left to right",
        "front to back",
        "by half a turn",
    ]
    assert [s.name for s in symmetries(cells_of(*TABLE), (4, 4, 6))] == ["about a diagonal"]
    assert len(symmetries(cells_of(Box(0, 0, 0, 3, 3, 2)), (3, 3, 2))) == 6


def test_orbits_tie_together_what_symmetry_does() -> None:
    shelf = cells_of(*SHELF)
    tied = orbits((6, 3, 6), symmetries(shelf, (6, 3, 6)))
    assert tied[Cell(5, 2, 3)] == Cell(0, 0, 3)
    assert len(set(tied.values())) == 3 * 2 * 6


def test_no_rounding_makes_it_more_than_all() -> None:
    for edges in itertools.product(range(1, 7), repeat=3):
        whole = cells_of(Box(0, 0, 0, *edges))
        assert Wanted(whole).score(whole) == pytest.approx(1.0, abs=1e-12)
        assert Wanted(whole).score(whole) <= 1.0
