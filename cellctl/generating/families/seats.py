"""Things to sit on: stool, chair, armchair, bench."""

from __future__ import annotations

from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Design, Family, counted, titled
from cellctl.generating.families.legs import MOST_LEGS, TOP_SIZES, columns, legged_top, posts

_SEAT_LAYER = 2
"""Top of the seat three cells above the floor, half the height of the paper's workspace."""


def stool(brief: Brief) -> Design:
    """A seat on legs: three by default, the seat then rounded towards the single leg."""
    legs = brief.whole("legs", 3, 1, MOST_LEGS)
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
    legs = brief.whole("legs", 4, 1, 5)
    back = brief.flag("back", True)
    arms = brief.flag("arms", brief.noun == "armchair")
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
        "arms" if arms and brief.noun != "armchair" else "",
        "" if back else "no back",
    )
    return Design(title, tuple(boxes))


def bench(brief: Brief) -> Design:
    """A long seat on two panels, or on as many legs as asked for; back and arms on request."""
    back = brief.flag("back", False)
    arms = brief.flag("arms", False)
    legs = brief.whole("legs", 0, 1, 6)
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


FAMILIES = (
    Family("stool", ("stool", "footstool", "barstool"), stool),
    Family("chair", ("chair", "armchair", "seat"), chair),
    Family("bench", ("bench",), bench),
)
