"""Where legs stand under a top, and tops that are carried by them."""

from __future__ import annotations

from cellctl.errors import DesignError
from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, counted

MOST_LEGS = 9

TOP_SIZES = {
    1: (3, 3, 5),
    2: (4, 3, 5),
    3: (5, 4, 5),
    4: (4, 4, 5),
    5: (5, 5, 4),
    6: (5, 4, 4),
    7: (5, 5, 3),
    8: (5, 5, 2),
    9: (5, 5, 2),
}
"""Width, depth and height in cells, by number of legs, that keep the legs apart and the parts
within forty."""


def columns(legs: int, width: int, depth: int, noun: str) -> tuple[tuple[int, int], ...]:
    """Cells (x, y) of the legs under a top; no two share a face, so that each can be counted.

    Raises:
        DesignError: so many separate legs do not fit under a top of that size.
    """
    mid_x, mid_y = (width - 1) // 2, (depth - 1) // 2
    right, rear = width - 1, depth - 1
    corners = ((0, 0), (right, 0), (0, rear), (right, rear))
    sides_x = ((mid_x, 0), (mid_x, rear))
    sides_y = ((0, mid_y), (right, mid_y))
    centre = ((mid_x, mid_y),)
    layout: tuple[tuple[int, int], ...] = {
        1: centre,
        2: sides_y,
        3: (*corners[:2], (mid_x, rear)),
        4: corners,
        5: corners + centre,
        6: corners + sides_x,
        7: corners + sides_x + centre,
        8: corners + sides_x + sides_y,
        9: corners + sides_x + sides_y + centre,
    }[legs]
    apart = all(
        abs(a[0] - b[0]) + abs(a[1] - b[1]) > 1
        for i, a in enumerate(layout)
        for b in layout[i + 1 :]
    )
    if not apart:
        raise DesignError(
            f"I cannot put {counted(legs, 'separate leg')} under a {noun} "
            f"of {width} by {depth} parts.",
            "Ask for fewer legs or a larger top.",
        )
    return layout


def posts(places: tuple[tuple[int, int], ...], height: int) -> list[Box]:
    """Straight legs, one cell thick, from the floor up."""
    return [Box(x, y, 0, 1, 1, height) for x, y in places]


def legged_top(brief: Brief, default: tuple[int, int, int], legs: int) -> tuple[Box, ...]:
    """A flat top, one cell thick, on straight legs."""
    width, depth, height = brief.size(*default, least=(1, 1, 2))
    top = Box(0, 0, height - 1, width, depth, 1)
    return (top, *posts(columns(legs, width, depth, brief.noun), height - 1))
