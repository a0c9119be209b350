"""Things that only stand there: tower and cube."""

from __future__ import annotations

from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Design, Family


def tower(brief: Brief) -> Design:
    """A keep with hollow walls and a battlement on each corner; a solid shaft where it is slim."""
    width, depth, height = brief.size(3, 3, 5, least=(1, 1, 2))
    if min(width, depth) < 3:
        return Design("tower", (Box(0, 0, 0, width, depth, height),))
    right, rear, wall = width - 1, depth - 1, height - 1
    boxes = (
        Box(0, 0, 0, 1, depth, wall),
        Box(right, 0, 0, 1, depth, wall),
        Box(1, 0, 0, width - 2, 1, wall),
        Box(1, rear, 0, width - 2, 1, wall),
        *(Box(x, y, wall, 1, 1, 1) for x in (0, right) for y in (0, rear)),
    )
    return Design("tower", boxes)


def cube(brief: Brief) -> Design:
    """A solid block."""
    width, depth, height = brief.size(3, 3, 3)
    return Design("cube", (Box(0, 0, 0, width, depth, height),))


FAMILIES = (
    Family("tower", ("tower",), tower),
    Family("cube", ("cube", "block"), cube),
)
