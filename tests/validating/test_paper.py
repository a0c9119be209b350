"""The paper's algorithms give the paper's figures, out of solids and not of constants."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cellctl.assembly import Cell
from cellctl.config import LimitsSection
from cellctl.errors import PlanError
from cellctl.generating.boxes import Box
from cellctl.validating.clean import Surface
from cellctl.validating.fit import Shape
from cellctl.validating.paper import plan_paper, plan_paper_cells
from cellctl.validating.paper.counting import within_count
from cellctl.validating.paper.objects import OBJECTS, volume
from cellctl.validating.paper.policy import Module, process
from cellctl.validating.paper.scaling import (
    Rescaled,
    occupy,
    one_cell_smaller,
    scale_to_fit,
)
from cellctl.validating.paper.sequencing import Order, connectivity_order, naive_order
from cellctl.validating.paper.steadying import (
    cantilevers,
    longest_overhang,
    unseen,
    within_overhang,
    within_stack,
)
from cellctl.validating.rules import size_of, unsupported_stacks
from tests.validating.shapes import cells_of, paper, shape

LIMITS = LimitsSection(inventory_parts=40, overhang_cells=3, stack_cells=4)
WORKSPACE = (6, 5, 6)
SHAPES = {one.name: scale_to_fit(one.surface, WORKSPACE) for one in OBJECTS}
BASELINES = {name: occupy(found) for name, found in SHAPES.items()}


@pytest.mark.parametrize("name", list(SHAPES))
def test_the_solids_fill_the_workspace_and_occupy_the_papers_cells(
    test_data: Path, name: str
) -> None:
    cells, computed = paper(test_data, name)
    found = BASELINES[name].cells
    assert found == cells
    assert longest_overhang(found) == computed["overhang_walk"]
    assert unsupported_stacks(found, 4)[0] == computed["unsupported_stack"]
    assert bool(naive_order(found).mid_air) is not computed["naive_order_stays_connected"]


@pytest.mark.parametrize(
    ("name", "module", "before", "after", "size"),
    [
        ("stool", lambda found: within_count(found, 40), 45, 30, (4, 4, 4)),
        ("shelf", lambda found: within_count(found, 40), 60, 32, (5, 2, 5)),
        ("letter_t", lambda found: within_count(found, 40), 8, 8, (3, 1, 6)),
        ("table", lambda found: within_count(found, 40), 21, 21, (4, 4, 6)),
        ("stool", lambda found: within_overhang(found, 3), 45, 45, (5, 5, 5)),
        ("shelf", lambda found: within_overhang(found, 3), 60, 54, (5, 3, 6)),
        ("letter_t", lambda found: within_overhang(found, 3), 8, 8, (3, 1, 6)),
        ("table", lambda found: within_overhang(found, 3), 21, 21, (4, 4, 6)),
        ("stool", lambda found: within_stack(found, 4), 45, 45, (5, 5, 5)),
        ("shelf", lambda found: within_stack(found, 4), 60, 60, (6, 3, 6)),
        ("letter_t", lambda found: within_stack(found, 4), 8, 7, (3, 1, 5)),
        ("table", lambda found: within_stack(found, 4), 21, 20, (4, 4, 5)),
    ],
)
def test_tables_2_to_4(
    name: str,
    module: Callable[[Rescaled], Rescaled],
    before: int,
    after: int,
    size: tuple[int, int, int],
) -> None:
    baseline = BASELINES[name]
    assert len(baseline.cells) == before
    found = module(baseline)
    assert len(found.cells) == after
    assert size_of(found.cells) == size
    assert len(found.changes) == (0 if before == after else 1)


@pytest.mark.parametrize(
    ("name", "parts"), [("stool", 30), ("shelf", 32), ("letter_t", 7), ("table", 20)]
)
def test_the_complete_pipeline_builds_what_the_paper_built(name: str, parts: int) -> None:
    plan = plan_paper(SHAPES[name], LIMITS, 40)
    assert len(plan.order) == parts
    assert frozenset(plan.order) == plan.cells
    assert [check.name for check in plan.checks] == [
        "count",
        "overhang",
        "stack",
        "connectivity",
        "access",
    ]
    assert all(check.passed for check in plan.checks)


def test_a_change_says_what_and_why() -> None:
    (change,) = plan_paper(SHAPES["shelf"], LIMITS, 40).changes
    assert change.what == "It is 5 x 2 x 5 parts large instead of 6 x 3 x 6 (wide, deep, high)."
    assert change.why == "It would take 60 parts, and there are 40."


def test_one_component_is_one_cell_on_every_axis_and_no_ratio() -> None:
    smaller = one_cell_smaller(shape(Box(0, 0, 0, 6, 3, 4.5)), (0, 1, 2))
    assert smaller.extent == pytest.approx([5, 2, 3.5])
    assert one_cell_smaller(smaller, (1,)).extent == pytest.approx([5, 1, 3.5])


def test_a_flat_shape_keeps_its_thickness() -> None:
    sheet = shape(Box(0, 0, 0, 6, 0.2, 6))
    smaller = one_cell_smaller(sheet, (0, 1, 2))
    assert smaller.extent == pytest.approx([5, 0.2, 5])
    with pytest.raises(PlanError, match="one part thin"):
        one_cell_smaller(sheet, (1,))


def test_a_sheet_without_any_thickness_ends_too() -> None:
    corners = np.array([[0, 0, 0], [6, 0, 0], [6, 0, 6], [0, 0, 6]], dtype=np.float64)
    sheet = Shape(Surface(corners, np.array([[0, 1, 2], [0, 2, 3]])))
    found = process(sheet, LIMITS, 10)
    assert len(found.cells) == 9
    assert found.shape.extent == pytest.approx([3, 0, 3])


def test_the_longer_of_two_overhangs_is_shortened() -> None:
    arms = shape(
        Box(2, 2, 0, 1, 1, 2),
        Box(3, 2, 1, 4, 1, 1),
        Box(2, 3, 1, 1, 5, 1),
        Box(0, 0, 0, 0.5, 0.5, 0.5),
    )
    rows = cantilevers(occupy(arms).cells)
    assert [(row.axis, len(row.cells)) for row in rows] == [(1, 5), (0, 4)]
    found = within_overhang(occupy(arms), 4)
    assert size_of(found.cells) == (7, 7, 2)


def test_a_row_without_a_supported_part_is_not_seen_and_said_so() -> None:
    # Two arms reach out, and a long bar along y lies across their ends.
    cells = cells_of(Box(0, 0, 0, 1, 1, 2), Box(1, 0, 1, 1, 6, 1))
    assert longest_overhang(cells) == 1
    assert unseen(cells) == cells_of(Box(1, 1, 1, 1, 5, 1))
    checks = {check.name: check for check in plan_paper_cells(cells, LIMITS, 40).checks}
    assert checks["overhang"].passed
    assert "5 of 8 parts" in checks["overhang"].message


def test_the_order_goes_to_what_is_attached_first() -> None:
    cells = plan_paper(SHAPES["letter_t"], LIMITS, 40).cells
    column = tuple(Cell(1, 0, z) for z in range(4))
    bar = (Cell(1, 0, 4), Cell(2, 0, 4), Cell(0, 0, 4))
    assert connectivity_order(cells).cells == column + bar
    assert naive_order(cells).cells == (*column, Cell(0, 0, 4), Cell(1, 0, 4), Cell(2, 0, 4))
    assert naive_order(cells).mid_air == (Cell(0, 0, 4),)


def test_what_floats_until_a_later_part_joins_it_is_named_whole() -> None:
    bar = (Cell(2, 0, 1), Cell(1, 0, 1), Cell(0, 0, 1))
    order = Order((Cell(0, 0, 0), *bar))
    assert order.mid_air == (Cell(2, 0, 1), Cell(1, 0, 1))
    assert Order((Cell(0, 0, 0), *bar[::-1])).mid_air == ()


def test_the_fallback_takes_the_nearest_and_the_policy_refuses_it_by_name() -> None:
    apart = frozenset({Cell(0, 0, 0), Cell(5, 0, 1), Cell(2, 0, 1)})
    order = connectivity_order(apart)
    assert order.cells == (Cell(0, 0, 0), Cell(2, 0, 1), Cell(5, 0, 1))
    assert order.mid_air == (Cell(2, 0, 1), Cell(5, 0, 1))
    with pytest.raises(PlanError, match=r"rule of connectivity.*\[2, 0, 1\], \[5, 0, 1\]"):
        plan_paper_cells(apart, LIMITS, 40)


def test_an_order_needs_no_ground_to_end() -> None:
    floating = frozenset({Cell(0, 0, 1), Cell(1, 0, 1), Cell(3, 0, 1)})
    order = connectivity_order(floating)
    assert order.cells == (Cell(0, 0, 1), Cell(1, 0, 1), Cell(3, 0, 1))
    assert order.mid_air == order.cells


def test_a_part_that_would_go_beneath_another_is_refused() -> None:
    hook = cells_of(Box(0, 0, 0, 1, 1, 3), Box(1, 0, 2, 2, 1, 1)) | {Cell(2, 0, 1)}
    with pytest.raises(PlanError, match=r"rule of access.*\[2, 0, 1\]"):
        plan_paper_cells(hook, LIMITS, 40)


def test_two_towers_that_both_stand_are_connected_to_the_ground() -> None:
    plan = plan_paper(shape(Box(0, 0, 0, 1, 1, 3), Box(3, 0, 0, 1, 1, 3)), LIMITS, 40)
    assert len(plan.order) == 6


@pytest.mark.parametrize(
    ("cells", "rule"),
    [
        (cells_of(Box(0, 0, 0, 4, 4, 3)), "count"),
        (cells_of(Box(0, 0, 0, 1, 1, 2), Box(1, 0, 1, 4, 1, 1)), "overhang"),
        (cells_of(Box(0, 0, 0, 1, 1, 5)), "stack"),
    ],
)
def test_cells_are_not_rescaled_but_refused(cells: frozenset[Cell], rule: str) -> None:
    with pytest.raises(PlanError, match=f"rule of {rule}"):
        plan_paper_cells(cells, LIMITS, 40)


def test_cells_go_to_the_corner_and_must_be_there() -> None:
    plan = plan_paper_cells([Cell(3, 2, 4), Cell(3, 2, 5)], LIMITS, 40)
    assert plan.order == (Cell(0, 0, 0), Cell(0, 0, 1))
    with pytest.raises(PlanError, match="no cells"):
        plan_paper_cells([], LIMITS, 40)
    with pytest.raises(PlanError, match="no parts"):
        plan_paper(SHAPES["table"], LIMITS, 0)


def test_a_module_that_is_left_out_does_nothing() -> None:
    without_count = process(SHAPES["shelf"], LIMITS, 40, frozenset(Module) - {Module.COUNT})
    assert len(without_count.cells) == 54
    only = process(SHAPES["table"], LIMITS, 40, frozenset({Module.COUNT}))
    assert only.cells == BASELINES["table"].cells


def test_a_volume_is_that_of_the_solid() -> None:
    block = shape(Box(0, 0, 0, 2, 3, 4))
    assert volume(block.surface) == pytest.approx(24.0)
    stool = next(one for one in OBJECTS if one.name == "stool")
    # The seat, two legs that taper, and one that leans.
    taper = 4.8 * 0.8 * (0.5 + 0.2) / 2
    assert volume(stool.surface) == pytest.approx(5.0 + 2 * taper + 4.8 * 0.4 * 0.6)
