"""Algorithm 4: Connectivity-Aware Assembly Sequence Generation, and the order without it.

The printed loop removes from the list that it walks, so that an implementation may or may not skip
what follows a removed element. Here each pass walks the list as it was when the pass began, and a
part that was placed earlier in the same pass counts as placed.

Where a pass places nothing, the algorithm puts the nearest part into the air, and where nothing is
placed at all, nothing is near: it is undefined. Here the first in the sorted order is taken then.
Either way ``Order.mid_air`` names such parts, so that whoever would build it can refuse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells


@dataclass(frozen=True)
class Order:
    """All cells, in the order in which they are placed."""

    cells: tuple[Cell, ...]

    @cached_property
    def mid_air(self) -> tuple[Cell, ...]:
        """Cells that no chain of parts joins to the floor when they are placed."""
        grounded: set[Cell] = set()
        floating: set[Cell] = set()
        found = []
        for cell in self.cells:
            if not _held(cell, grounded):
                floating.add(cell)
                found.append(cell)
                continue
            # It may join what floated so far to the floor.
            front = [cell]
            while front:
                joined = front.pop()
                grounded.add(joined)
                floating.discard(joined)
                front += [beside for beside in joined.neighbours() if beside in floating]
        return tuple(found)

    @cached_property
    def beneath(self) -> tuple[Cell, ...]:
        """Cells that are placed under a part that already stands in their column."""
        tops: dict[tuple[int, int], int] = {}
        found = []
        for cell in self.cells:
            column = (cell.x, cell.y)
            if tops.get(column, -1) > cell.z:
                found.append(cell)
            tops[column] = max(cell.z, tops.get(column, -1))
        return tuple(found)


def naive_order(cells: Cells) -> Order:
    """The simple sorting of section 3.3.3: by z, then x, then y."""
    return Order(tuple(_sorted(cells)))


def connectivity_order(cells: Cells) -> Order:
    """Algorithm 4: what is grounded or touches a placed part, pass after pass.

    It ends: every pass places at least one part.
    """
    waiting = _sorted(cells)
    placed: set[Cell] = set()
    order: list[Cell] = []
    while waiting:
        left = []
        for cell in waiting:
            if _held(cell, placed):
                placed.add(cell)
                order.append(cell)
            else:
                left.append(cell)
        if len(left) == len(waiting):
            # min() keeps the first of equals, so ties go by the sorted order.
            nearest = min(left, key=lambda cell: _distance_squared(cell, order))
            left.remove(nearest)
            placed.add(nearest)
            order.append(nearest)
        waiting = left
    return Order(tuple(order))


def _sorted(cells: Cells) -> list[Cell]:
    return sorted(cells, key=lambda c: (c.z, c.x, c.y))


def _held(cell: Cell, placed: set[Cell]) -> bool:
    return cell.z == 0 or any(beside in placed for beside in cell.neighbours())


def _distance_squared(cell: Cell, placed: Sequence[Cell]) -> int:
    """To the nearest placed part, centre to centre, in cells; 0 where none is placed."""
    return min(
        (sum((a - b) ** 2 for a, b in zip(cell, other, strict=True)) for other in placed),
        default=0,
    )
