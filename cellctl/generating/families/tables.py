"""Things with a flat top to work at: table, coffee table, desk."""

from __future__ import annotations

from cellctl.errors import DesignError
from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Count, Design, Family, counted, titled
from cellctl.generating.families.legs import MOST_LEGS, TOP_SIZES, columns, legged_top, posts

_TABLE_HEIGHT = 6
"""The height of the paper's table, which stands on one leg, in cells."""
_USUAL_TOP = (5, 4, 4)
"""What a table is unless told otherwise: wider than high, which tells it from a stool."""


def table(brief: Brief) -> Design:
    """A top on four legs, or on as many as asked for."""
    legs = brief.count("legs", 4)
    width, depth, height = _USUAL_TOP if legs == 4 else TOP_SIZES[legs]
    if legs == 1:
        width = depth = 4
    if height >= 5:
        height = _TABLE_HEIGHT
    return Design(
        titled(brief.noun, counted(legs, "leg")), legged_top(brief, (width, depth, height), legs)
    )


def coffee_table(brief: Brief) -> Design:
    """A low, wide top on four legs, or on as many as asked for."""
    legs = brief.count("legs", 4)
    width, depth, height = TOP_SIZES[legs] if legs != 4 else (5, 4, 3)
    boxes = legged_top(brief, (width, depth, min(height, 3)), legs)
    return Design(titled(brief.noun, counted(legs, "leg")), boxes)


def desk(brief: Brief) -> Design:
    """A wide top on a panel at each end, or on as many legs as asked for.

    Drawers are a stack in the place of the right panel, each with a handle that stands out.
    """
    drawers = brief.count("drawers", 0)
    if drawers and brief.attributes.get("legs") == 0:
        del brief.attributes["legs"]  # it stood on panels before it was given drawers
    legs = brief.count("legs", 2 if drawers else 0)
    if drawers:
        return _desk_with_drawers(brief, drawers, legs)
    width, depth, height = brief.size(5, 3, 5, least=(3, 1, 2))
    boxes = [Box(0, 0, height - 1, width, depth, 1)]
    if legs:
        boxes += posts(columns(legs, width, depth, brief.noun), height - 1)
    else:
        boxes += [Box(x, 0, 0, 1, depth, height - 1) for x in (0, width - 1)]
    return Design(titled(brief.noun, counted(legs, "leg") if legs else ""), tuple(boxes))


def _desk_with_drawers(brief: Brief, drawers: int, legs: int) -> Design:
    if legs != 2:
        raise DesignError(
            f"A {brief.noun} with drawers stands on them and on two legs here, "
            f"not on {counted(legs, 'leg')}.",
            "Ask for one or the other.",
        )
    # One cell of depth is the handles'.
    width, depth, height = brief.size(4, 4, 2 * drawers + 1 - (drawers > 1), least=(4, 4, 2))
    if height < 2 * drawers:
        raise brief.refuse_short(counted(drawers, "drawer"), height)
    right = width - 1
    boxes = [
        Box(0, 1, height - 1, width, depth - 1, 1),
        *posts(((0, 1), (0, depth - 1)), height - 1),
        Box(right, 1, 0, 1, depth - 1, height - 1),
        *(Box(right, 0, height - 2 - 2 * n, 1, 1, 1) for n in range(drawers)),
    ]
    return Design(titled(brief.noun, counted(drawers, "drawer")), tuple(boxes))


_LEGS = "Separate legs on the floor."

FAMILIES = (
    Family(
        "coffee table",
        ("coffee table", "side table", "low table", "tv stand", "monitor riser", "monitor stand"),
        coffee_table,
        {"legs": Count(1, MOST_LEGS, _LEGS)},
    ),
    Family(
        "table",
        ("table", "dining table", "kitchen table", "workbench", "bedside table", "trestle"),
        table,
        {"legs": Count(1, MOST_LEGS, _LEGS)},
    ),
    Family(
        "desk",
        ("desk", "writing desk", "workstation"),
        desk,
        {
            "legs": Count(1, 6, f"{_LEGS} Two panels where none are named."),
            "drawers": Count(0, 3, "Drawers under its right end, each with a handle."),
        },
    ),
)
