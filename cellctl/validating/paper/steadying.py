"""Algorithm 3: Overhang Check with Dynamic Rescaling, and the vertical stacks in its second half.

Where the printed code cannot be followed to the letter:

- Its loops run over coordinates from before the rescaling inside them, and then speak of cells that
  are no longer there. Here each pass measures the whole assembly anew and rescales for the worst
  of it.
- *The number of unsupported cantilever components* is not defined. The measure that gives every
  figure of table 3: a walk from a supported cell along +-x or +-y over unsupported cells, until a
  supported cell or a gap. It enters no row that has no supported cell at all; ``unseen`` says
  which cells these are.
- *No lateral support at (x+-1, y+-1, z)* read literally means the four diagonals, and the shelf
  would fail table 4. The text's lateral support is a neighbour at a side.
- ``Geometry`` inside the loops is the ``AssemblyGeometry`` of the line before.
"""

from __future__ import annotations

from typing import NamedTuple

from cellctl.assembly import Cell
from cellctl.validating.paper.scaling import Rescaled, occupy, one_cell_smaller, resized
from cellctl.validating.rules import Cells, supported, unsupported_stacks

_X, _Y, _Z = 0, 1, 2
_DIRECTIONS = ((_X, 1, 0), (_X, -1, 0), (_Y, 0, 1), (_Y, 0, -1))


class Cantilever(NamedTuple):
    """Unsupported cells in a straight row that begins at a supported one."""

    axis: int
    """0 for x, 1 for y."""
    cells: tuple[Cell, ...]
    """From the supported end outwards."""


def cantilevers(cells: Cells) -> tuple[Cantilever, ...]:
    """Every one of at least one cell, the longest first; along x before y, then by place."""
    found = []
    for cell in sorted(cells):
        if not supported(cell, cells):
            continue
        for axis, dx, dy in _DIRECTIONS:
            row: list[Cell] = []
            step = Cell(cell.x + dx, cell.y + dy, cell.z)
            while step in cells and not supported(step, cells):
                row.append(step)
                step = Cell(step.x + dx, step.y + dy, step.z)
            if row:
                found.append(Cantilever(axis, tuple(row)))
    return tuple(sorted(found, key=lambda one: (-len(one.cells), one.axis, one.cells)))


def longest_overhang(cells: Cells) -> int:
    """Length of the longest cantilever, in cells."""
    return max((len(one.cells) for one in cantilevers(cells)), default=0)


def unseen(cells: Cells) -> Cells:
    """Unsupported cells whose rows hold no supported cell: the measure knows nothing of them."""
    seen = {cell for one in cantilevers(cells) for cell in one.cells}
    return frozenset(cell for cell in cells if not supported(cell, cells) and cell not in seen)


def within_overhang(found: Rescaled, most_cells: int) -> Rescaled:
    """Shorten the axis of the longest cantilever until none is longer than ``most_cells``.

    It ends: a cantilever of one cell or more needs an axis of two, which then loses one.
    """
    smaller = found
    while rows := [one for one in cantilevers(smaller.cells) if len(one.cells) > most_cells]:
        smaller = occupy(one_cell_smaller(smaller.shape, (rows[0].axis,)))
    if smaller is found:
        return found
    why = f"It would hang out by {longest_overhang(found.cells)} parts, and {most_cells} hold."
    return resized(found.cells, Rescaled(smaller.shape, smaller.cells, found.changes), why)


def within_stack(found: Rescaled, most_cells: int) -> Rescaled:
    """Shorten the height until no free-standing column is higher than ``most_cells`` (at least 1).

    It ends: a column of two cells needs a height of two, which then loses one.
    """
    smaller = found
    while unsupported_stacks(smaller.cells, most_cells)[0] > most_cells:
        smaller = occupy(one_cell_smaller(smaller.shape, (_Z,)))
    if smaller is found:
        return found
    height = unsupported_stacks(found.cells, most_cells)[0]
    why = f"A column would stand alone {height} parts high, and {most_cells} stand."
    return resized(found.cells, Rescaled(smaller.shape, smaller.cells, found.changes), why)
