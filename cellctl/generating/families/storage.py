"""Things that hold things: shelf, bookcase, box, chest of drawers, wardrobe."""

from __future__ import annotations

from itertools import pairwise

from cellctl.errors import DesignError
from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import (
    Brief,
    Count,
    Design,
    Family,
    Flag,
    counted,
    titled,
)
from cellctl.generating.families.forms import ring

_MOST_TIERS = 6

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
    """Two side panels and two full tiers, or as many as asked for."""
    return _shelf(brief, 2)


def bookcase(brief: Brief) -> Design:
    """A shelf of three tiers."""
    return _shelf(brief, 3)


def _shelf(brief: Brief, usual_tiers: int) -> Design:
    tiers = brief.count("tiers", usual_tiers)
    back = brief.flag("back", False)
    default = {1: (5, 2, 3), 2: (6, 3, 6), 3: (5, 2, 5)}.get(tiers, (4, 2, 2 * tiers - 1))
    if back:
        default = (4, 2, default[2] if tiers != 2 else 5)
    most = (brief.grid[2] + 1) // 2
    if tiers > most:
        raise DesignError(
            f"I cannot design a {brief.noun} with {counted(tiers, 'tier')}; at most {most} here."
        )
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
    lid = brief.flag("lid", brief.noun in ("chest", "treasure chest"))
    # Without a lid it is deep enough that one sees into it.
    width, depth, height = brief.size(4, 3 if lid else 4, 3, least=(3, 3, 2 + lid))
    walls = ring(0, 0, 1, width, depth, height - 1)
    boxes = [Box(0, 0, 0, width, depth, 1), *walls]
    if lid:
        boxes.append(Box(0, 0, height - 1, width, depth, 1))
    return Design(titled(brief.noun, "a lid" if lid else ""), tuple(boxes))


def drawers(brief: Brief) -> Design:
    """A chest of drawers: the knob of each stands out from the block, and counts.

    Up to three lie above each other; more stand in two columns. It has feet where there is height.
    """
    number = brief.count("drawers", _USUAL_DRAWERS.get(brief.noun, 4))
    columns = 1 if number <= 3 else 2
    rows = -(-number // columns)
    width, depth, height = brief.size(
        3 if columns == 1 else 5,
        3 if number <= 4 else 2,
        max(2, 2 * rows - (rows > 2)),
        least=(2 * columns + 1, 2, 1),
    )
    if height < 2 * rows - 1:
        raise brief.refuse_short(counted(number, "drawer"), height)
    feet = 1 if height >= 2 * rows else 0
    places = (width // 2,) if columns == 1 else (1, width - 2)
    knobs = [(x, feet + 2 * row) for row in range(rows) for x in places][:number]
    boxes = [
        Box(0, 1, feet, width, depth - 1, height - feet),
        *(Box(x, 1, 0, 1, depth - 1, feet) for x in (0, width - 1) if feet),
        *(Box(x, 0, z, 1, 1, 1) for x, z in knobs),
    ]
    return Design(titled(brief.noun, counted(number, "drawer")), tuple(boxes))


_USUAL_DRAWERS = {
    "nightstand": 1,
    "night table": 1,
    "bedside cabinet": 1,
    "drawer": 1,
    "filing cabinet": 3,
}


FAMILIES = (
    Family(
        "shelf",
        ("shelf", "rack", "shoe rack", "shelving unit"),
        shelf,
        {
            "tiers": Count(1, _MOST_TIERS, "Full layers, with room between them."),
            "back": Flag("A panel at the rear."),
        },
    ),
    Family(
        "bookcase",
        ("bookcase", "bookshelf"),
        bookcase,
        {
            "tiers": Count(1, _MOST_TIERS, "Full layers, with room between them."),
            "back": Flag("A panel at the rear."),
        },
    ),
    Family(
        "box",
        ("box", "crate", "chest", "treasure chest", "toolbox", "planter", "bin", "trough"),
        box,
        {"lid": Flag("Closed at the top.")},
    ),
    Family(
        "chest of drawers",
        (
            "chest of drawers",
            "dresser",
            "cabinet",
            "drawer",
            "sideboard",
            "nightstand",
            "night table",
            "bedside cabinet",
            "filing cabinet",
            "commode",
        ),
        drawers,
        {"drawers": Count(1, 6, "Drawers, each with a handle that stands out.")},
    ),
)
