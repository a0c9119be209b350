"""The paper's counts, as the world counts them."""

from __future__ import annotations

import pytest

from cellctl.assembly import Cell
from cellctl.sim.world_support import adrift, falling, overhangs


def cells(*rows: tuple[int, int, int]) -> set[Cell]:
    return {Cell(*row) for row in rows}


def bar(length: int, *feet: int) -> set[Cell]:
    """A bar along x in layer 1, with a foot under each of the given places."""
    return cells(*((x, 0, 1) for x in range(length)), *((x, 0, 0) for x in feet))


@pytest.mark.parametrize(
    ("length", "feet", "runs"),
    [
        (4, (0,), 0),  # three cells hang out
        (5, (0,), 1),
        (5, (0, 4), 0),  # three between two feet
        (6, (0, 5), 2),  # four between two feet, counted from both
        (7, (3,), 0),  # three to either side
        (9, (4,), 2),
    ],
)
def test_more_than_three_unsupported_cells_in_a_row_do_not_hold(
    length: int, feet: tuple[int, ...], runs: int
) -> None:
    assert len(overhangs(bar(length, *feet), limit=3)) == runs


def test_a_gap_ends_the_walk() -> None:
    shape = bar(3, 0) | cells((4, 0, 1), (5, 0, 1))
    assert overhangs(shape, limit=2) == []


def test_y_counts_as_x_does() -> None:
    turned = {Cell(cell.y, cell.x, cell.z) for cell in bar(5, 0)}
    assert overhangs(turned, limit=3) == [tuple(Cell(0, y, 1) for y in range(1, 5))]


def test_the_newest_part_of_a_run_is_the_one_that_drops() -> None:
    bridge = bar(6, 0, 5)
    assert falling(bridge, limit=3, newest=Cell(2, 0, 1)) == cells((2, 0, 1))


def test_without_a_newest_part_all_past_the_limit_drops() -> None:
    assert falling(bar(6, 0), limit=3, newest=None) == cells((4, 0, 1), (5, 0, 1))


def test_what_no_chain_of_faces_joins_to_the_floor_is_adrift() -> None:
    shape = bar(2, 0) | cells((1, 1, 2), (4, 4, 3))
    assert adrift(shape) == cells((1, 1, 2), (4, 4, 3))
    assert adrift(set()) == set()
