"""The rules reproduce the paper's measures, and see what it missed."""

from __future__ import annotations

from pathlib import Path

import pytest

from cellctl.assembly import Cell
from cellctl.generating.boxes import Box
from cellctl.validating.discretise import discretise
from cellctl.validating.paper.policy import process
from cellctl.validating.paper.steadying import longest_overhang
from cellctl.validating.rules import (
    check_access,
    check_connectivity,
    check_grounded,
    check_stack,
    size_of,
    unsupported_stacks,
)
from tests.validating.shapes import CONFIG, cells_of, paper, shape

LIMITS = CONFIG.limits


@pytest.mark.parametrize("name", ["stool", "shelf", "letter_t", "table"])
def test_the_papers_objects_measure_as_the_paper_says(test_data: Path, name: str) -> None:
    cells, computed = paper(test_data, name)
    assert len(cells) == computed["count"]
    assert longest_overhang(cells) == computed["overhang_walk"]
    assert unsupported_stacks(cells, 4)[0] == computed["unsupported_stack"]


SHELF = (
    Box(0, 0, 0, 1, 3, 6),
    Box(5, 0, 0, 1, 3, 6),
    Box(0, 0, 2.5, 6, 3, 0.5),
    Box(0, 0, 5.5, 6, 3, 0.5),
)
LETTER_T = (Box(0, 0, 5, 3, 1, 1), Box(1, 0, 0, 1, 1, 5))
TABLE = (Box(0, 0, 5, 4, 4, 1), Box(1, 1, 0, 1, 1, 5))


@pytest.mark.parametrize(
    ("boxes", "parts", "before", "after"),
    [
        (SHELF, 40, 60, 32),  # count
        (SHELF, 60, 60, 54),  # overhang
        (LETTER_T, 40, 8, 7),  # stack
        (TABLE, 40, 21, 20),  # stack
    ],
)
def test_the_papers_rescaling(boxes: tuple[Box, ...], parts: int, before: int, after: int) -> None:
    assert len(discretise(shape(*boxes))) == before
    repaired = process(shape(*boxes), LIMITS, parts)
    assert len(repaired.cells) == after
    assert len(repaired.changes) == 1


def test_only_the_overhanging_axis_is_rescaled() -> None:
    assert size_of(process(shape(*SHELF), LIMITS, 60).cells) == (5, 3, 6)


def test_a_column_of_four_stands_and_of_five_does_not_unless_something_is_beside_it() -> None:
    assert check_stack(cells_of(Box(0, 0, 0, 1, 1, 4)), 4).passed
    tall = cells_of(Box(0, 0, 0, 1, 1, 5))
    assert check_stack(tall, 4).cells == tuple(sorted(tall))
    assert check_stack(tall | {Cell(1, 0, 2)}, 4).passed


def test_pieces_that_share_only_an_edge_do_not_hang_together() -> None:
    failed = check_connectivity(frozenset({Cell(0, 0, 0), Cell(0, 0, 1), Cell(1, 0, 2)}))
    assert not failed.passed
    assert failed.cells == (Cell(1, 0, 2),)


def test_what_hangs_from_above_cannot_be_placed() -> None:
    hook = frozenset({Cell(0, 0, z) for z in range(3)} | {Cell(1, 0, 2), Cell(2, 0, 2)})
    assert check_access(hook).passed
    failed = check_access(hook | {Cell(2, 0, 1)})
    assert failed.cells == (Cell(2, 0, 1),)


def test_an_object_in_the_air_is_not_grounded() -> None:
    assert not check_grounded(frozenset({Cell(0, 0, 1)})).passed
    assert check_grounded(frozenset({Cell(0, 0, 0)})).passed
