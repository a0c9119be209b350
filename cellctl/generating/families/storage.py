"""Things that hold things: shelf, bookcase, box."""

from __future__ import annotations

from itertools import pairwise

from cellctl.errors import DesignError
from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Design, Family, counted, titled

_MOST_TIERS = 3
"""One cell of tier and one of room above each, in the paper's six layers."""


_TIER_THICKNESS = 0.5
"""In cells. A tier inside the shelf, thinner than its cell, stays in one layer when the whole shape
is rescaled; at full thickness it would straddle two."""


def _tier_layers(tiers: int, height: int, noun: str) -> tuple[int, ...]:
    """Layers of the tiers, evenly spaced: the top one closes the shelf.

    With little height the lowest tier lies on the floor.

    Raises:
        DesignError: no room is left between so many tiers.
    """
    if height >= 2 * tiers:
        layers = tuple(round((k + 1) * height / tiers) - 1 for k in range(tiers))
    else:
        layers = tuple(round(k * (height - 1) / max(1, tiers - 1)) for k in range(tiers))
    if any(upper - lower < 2 for lower, upper in pairwise(layers)):
        raise DesignError(
            f"I cannot fit {counted(tiers, 'tier')} into a {noun} {height} parts high.",
            "Ask for fewer tiers or more height.",
        )
    return layers


def shelf(brief: Brief) -> Design:
    """Two side panels and full tiers: two by default, three for a bookcase."""
    bookcase = brief.noun in ("bookcase", "bookshelf")
    tiers = brief.whole("tiers", 3 if bookcase else 2, 1, _MOST_TIERS)
    back = brief.flag("back", False)
    default = {1: (5, 2, 3), 2: (6, 3, 6), 3: (5, 2, 5)}[tiers]
    if back:
        default = (4, 2, default[2] if tiers == 1 else 5)
    width, depth, height = brief.size(*default, least=(3, 1, 2))
    layers = _tier_layers(tiers, height, brief.noun)
    boxes = [Box(x, 0, 0, 1, depth, height) for x in (0, width - 1)]
    boxes += [Box(0, 0, z + 1 - _TIER_THICKNESS, width, depth, _TIER_THICKNESS) for z in layers]
    if back:
        boxes.append(Box(1, depth - 1, 0, width - 2, 1, height))
    title = titled(brief.noun, counted(tiers, "tier"), "a back" if back else "")
    return Design(title, tuple(boxes))


def box(brief: Brief) -> Design:
    """A box, open at the top unless a lid is asked for; its walls are one cell thick."""
    lid = brief.flag("lid", False)
    width, depth, height = brief.size(4, 3, 3, least=(3, 3, 2 + lid))
    right, rear = width - 1, depth - 1
    boxes = [
        Box(0, 0, 0, width, depth, 1),
        Box(0, 0, 1, 1, depth, height - 1),
        Box(right, 0, 1, 1, depth, height - 1),
        Box(1, 0, 1, width - 2, 1, height - 1),
        Box(1, rear, 1, width - 2, 1, height - 1),
    ]
    if lid:
        boxes.append(Box(0, 0, height - 1, width, depth, 1))
    return Design(titled("box", "a lid" if lid else ""), tuple(boxes))


FAMILIES = (
    Family("shelf", ("shelf", "bookcase", "bookshelf", "rack"), shelf),
    Family("box", ("box", "crate", "chest"), box),
)
