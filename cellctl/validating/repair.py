"""Make a shape buildable by rescaling it, after the paper's algorithms 2 and 3.

Too many parts, and every axis loses one cell; too long an overhang, and its axis does; too high a
free-standing column, and the height does. The shape, not its cells, is rescaled, and voxelised
anew, so that it keeps its form. Every step takes a cell's length off some axis that is longer than
one cell, so this ends, and no axis falls below one cell (or below what it was).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cellctl.assembly import Cell, Change
from cellctl.config import LimitsSection
from cellctl.errors import PlanError
from cellctl.validating.discretise import Floats, discretise
from cellctl.validating.fit import Shape
from cellctl.validating.rules import (
    Cells,
    check_all,
    hanging,
    overhang_reach,
    overhang_walk,
    pieces,
    unsupported_stacks,
)

_CRUMBS = 0.1
"""The most that may be left out because nothing carries it, as a part of all cells."""

_LEAST_CELLS = 2.0
"""A shape whose longest side was larger and would become smaller than this no longer shows what
it is."""

_WHY = {
    "count": "It would take {found} parts, and there are {allowed}.",
    "overhang": "It would hang out by {found} parts, and {allowed} hold.",
    "stack": "A column would stand alone {found} parts high, and {allowed} stand.",
    "connectivity": "It would fall into {found} pieces.",
    "grounded": "Nothing of it would stand on the floor.",
    "access": "{found} parts would have to hang from parts above them, and cannot be placed there.",
}


@dataclass(frozen=True)
class Repaired:
    """Cells that satisfy every rule, from [0, 0, 0], and what it took."""

    cells: Cells
    changes: tuple[Change, ...]


def repair(shape: Shape, limits: LimitsSection, parts: int) -> Repaired:
    """Voxelise a shape, and rescale it until its cells satisfy every rule.

    Args:
        shape: measured in cells, within the grid.
        limits: of overhang and stack.
        parts: how many parts there are.

    Raises:
        PlanError: it cannot be made to fit the rules, and why.
    """
    if parts < 1:
        raise PlanError("There are no parts to build with.", "Put parts on the belt.")
    first = shape.extent
    rescaled: dict[str, tuple[tuple[int, int, int], tuple[int, int, int]]] = {}
    why: dict[str, str] = {}
    pending: tuple[str, tuple[int, int, int]] | None = None
    while True:
        whole = discretise(shape)
        cells = _without_crumbs(whole)
        if pending is not None:
            rule, before = pending
            rescaled[rule] = (rescaled.get(rule, (before, before))[0], size_of(cells))
        failed = next((c for c in check_all(cells, limits, parts) if not c.passed), None)
        if failed is None:
            break
        pending = (failed.name, size_of(cells))
        why.setdefault(failed.name, _why(failed.name, cells, limits, parts))
        smaller = _smaller(shape.extent, first, failed.name, cells, limits)
        if smaller is None:
            places = ", ".join(str(list(cell)) for cell in failed.cells[:6])
            more = f" and {len(failed.cells) - 6} more" if len(failed.cells) > 6 else ""
            raise PlanError(
                f"This shape cannot be built here. {_why(failed.name, cells, limits, parts)} "
                f"Cells: {places}{more}.",
                "Ask for another shape, or a simpler one.",
            )
        shape = shape.rescaled(smaller)
    changes = [
        Change(
            what=f"It is {_times(after)} parts large instead of {_times(before)} "
            "(wide, deep, high).",
            why=why[rule],
        )
        for rule, (before, after) in rescaled.items()
    ]
    if left_out := len(whole) - len(cells):
        changes.append(
            Change(
                what=f"{left_out} {'part is' if left_out == 1 else 'parts are'} left out.",
                why="Nothing would carry them when their turn comes.",
            )
        )
    return Repaired(cells, tuple(changes))


def size_of(cells: Cells) -> tuple[int, int, int]:
    """Extent in cells along x, y and z."""
    spans = [max(axis) - min(axis) + 1 for axis in zip(*cells, strict=True)]
    return (spans[0], spans[1], spans[2])


def _why(rule: str, cells: Cells, limits: LimitsSection, parts: int) -> str:
    """Why cells fail a rule, in words for the visitor."""
    found, allowed = 0, 0
    if rule == "count":
        found, allowed = len(cells), parts
    elif rule == "overhang":
        allowed = limits.overhang_cells
        found = max(overhang_walk(cells, allowed).length, overhang_reach(cells, allowed).length)
    elif rule == "stack":
        allowed = limits.stack_cells
        found, _ = unsupported_stacks(cells, allowed)
    elif rule == "connectivity":
        found = len(pieces(cells))
    elif rule == "access":
        found = len(hanging(cells))
    return _WHY[rule].format(found=found, allowed=allowed)


def _smaller(
    extent: Floats, first: Floats, rule: str, cells: Cells, limits: LimitsSection
) -> Floats | None:
    """The extents after one step of rescaling for a failed rule; None when too little is left."""
    if rule in ("connectivity", "grounded"):
        # Pieces that lie apart would only grow together; that is another object.
        return None
    smaller = extent.copy()
    for axis in _axes(rule, cells, limits):
        smaller[axis] = max(extent[axis] - 1.0, min(extent[axis], 1.0))
    # Rescaling cures what hangs only by luck; half the size is where that ends.
    least = max(_LEAST_CELLS, first.max() / 2 if rule == "access" else 0.0)
    if np.array_equal(smaller, extent) or smaller.max() < min(least, first.max()) - 1e-9:
        return None
    return smaller


def _axes(rule: str, cells: Cells, limits: LimitsSection) -> tuple[int, ...]:
    """Which axes a rule takes a cell from."""
    if rule == "stack":
        return (2,)
    if rule == "overhang":
        walk = overhang_walk(cells, limits.overhang_cells)
        reach = overhang_reach(cells, limits.overhang_cells)
        return (max(walk, reach, key=lambda overhang: overhang.length).axis,)
    return (0, 1, 2)


def _without_crumbs(cells: Cells) -> Cells:
    """The same without the few cells that nothing would carry; all of them if they are many."""
    allowance = int(len(cells) * _CRUMBS)
    kept = cells
    while True:
        loose = frozenset[Cell]().union(*pieces(kept)[1:]) | hanging(kept)
        if not loose:
            return _to_corner(kept)
        kept -= loose
        if len(cells) - len(kept) > allowance or not kept:
            return cells


def _to_corner(cells: Cells) -> Cells:
    low = [min(axis) for axis in zip(*cells, strict=True)]
    return frozenset(Cell(c.x - low[0], c.y - low[1], c.z - low[2]) for c in cells)


def _times(size: tuple[int, int, int]) -> str:
    return " x ".join(str(edge) for edge in size)
