"""Which of several moves is tried first. It decides how soon an order is found, not whether it
is right."""

from __future__ import annotations

from collections.abc import Callable

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells, lateral, steps_from, supported

Cost = tuple[int, ...]

_FAR = 1_000
"""Reach of a part that no part of its layer carries."""


def removal_cost(cells: Cells) -> Callable[[Cell], Cost]:
    """From above downward; in a layer what hangs out farthest, and has fewest neighbours."""
    reach = reaches(cells)

    def cost(cell: Cell) -> Cost:
        beside = sum(neighbour in cells for neighbour in lateral(cell))
        return (-cell.z, -reach.get(cell, _FAR), beside, cell.x, cell.y)

    return cost


def placing_cost(cells: Cells, goal: Cells) -> Callable[[Cell], Cost]:
    """From below upward; in a layer what is carried before what hangs out, and rather not between
    two parts that stand.

    Args:
        cells: what stands.
        goal: what shall stand.
    """
    reach = reaches(goal)

    def cost(cell: Cell) -> Cost:
        east, west, north, south = (neighbour in cells for neighbour in lateral(cell))
        slots = int(east and west) + int(north and south)
        beside = sum((east, west, north, south))
        return (cell.z, reach.get(cell, _FAR), slots, -beside, cell.x, cell.y)

    return cost


def reaches(cells: Cells) -> dict[Cell, int]:
    """How many joints each cell is from one of its layer that rests on something, so that a corner
    is farther out than its neighbours; cells that nothing carries are left out."""
    return steps_from(cells, {cell for cell in cells if supported(cell, cells)})
