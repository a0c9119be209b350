"""Which cells of an object were changed: the shape laid over what was made of it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells


def laid_over(wanted: Cells, made: Cells) -> Cells:
    """The shape's cells, moved along the floor so that most of them are where the object's are.

    Args:
        wanted: cells of the shape.
        made: cells of the object.

    Returns:
        The same cells moved by the shift that most pairs of one cell of each have in common, of
        several the one that brings their middles nearest to each other; empty where they are the
        same then: nothing was changed.
    """
    shifts = Counter(
        (cell.x - old.x, cell.y - old.y) for cell in made for old in wanted if cell.z == old.z
    )
    if not shifts:
        return wanted
    middle = [a - b for a, b in zip(_middle(made), _middle(wanted), strict=True)]
    most = max(shifts.values())
    dx, dy = min(
        (shift for shift, count in shifts.items() if count == most),
        key=lambda shift: ((shift[0] - middle[0]) ** 2 + (shift[1] - middle[1]) ** 2, shift),
    )
    moved = frozenset(Cell(cell.x + dx, cell.y + dy, cell.z) for cell in wanted)
    return frozenset() if moved == made else moved


def _middle(cells: Iterable[Cell]) -> tuple[float, float]:
    """Half way between the outermost cells, along x and y."""
    xs, ys, _ = zip(*cells, strict=True)
    return ((min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2)
