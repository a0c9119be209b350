"""Structures for the tests of removal: the paper's kind of furniture, and random ones that can be
built part by part."""

from __future__ import annotations

import random
from functools import cache
from typing import Any

import pytest

from cellctl.assembly import Cell
from cellctl.validating.access import Gripper
from cellctl.validating.rules import Cells, lateral, supported
from cellctl.validating.stability import Physics, assess
from tests.validating.shapes import CONFIG

PHYSICS = Physics.of(CONFIG)
GRIPPER = Gripper.of(CONFIG)
GRID = CONFIG.grid


def shelf(width: int, height: int, *tiers: int) -> Cells:
    """Two side panels two deep, and tiers at these heights."""
    return frozenset(
        Cell(x, y, z)
        for x in range(width)
        for y in range(2)
        for z in range(height)
        if x in (0, width - 1) or z in tiers
    )


def table(width: int, depth: int, height: int) -> Cells:
    """A top on four legs at its corners."""
    return frozenset(
        Cell(x, y, z)
        for x in range(width)
        for y in range(depth)
        for z in range(height)
        if z == height - 1 or (x in (0, width - 1) and y in (0, depth - 1))
    )


def column(height: int) -> Cells:
    return frozenset(Cell(0, 0, z) for z in range(height))


def seeds(few: int, many: int) -> list[Any]:
    """Seeds of a test that is repeated: few each time, the rest among the long proofs."""
    return [
        *range(few),
        *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(few, many)),
    ]


@cache
def buildable(seed: int, parts: int) -> Cells:
    """A random structure that grew part by part, each state standing."""
    dice = random.Random(seed)  # noqa: S311 - reproducible shapes, not secrets
    cells: set[Cell] = {Cell(dice.randrange(GRID[0]), dice.randrange(GRID[1]), 0)}
    for _ in range(20 * parts):
        if len(cells) >= parts:
            break
        beside = dice.choice(dice.choice(sorted(cells)).neighbours())
        if beside in cells or not _within(beside) or GRIPPER.blockers(beside, cells):
            continue
        grown = frozenset(cells | {beside})
        held = supported(beside, grown) or any(b in cells for b in lateral(beside))
        if held and assess(grown, PHYSICS, beside).margin >= PHYSICS.least_margin:
            cells.add(beside)
    return frozenset(cells)


def _within(cell: Cell) -> bool:
    return all(0 <= index < count for index, count in zip(cell, GRID, strict=True))
