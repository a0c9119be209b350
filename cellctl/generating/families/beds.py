"""Things to lie on: bed and bunk bed."""

from __future__ import annotations

from cellctl.errors import DesignError
from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Count, Design, Family, Flag, counted, titled
from cellctl.generating.families.legs import columns, posts


def bed(brief: Brief) -> Design:
    """A long, low bed on four legs: a headboard at its left end, with a pillow, and a footboard.

    Two tiers are a bunk bed.
    """
    tiers = brief.count("tiers", 2 if brief.noun == "bunk bed" else 1)
    if tiers == 2:
        return _bunk(brief)
    board = brief.flag("back", True)
    double = brief.noun == "double bed"
    width, depth, height = brief.size(
        6, 4 if double else 3, 4 if board else 2, least=(4, 3, 3 if board else 2)
    )
    top = 1 if height < 5 else height - 3
    boxes = [
        Box(0, 0, top, width, depth, 1),
        *posts(columns(4, width, depth, brief.noun), top),
    ]
    if board:
        boxes.append(Box(0, 0, top + 1, 1, depth, height - top - 1))
        if not double:
            boxes.append(Box(1, 0, top + 1, 1, depth, 1))
    return Design(titled(brief.noun, "" if board else "no headboard"), tuple(boxes))


def _bunk(brief: Brief) -> Design:
    width, depth, height = brief.size(5, 2, 5, least=(4, 2, 4))
    if depth < 2 or height < 4:
        raise DesignError(f"I cannot fit {counted(2, 'tier')} into a bed {height} parts high.")
    upper = height - 1
    corners = [(x, y) for x in (0, width - 1) for y in (0, depth - 1)]
    boxes = [
        *(Box(0, 0, z, width, depth, 1) for z in (1, upper)),
        *posts(tuple(corners), upper),
    ]
    return Design("bunk bed", tuple(boxes))


FAMILIES = (
    Family(
        "bed",
        ("bed", "double bed", "bunk bed", "cot", "crib"),
        bed,
        {
            "tiers": Count(1, 2, "One above the other; two are a bunk bed."),
            "back": Flag("A headboard at its left end."),
        },
    ),
)
