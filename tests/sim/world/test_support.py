"""What rests on something, and what nothing joins to the floor."""

from __future__ import annotations

from cellctl.assembly import Cell
from cellctl.sim.world_support import adrift, supported


def cells(*rows: tuple[int, int, int]) -> set[Cell]:
    return {Cell(*row) for row in rows}


def test_the_floor_and_a_part_beneath_support() -> None:
    shape = cells((0, 0, 0), (1, 0, 1))
    assert supported(Cell(5, 5, 0), shape)
    assert supported(Cell(0, 0, 1), shape)
    assert not supported(Cell(1, 0, 1), shape)


def test_what_no_chain_of_faces_joins_to_the_floor_is_adrift() -> None:
    shape = cells((0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 1, 2), (4, 4, 3))
    assert adrift(shape) == cells((1, 1, 2), (4, 4, 3))
    assert adrift(set()) == set()
