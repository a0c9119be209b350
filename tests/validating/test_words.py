"""What checks and refusals say: numbers that agree with their verbs, cells, and what to do."""

from __future__ import annotations

import pytest

from cellctl.assembly import Cell
from cellctl.errors import PlanError
from cellctl.validating.changing.moves import Belt, Judge, find_moves
from cellctl.validating.changing.plans import plan_removal
from cellctl.validating.draft import check_order, paper_redraft, redraft
from cellctl.validating.paper.policy import plan_paper_cells
from cellctl.validating.rules import (
    check_access,
    check_count,
    check_grounded,
    check_stack,
)
from cellctl.validating.words import count, counted, listed, named, parts, times
from tests.validating.shapes import CONFIG
from tests.validating.structures import GRIPPER, PHYSICS, column

ONE = frozenset({Cell(0, 0, 0)})


def cells(*each: tuple[int, int, int]) -> tuple[Cell, ...]:
    return tuple(Cell(*one) for one in each)


HANGER = cells((0, 0, 0), (0, 0, 1), (0, 0, 2), (1, 0, 2), (2, 0, 2), (2, 0, 1))
"""A column with an arm, and a part that hangs beneath the arm."""


def test_numbers_agree() -> None:
    assert [count(n, "step") for n in (0, 1, 2)] == ["0 steps", "1 step", "2 steps"]
    assert [parts(n) for n in (1, 2)] == ["1 part", "2 parts"]
    assert [parts(n, "stands", "stand") for n in (1, 2)] == ["1 part stands", "2 parts stand"]
    assert [counted(n, "lies", "lie") for n in (0, 1)] == ["0 lie", "1 lies"]


def test_cells_are_named_up_to_six() -> None:
    row = cells(*((x, 0, 0) for x in range(8)))
    assert named(row[:2]) == "[0, 0, 0], [1, 0, 0]"
    assert named(row[:6]).endswith("[5, 0, 0]")
    assert named(row).endswith("[5, 0, 0] and 2 more")


def test_sizes_and_lists() -> None:
    assert times((3, 1, 5)) == "3 x 1 x 5"
    assert [listed("abc"[:n]) for n in (1, 2, 3)] == ["a", "a and b", "a, b and c"]


def test_checks_of_one_part_are_in_the_singular() -> None:
    said = [
        check_count(ONE, 1).message,
        check_grounded(ONE).message,
        check_stack(ONE, 4).message,
        check_access(frozenset(HANGER)).message,
        check_order([Cell(0, 0, 0), Cell(3, 0, 3)]).message,
        *(check.message for check in plan_paper_cells(ONE, CONFIG.limits, 1).checks),
    ]
    assert said[:3] == [
        "1 part; 1 is there.",
        "1 part stands on the floor.",
        "The highest column without a neighbour is 1 part high; the limit is 4.",
    ]
    assert said[3] == "1 part would have to hang from what is above."
    assert said[4] == "1 part would float, or go beneath another."
    assert not [message for message in said if "1 parts" in message]


def test_where_no_column_stands_alone_none_is_measured() -> None:
    beside = frozenset({Cell(0, 0, 0), Cell(1, 0, 0)})
    assert check_stack(beside, 4).message == "No column is without a neighbour."


def test_only_ways_that_occur_are_told() -> None:
    told = plan_removal(column(1), CONFIG).checks[-1].message
    assert told.startswith("1 part is p")
    assert " and " not in told
    assert "0 " not in told.split(";")[0]


def test_a_full_belt_is_told_of_one_part() -> None:
    with pytest.raises(PlanError, match="1 part has to come off"):
        find_moves(ONE, ONE, frozenset(), Judge(PHYSICS, GRIPPER), Belt(4, 4))


@pytest.mark.parametrize(
    ("order", "rule", "advice"),
    [
        (cells(*((0, 0, z) for z in range(41))), "count", "Make it smaller"),
        (cells((0, 0, 0), (2, 0, 0)), "connectivity", "Join the pieces"),
        (cells((0, 0, 1), (1, 0, 1)), "grounded", "Move it down"),
        (HANGER, "access", "Set something"),
        (cells((0, 0, 1), (0, 0, 0)), "order", "Plan it anew"),
        (cells(*((0, 0, z) for z in range(8))), "stability", "Support these cells"),
    ],
)
def test_every_refusal_says_what_to_do(order: tuple[Cell, ...], rule: str, advice: str) -> None:
    with pytest.raises(PlanError) as refused:
        redraft(order, PHYSICS, GRIPPER, 40)
    assert refused.value.rule == rule
    assert refused.value.hint.startswith(advice)


@pytest.mark.parametrize(
    ("order", "rule", "advice"),
    [
        (cells((0, 0, 0), (0, 0, 1), *((x, 0, 1) for x in range(1, 6))), "overhang", "Let these"),
        (cells(*((0, 0, z) for z in range(8))), "stack", "Give this column"),
        (cells((0, 0, 1), (0, 0, 0)), "connectivity", "Plan it anew"),
    ],
)
def test_so_does_every_refusal_by_the_papers_rules(
    order: tuple[Cell, ...], rule: str, advice: str
) -> None:
    with pytest.raises(PlanError) as refused:
        paper_redraft(order, PHYSICS, CONFIG.limits, 40)
    assert refused.value.rule == rule
    assert refused.value.hint.startswith(advice)
