"""Which cells are told to be changed."""

from __future__ import annotations

from cellctl.assembly import Cell
from cellctl.generating.boxes import Box
from cellctl.validating.marking import laid_over
from cellctl.validating.plan import plan_build
from tests.validating.shapes import CONFIG, generated


def test_a_shape_is_laid_where_most_of_it_was_made() -> None:
    wanted = frozenset({Cell(0, 0, 0), Cell(1, 0, 0), Cell(1, 0, 1)})
    made = frozenset({Cell(4, 2, 0), Cell(5, 2, 0), Cell(5, 2, 1), Cell(4, 2, 1)})
    over = laid_over(wanted, made)
    assert over == made - {Cell(4, 2, 1)}
    assert laid_over(wanted, over) == frozenset()


def test_a_plan_tells_what_was_wanted_only_where_it_was_changed() -> None:
    pieces = plan_build(generated(Box(0, 0, 0, 1, 2, 2), Box(2, 0, 0, 1, 2, 2)), CONFIG)
    added = set(pieces.assembly.cells) - set(pieces.wanted)
    assert set(pieces.wanted) < set(pieces.assembly.cells)
    assert added
    assert all(0 < cell.x < CONFIG.grid[0] - 1 for cell in added)
    assert plan_build(generated(Box(0, 0, 0, 2, 1, 1)), CONFIG).wanted == ()
