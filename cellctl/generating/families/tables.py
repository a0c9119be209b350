"""Things with a flat top to work at: table, coffee table, desk."""

from __future__ import annotations

from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Design, Family, counted, titled
from cellctl.generating.families.legs import MOST_LEGS, TOP_SIZES, columns, legged_top, posts

_TABLE_HEIGHT = 6
"""The height of the paper's table, in cells."""


def table(brief: Brief) -> Design:
    """A top four cells square on four legs, or on as many as asked for."""
    legs = brief.whole("legs", 4, 1, MOST_LEGS)
    width, depth, height = TOP_SIZES[legs]
    if legs == 1:
        width = depth = 4
    if height >= 5:
        height = _TABLE_HEIGHT
    return Design(
        titled("table", counted(legs, "leg")), legged_top(brief, (width, depth, height), legs)
    )


def coffee_table(brief: Brief) -> Design:
    """A low, wide top on four legs, or on as many as asked for."""
    legs = brief.whole("legs", 4, 1, MOST_LEGS)
    width, depth, height = TOP_SIZES[legs] if legs != 4 else (5, 4, 3)
    boxes = legged_top(brief, (width, depth, min(height, 3)), legs)
    return Design(titled("coffee table", counted(legs, "leg")), boxes)


def desk(brief: Brief) -> Design:
    """A wide top on a panel at each end, or on as many legs as asked for."""
    width, depth, height = brief.size(5, 3, 5, least=(3, 1, 2))
    boxes = [Box(0, 0, height - 1, width, depth, 1)]
    legs = brief.whole("legs", 0, 1, 6)
    if legs:
        boxes += posts(columns(legs, width, depth, brief.noun), height - 1)
    else:
        boxes += [Box(x, 0, 0, 1, depth, height - 1) for x in (0, width - 1)]
    return Design(titled("desk", counted(legs, "leg") if legs else ""), tuple(boxes))


FAMILIES = (
    Family("coffee table", ("coffee table", "side table", "low table"), coffee_table),
    Family("table", ("table", "dining table"), table),
    Family("desk", ("desk", "workbench"), desk),
)
