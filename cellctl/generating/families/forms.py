"""Shapes that are drawn rather than calculated: a front view, or a floor plan for each layer."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cellctl.generating.boxes import Box


def runs(row: str) -> list[tuple[int, int]]:
    """Start and length of each run of cells in a row of ``#`` and ``.``."""
    starts = [x for x, cell in enumerate(row) if cell == "#" and (x == 0 or row[x - 1] != "#")]
    return [(x, len(row[x:]) - len(row[x:].lstrip("#"))) for x in starts]


def standing(
    rows: Sequence[str], depth: int = 1, *, x: int = 0, y: int = 0, z: int = 0
) -> tuple[Box, ...]:
    """A front view, its top row first, of one thickness."""
    top = len(rows) - 1
    return tuple(
        Box(x + start, y, z + top - index, length, depth, 1)
        for index, row in enumerate(rows)
        for start, length in runs(row)
    )


def lying(rows: Sequence[str], z: int, height: int = 1) -> tuple[Box, ...]:
    """A floor plan, its rear row first, of one height."""
    rear = len(rows) - 1
    return tuple(
        Box(start, rear - index, z, length, 1, height)
        for index, row in enumerate(rows)
        for start, length in runs(row)
    )


def stacked(plans: Iterable[Sequence[str]]) -> tuple[Box, ...]:
    """Floor plans, one for each layer, the lowest first."""
    return tuple(box for z, plan in enumerate(plans) for box in lying(plan, z))


def at_height(rows: Sequence[str], height: int) -> tuple[str, ...]:
    """The same front view taller or lower by whole rows of its thinnest strokes, as far as that
    goes.

    A repeated row rests on its twin, and one of two twins can go: neither parts the figure.
    """
    drawn = list(rows)
    while len(drawn) < height:
        thinnest = min(range(len(drawn)), key=lambda i: (drawn[i].count("#"), -i))
        drawn.insert(thinnest, drawn[thinnest])
    while len(drawn) > height:
        twins = [i for i in range(1, len(drawn)) if drawn[i] == drawn[i - 1]]
        if not twins:
            break
        del drawn[twins[0]]
    return tuple(drawn)


def ring(  # noqa: PLR0917 - a box by its corner and extent
    x: int, y: int, z: int, width: int, depth: int, height: int
) -> tuple[Box, ...]:
    """Four walls, one cell thick, about a hollow."""
    walls = [Box(x, y, z, 1, depth, height)]
    if width > 1:
        walls.append(Box(x + width - 1, y, z, 1, depth, height))
    if width > 2:
        walls.append(Box(x + 1, y, z, width - 2, 1, height))
        if depth > 1:
            walls.append(Box(x + 1, y + depth - 1, z, width - 2, 1, height))
    return tuple(walls)


def without(boxes: Iterable[Box], gone: Iterable[tuple[int, int, int]]) -> tuple[Box, ...]:
    """Boxes of whole cells with some cells taken away, as single cells."""
    holes = set(gone)
    return tuple(Box(*cell, 1, 1, 1) for cell in cells_of(boxes) if cell not in holes)


def cells_of(boxes: Iterable[Box]) -> list[tuple[int, int, int]]:
    """The cells that boxes of whole cells occupy, each once, sorted."""
    return sorted(
        {
            (x, y, z)
            for box in boxes
            for x in range(int(box.x), int(box.x + box.width))
            for y in range(int(box.y), int(box.y + box.depth))
            for z in range(int(box.z), int(box.z + box.height))
        }
    )
