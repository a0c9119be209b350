"""Every order can be built from above, for any shape, and leaves no slot where none is needed."""

from __future__ import annotations

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from cellctl.assembly import Cell
from cellctl.config import LimitsSection
from cellctl.errors import PlanError
from cellctl.generating.boxes import Box
from cellctl.validating.repair import repair, size_of
from cellctl.validating.rules import check_all
from cellctl.validating.sequence import check_order, sequence, tight_fits
from tests.validating.shapes import CONFIG, cells_of, shape

furniture = st.lists(
    st.builds(
        Box,
        *(st.floats(0.0, 4.5) for _ in range(3)),
        *(st.floats(0.1, 4.0) for _ in range(3)),
    ),
    min_size=1,
    max_size=6,
)


def builds_from_above(order: tuple[Cell, ...]) -> bool:
    """A second opinion: a heap of parts, where each comes down its column."""
    heights: dict[tuple[int, int], int] = {}
    standing: set[Cell] = set()
    for x, y, z in order:
        beside = {(x + 1, y, z), (x - 1, y, z), (x, y + 1, z), (x, y - 1, z), (x, y, z - 1)}
        if z > 0 and not beside & standing:
            return False
        if heights.get((x, y), -1) >= z:
            return False
        standing.add(Cell(x, y, z))
        heights[x, y] = z
    return True


@given(boxes=furniture, parts=st.integers(1, 60), overhang=st.integers(0, 4))
@settings(max_examples=80, deadline=None)
def test_any_solid_ends_as_a_buildable_order_or_a_reasoned_refusal(
    boxes: list[Box], parts: int, overhang: int
) -> None:
    low = [min(box[i] for box in boxes) for i in range(3)]
    moved = [box._replace(x=box.x - low[0], y=box.y - low[1], z=box.z - low[2]) for box in boxes]
    limits = LimitsSection(inventory_parts=60, overhang_cells=overhang, stack_cells=4)
    whole = shape(*moved)
    try:
        repaired = repair(whole, limits, parts)
    except PlanError as refusal:
        said = refusal.message
        event("refused")
        if "cannot be built here" in said:
            return
        raise
    cells = repaired.cells
    assert 1 <= len(cells) <= parts
    assert all(check.passed for check in check_all(cells, limits, parts))
    assert all(edge <= room + 1 for edge, room in zip(size_of(cells), whole.extent, strict=True))
    order = sequence(cells, overhang)
    assert len(order) == len(cells)
    assert set(order) == cells
    assert builds_from_above(order)
    assert check_order(order).passed
    assert [cell.z for cell in order] == sorted(cell.z for cell in order)


@pytest.mark.parametrize(
    "boxes",
    [
        (Box(0, 0, 0, 5, 5, 1),),
        (Box(0, 0, 0, 4, 4, 2),),
        (Box(0, 0, 4, 4, 4, 1), *(Box(x, y, 0, 1, 1, 4) for x in (0, 3) for y in (0, 3))),
        (
            Box(0, 0, 0, 1, 2, 5),
            Box(4, 0, 0, 1, 2, 5),
            Box(0, 0, 2, 5, 2, 1),
            Box(0, 0, 4, 5, 2, 1),
        ),
    ],
    ids=["plate", "block", "table", "shelf"],
)
def test_nothing_is_pushed_between_two_parts_where_that_can_be_avoided(
    boxes: tuple[Box, ...],
) -> None:
    assert tight_fits(sequence(cells_of(*boxes), 3)) == ()


def test_a_ring_is_closed_at_a_corner() -> None:
    ring = cells_of(Box(0, 0, 0, 4, 4, 1)) - cells_of(Box(1, 1, 0, 2, 2, 1))
    assert tight_fits(sequence(ring, 3)) == ()


def test_a_part_between_two_others_is_counted() -> None:
    row = (Cell(0, 0, 0), Cell(2, 0, 0), Cell(1, 0, 0))
    assert tight_fits(row) == (Cell(1, 0, 0),)
    assert "1 goes between two others" in check_order(row).message


def test_an_unfinished_layer_never_hangs_out_further_than_the_limit() -> None:
    bridge = cells_of(Box(0, 0, 0, 1, 1, 2), Box(4, 0, 0, 1, 1, 2), Box(0, 0, 1, 5, 1, 1))
    order = sequence(bridge, 1)
    top = [cell.x for cell in order if cell.z == 1]
    assert top.index(4) < top.index(2)
    assert builds_from_above(order)


def test_the_bar_of_a_t_starts_at_its_column() -> None:
    order = sequence(cells_of(Box(1, 0, 0, 1, 1, 4), Box(0, 0, 4, 3, 1, 1)), 3)
    assert order[4] == Cell(1, 0, 4)


def test_a_part_beneath_or_adrift_fails_the_order_check() -> None:
    assert check_order((Cell(0, 0, 0), Cell(1, 0, 1))).cells == (Cell(1, 0, 1),)
    beneath = (Cell(0, 0, 0), Cell(0, 0, 1), Cell(1, 0, 1), Cell(1, 0, 0))
    assert check_order(beneath).cells == (Cell(1, 0, 0),)


def test_two_blocks_apart_are_refused_with_their_cells() -> None:
    apart = shape(Box(0, 0, 0, 2, 2, 2), Box(4, 0, 0, 2, 2, 2))
    with pytest.raises(PlanError, match="fall into 2 pieces") as refusal:
        repair(apart, CONFIG.limits, 40)
    assert "Cells: [" in refusal.value.message


def test_a_crumb_in_the_air_is_left_out_and_said() -> None:
    repaired = repair(shape(Box(0, 0, 0, 3, 3, 3), Box(4, 0, 3, 1, 1, 1)), CONFIG.limits, 40)
    assert repaired.cells == cells_of(Box(0, 0, 0, 3, 3, 3))
    assert [change.what for change in repaired.changes] == ["1 part is left out."]


def test_a_flat_shape_keeps_its_thickness() -> None:
    repaired = repair(shape(Box(0, 0, 0, 6, 0.4, 6)), CONFIG.limits, 10)
    assert size_of(repaired.cells)[1] == 1
    assert len(repaired.cells) == 9


def test_no_parts_no_plan() -> None:
    with pytest.raises(PlanError, match="no parts"):
        repair(shape(Box(0, 0, 0, 1, 1, 1)), CONFIG.limits, 0)
