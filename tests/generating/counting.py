"""Counts what can be seen of an object in its cells; knows nothing of how it was designed."""

from __future__ import annotations

from itertools import pairwise

from cellctl.assembly import Cell
from cellctl.validating.rules import pieces, size_of

Cells = frozenset[Cell]


def from_front(cells: Cells) -> Cells:
    """As a visitor sees them: the robot stands behind, so designs are turned to the front."""
    width, depth, _ = size_of(cells)
    return frozenset(Cell(width - 1 - x, depth - 1 - y, z) for x, y, z in cells)


def at_origin(cells: Cells) -> Cells:
    """The same cells with their minimum corner at [0, 0, 0]."""
    x0, y0, z0 = (min(axis) for axis in zip(*cells, strict=True))
    return frozenset(Cell(x - x0, y - y0, z - z0) for x, y, z in cells)


def layer(cells: Cells, z: int) -> Cells:
    """What is at one height."""
    return frozenset(cell for cell in cells if cell.z == z)


def feet(cells: Cells) -> int:
    """How many separate things touch the floor."""
    return len(pieces(layer(cells, 0)))


def tiers(cells: Cells) -> int:
    """How many layers reach from side to side."""
    width, depth, height = size_of(cells)
    return sum(len(layer(cells, z)) == width * depth for z in range(height))


def square_tiers(cells: Cells) -> int:
    """How many layers are smaller than the one below, the lowest included."""
    sizes = [len(layer(cells, z)) for z in range(size_of(cells)[2])]
    return 1 + sum(above < below for below, above in pairwise(sizes))


def treads(cells: Cells) -> int:
    """How many different heights one can stand on, seen from above."""
    tops: dict[tuple[int, int], int] = {}
    for x, y, z in cells:
        tops[x, y] = max(z, tops.get((x, y), 0))
    return len(set(tops.values()))


def rungs(cells: Cells) -> int:
    """How many layers have something between the outermost columns."""
    width, _, height = size_of(cells)
    return sum(any(0 < cell.x < width - 1 for cell in layer(cells, z)) for z in range(height))


def fronts(cells: Cells) -> int:
    """How many separate things stand out at the very front, such as drawers or their handles."""
    front = min(cell.y for cell in cells)
    return len(pieces(cell for cell in cells if cell.y == front))


def openings(cells: Cells) -> int:
    """How many gaps there are between what touches the floor, along x."""
    columns = sorted({cell.x for cell in layer(cells, 0)})
    return sum(b - a > 1 for a, b in pairwise(columns))


def back_of(cells: Cells) -> int:
    """The height of an animal's back: that of the uppermost of its fullest layers."""
    return max(range(size_of(cells)[2]), key=lambda z: (len(layer(cells, z)), z))


def neck(cells: Cells) -> int:
    """How many parts are between an animal's back and its head, which is its uppermost layer."""
    return size_of(cells)[2] - 2 - back_of(cells)


def tail(cells: Cells) -> int:
    """How many parts of an animal stand up at its rear or reach beyond it, one behind another."""
    right = max(cell.x for cell in cells)
    above = range(back_of(cells) + 1, size_of(cells)[2])
    if up := sum(sum(cell.x == right for cell in layer(cells, z)) == 1 for z in above):
        return up
    columns = [sum(cell.x == x for cell in cells) for x in range(right, -1, -1)]
    return next(k for k, number in enumerate(columns) if number > 1)


def eaves(cells: Cells) -> int:
    """How many layers are as wide as the whole."""
    width = size_of(cells)[0]
    return sum(len({cell.x for cell in layer(cells, z)}) == width for z in range(size_of(cells)[2]))


def rows(cells: Cells) -> tuple[str, ...]:
    """The front view, its top row first."""
    width, _, height = size_of(cells)
    seen = {(cell.x, cell.z) for cell in cells}
    return tuple(
        "".join("#" if (x, z) in seen else "." for x in range(width))
        for z in reversed(range(height))
    )
