"""Drafts: what is asked of an order, and where an object is moved with all that is known of it."""

from __future__ import annotations

import pytest

from cellctl.assembly import Cell
from cellctl.errors import PlanError
from cellctl.generating.boxes import Box
from cellctl.validating.access import Gripper
from cellctl.validating.draft import check_order, draft, redraft
from cellctl.validating.stability import Physics, assess_order
from tests.validating.shapes import CONFIG, cells_of

PHYSICS, GRIPPER = Physics.of(CONFIG), Gripper.of(CONFIG)


def test_a_part_between_two_others_is_counted() -> None:
    row = (Cell(0, 0, 0), Cell(2, 0, 0), Cell(1, 0, 0))
    assert "1 goes between two others" in check_order(row).message


def test_a_part_beneath_or_adrift_fails_the_order_check() -> None:
    assert check_order((Cell(0, 0, 0), Cell(1, 0, 1))).cells == (Cell(1, 0, 1),)
    beneath = (Cell(0, 0, 0), Cell(0, 0, 1), Cell(1, 0, 1), Cell(1, 0, 0))
    assert check_order(beneath).cells == (Cell(1, 0, 0),)


def test_a_moved_draft_says_of_each_cell_what_it_said_before() -> None:
    found = draft(cells_of(Box(0, 0, 0, 1, 1, 2), Box(0, 0, 2, 3, 1, 1)), PHYSICS, GRIPPER, 40)
    moved = found.moved(2, 1)
    assert moved.cells == {Cell(x + 2, y + 1, z) for x, y, z in found.cells}
    assert [v.margin for v in moved.verdicts] == [v.margin for v in found.verdicts]
    assert found.weakest is not None
    assert moved.weakest is not None
    x, y, z = found.weakest.cell
    assert moved.weakest.cell == Cell(x + 2, y + 1, z)
    assert str(list(moved.weakest.cell)) in moved.weakest.description
    assert redraft(moved.order, PHYSICS, GRIPPER, 40).checks == found.checks


def test_what_fails_is_named_with_its_rule_and_cells() -> None:
    apart = cells_of(Box(0, 0, 0, 1, 1, 1), Box(2, 0, 0, 1, 1, 1))
    with pytest.raises(PlanError, match="falls into 2 pieces") as refused:
        draft(apart, PHYSICS, GRIPPER, 40)
    assert refused.value.rule == "connectivity"
    assert refused.value.cells == (Cell(2, 0, 0),)
    with pytest.raises(PlanError, match="cannot come down past") as refused:
        redraft((Cell(0, 0, 0), Cell(0, 0, 1), Cell(0, 0, 2), Cell(1, 0, 0)), PHYSICS, GRIPPER, 40)
    assert refused.value.rule == "access"


def test_a_large_object_is_sketched_and_proven_at_every_step() -> None:
    walls = cells_of(*(Box(x, 0, 0, 1, 4, 8) for x in (0, 4, 8)))
    shelf = walls | cells_of(*(Box(0, 0, z, 9, 4, 1) for z in (1, 3, 5, 7)))
    found = draft(shelf, PHYSICS, GRIPPER, 1000)
    assert len(found.order) == len(shelf) == 192
    assert found.verdicts == assess_order(found.order, PHYSICS)
    assert min(verdict.margin for verdict in found.verdicts) >= PHYSICS.least_margin
