"""Things to sit on: stool, chair, armchair, bench, sofa, throne."""

from __future__ import annotations

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
from cellctl.generating.families.legs import MOST_LEGS, TOP_SIZES, columns, legged_top, posts

_SEAT_LAYER = 2
"""Top of the seat three cells above the floor, half the height of the paper's workspace."""


def stool(brief: Brief) -> Design:
    """A seat on legs: three by default, the seat then rounded towards the single leg."""
    legs = brief.count("legs", 3)
    boxes = legged_top(brief, TOP_SIZES[legs], legs)
    seat = boxes[0]
    if legs == 3 and seat.width >= 5 and seat.depth >= 3:
        main = seat._replace(depth=seat.depth - 1)
        tip = Box(1, seat.depth - 1, seat.z, seat.width - 2, 1, 1)
        boxes = (main, tip, *boxes[1:])
    return Design(titled("stool", counted(legs, "leg")), boxes)


def _above_seat(
    width: int, depth: int, height: int, seat_z: int, *, back: bool, arms: bool
) -> list[Box]:
    """The seat itself, its back at the rear (y highest), and one cell of arms on both sides."""
    boxes = [Box(0, 0, seat_z, width, depth, 1)]
    if back:
        boxes.append(Box(0, depth - 1, seat_z + 1, width, 1, height - 1 - seat_z))
    if arms:
        boxes += [Box(x, 0, seat_z + 1, 1, depth, 1) for x in (0, width - 1)]
    return boxes


def _seat_layer(height: int, *, back: bool, arms: bool) -> int:
    return min(_SEAT_LAYER, height - 2) if back or arms else height - 1


def chair(brief: Brief) -> Design:
    """A seat on four legs, with a back unless told otherwise, and with arms where asked for."""
    return _chair(brief, armed=False)


def armchair(brief: Brief) -> Design:
    """A chair with arms unless told otherwise."""
    return _chair(brief, armed=True)


def _chair(brief: Brief, *, armed: bool) -> Design:
    legs = brief.count("legs", 4)
    back = brief.flag("back", True)
    arms = brief.flag("arms", armed)
    width, depth, height = brief.size(
        4 if arms else 3,
        3,
        6 if back else 3 + arms,
        least=(3, 2, 3),
    )
    seat_z = _seat_layer(height, back=back, arms=arms)
    boxes = _above_seat(width, depth, height, seat_z, back=back, arms=arms)
    boxes += posts(columns(legs, width, depth, brief.noun), seat_z)
    title = titled(
        brief.noun,
        counted(legs, "leg") if "legs" in brief.attributes else "",
        "arms" if arms and not armed else "",
        "no arms" if armed and not arms else "",
        "" if back else "no back",
    )
    return Design(title, tuple(boxes))


def bench(brief: Brief) -> Design:
    """A long seat on two panels, or on as many legs as asked for; back and arms on request."""
    back = brief.flag("back", False)
    arms = brief.flag("arms", False)
    legs = brief.count("legs", 0)
    if legs and (back or arms):
        default = (5, 3, 5 if back and legs < 6 else 4)
    else:
        default = (6, 3 if legs else 2, 5 if back else 3 + arms)
    width, depth, height = brief.size(*default, least=(3, 1, 3 if back or arms else 2))
    seat_z = _seat_layer(height, back=back, arms=arms)
    boxes = _above_seat(width, depth, height, seat_z, back=back, arms=arms)
    # Supports at the very ends of a seat six wide would leave four cells hanging between them.
    inset = 1 if width > 5 and legs <= 5 else 0
    if legs:
        places = columns(legs, width - 2 * inset, depth, brief.noun)
        boxes += posts(tuple((x + inset, y) for x, y in places), seat_z)
    else:
        boxes += [Box(x, 0, 0, 1, depth, seat_z) for x in (inset, width - 1 - inset)]
    title = titled(
        "bench",
        counted(legs, "leg") if legs else "",
        "a back" if back else "",
        "arms" if arms else "",
    )
    return Design(title, tuple(boxes))


def sofa(brief: Brief) -> Design:
    """A low, long seat on four feet with a back and arms; an arm's width of back above it."""
    back = brief.flag("back", True)
    arms = brief.flag("arms", True)
    short = brief.noun in ("loveseat", "love seat")
    width, depth, height = brief.size(
        4 if short else 6, 3, 4 if back else 2 + arms, least=(3, 2, 3 if back or arms else 2)
    )
    seat_z = min(1, height - 2)
    boxes = [Box(0, 0, seat_z, width, depth, 1)]
    boxes += posts(columns(4, width, depth, brief.noun), seat_z)
    if back:
        boxes.append(Box(0, depth - 1, seat_z + 1, width, 1, height - seat_z - 1))
    if arms:
        boxes += [Box(x, 0, seat_z + 1, 1, depth, 1) for x in (0, width - 1)]
    return Design(
        titled(brief.noun, "" if arms else "no arms", "" if back else "no back"), tuple(boxes)
    )


def throne(brief: Brief) -> Design:
    """A solid seat with arms and a high back that is higher at its corners."""
    width, depth, height = brief.size(4, 3, 6, least=(3, 2, 4))
    boxes = [
        Box(0, 0, 0, width, depth - 1, 1),
        Box(0, depth - 1, 0, width, 1, height - 1),
        *(Box(x, 0, 1, 1, depth - 1, 1) for x in (0, width - 1)),
        *(Box(x, depth - 1, height - 1, 1, 1, 1) for x in (0, width - 1)),
    ]
    return Design("throne", tuple(boxes))


_LEGS = "Separate legs on the floor."
_BACK = Flag("A backrest at the rear.")
_ARMS = Flag("Armrests at both sides.")

FAMILIES = (
    Family(
        "stool",
        ("stool", "footstool", "barstool", "bar stool", "milking stool", "ottoman"),
        stool,
        {"legs": Count(1, MOST_LEGS, _LEGS)},
    ),
    Family(
        "chair",
        ("chair", "seat", "dining chair", "kitchen chair", "high chair"),
        chair,
        {"legs": Count(1, 5, _LEGS), "back": _BACK, "arms": _ARMS},
    ),
    Family(
        "armchair",
        ("armchair", "easy chair", "recliner"),
        armchair,
        {"legs": Count(1, 5, _LEGS), "back": _BACK, "arms": _ARMS},
    ),
    Family(
        "bench",
        ("bench", "pew"),
        bench,
        {
            "legs": Count(1, 6, f"{_LEGS} Two panels where none are named."),
            "back": _BACK,
            "arms": _ARMS,
        },
    ),
    Family(
        "sofa",
        ("sofa", "couch", "loveseat", "love seat", "settee"),
        sofa,
        {"back": _BACK, "arms": _ARMS},
    ),
    Family("throne", ("throne",), throne),
)
