"""Other things that people ask for: lamp, mug, boat, car, rocket, ball, television."""

from __future__ import annotations

from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Count, Design, Family
from cellctl.generating.families.forms import lying, ring, stacked


def lamp(brief: Brief) -> Design:
    """A foot, a pole, and a shade that is broad below and narrow above."""
    height = brief.size(3, 3, 6, least=(3, 3, 4))[2]
    plus, square = (".#.", "###", ".#."), ("###", "###", "###")
    return Design(
        brief.noun,
        (
            *lying(plus, 0),
            Box(1, 1, 1, 1, 1, height - 3),
            *lying(square, height - 2),
            *lying(plus, height - 1),
        ),
    )


def mug(brief: Brief) -> Design:
    """A vessel, open at the top, with a handle at its right."""
    height = brief.size(5, 3, 4, least=(5, 3, 3))[2]
    handle = (
        Box(3, 1, 0, 2, 1, 1),
        Box(4, 1, 1, 1, 1, height - 2),
        Box(3, 1, height - 1, 2, 1, 1),
    )
    return Design(brief.noun, (Box(0, 0, 0, 3, 3, 1), *ring(0, 0, 1, 3, 3, height - 1), *handle))


def pot(brief: Brief) -> Design:
    """A vessel, open at the top: a round bowl on a foot, or a cooking pot with two handles."""
    return _bowl(brief) if brief.noun in _ROUND else _cooking_pot(brief)


_ROUND = ("flower pot", "flowerpot", "bowl", "basket", "vase", "tub")


def _cooking_pot(brief: Brief) -> Design:
    height = brief.size(6, 4, 4, least=(6, 4, 2))[2]
    rim, floor = (".##.", "#..#", "#..#", ".##."), (".##.", "####", "####", ".##.")
    vessel = stacked((floor, *((rim,) * (height - 1))))
    handles = [Box(x, 1, max(1, height - 2), 1, 2, 1) for x in (0, 5)]
    return Design(brief.noun, (*(wall._replace(x=wall.x + 1) for wall in vessel), *handles))


def _bowl(brief: Brief) -> Design:
    height = brief.size(5, 5, 3, least=(5, 5, 2))[2]
    rim = (".###.", "#...#", "#...#", "#...#", ".###.")
    floor = (".....", ".###.", ".###.", ".###.", ".....")
    wall = (".###.", "##.##", "#...#", "##.##", ".###.")
    walls = (wall,) if height == 2 else (wall, *((rim,) * (height - 2)))
    return Design(brief.noun, stacked((floor, *walls)[:height]))


def boat(brief: Brief) -> Design:
    """A hull that is pointed at both ends, a mast and a sail."""
    height = brief.size(6, 3, 6, least=(6, 3, 4))[2]
    hull = (*lying((".####.",) * 3, 0), *lying((".####.", "######", ".####."), 1))
    mast = Box(2, 1, 2, 1, 1, height - 2)
    sail = [Box(3, 1, 2, min(2, height - 2 - z), 1, 1)._replace(z=2 + z) for z in range(height - 3)]
    return Design(brief.noun, (*hull, mast, *sail))


def car(brief: Brief) -> Design:
    """A long body on four wheels, with a cabin."""
    brief.count("wheels", 4)
    width, _, height = brief.size(6, 3, 3, least=(5, 3, 3))
    wheels = [Box(x, y, 0, 1, 1, 1) for x in (1, width - 2) for y in (0, 2)]
    return Design(
        brief.noun,
        (*wheels, Box(0, 0, 1, width, 3, 1), Box(1, 0, 2, width - 3, 3, height - 2)),
    )


def bus(brief: Brief) -> Design:
    """A box of one height on four wheels."""
    brief.count("wheels", 4)
    width, _, height = brief.size(6, 3, 3, least=(5, 3, 3))
    wheels = [Box(x, y, 0, 1, 1, 1) for x in (1, width - 2) for y in (0, 2)]
    return Design(brief.noun, (*wheels, Box(0, 0, 1, width, 3, height - 1)))


def lorry(brief: Brief) -> Design:
    """A cab and a flat bed on four wheels."""
    brief.count("wheels", 4)
    width, _, height = brief.size(6, 3, 4, least=(5, 3, 3))
    wheels = [Box(x, y, 0, 1, 1, 1) for x in (1, width - 2) for y in (0, 2)]
    return Design(brief.noun, (*wheels, Box(0, 0, 1, width, 3, 1), Box(0, 0, 2, 2, 3, height - 2)))


def rocket(brief: Brief) -> Design:
    """Four swept fins, on whose ends and nozzle it stands, about a round body with a tip."""
    height = brief.size(5, 5, 6, least=(5, 5, 4))[2]
    ends = ("..#..", ".....", "#.#.#", ".....", "..#..")
    fins = ("..#..", "..#..", "#####", "..#..", "..#..")
    body = (".....", "..#..", ".###.", "..#..", ".....")
    tip = (".....", ".....", "..#..", ".....", ".....")
    return Design(brief.noun, stacked((ends, fins, *((body,) * (height - 3)), tip)))


def ball(brief: Brief) -> Design:
    """A ball four cells across."""
    inner = ("....", ".##.", ".##.", "....")
    outer = (".##.", "####", "####", ".##.")
    height = brief.size(4, 4, 4, least=(4, 4, 4))[2]
    return Design(brief.noun, stacked((inner, *((outer,) * (height - 2)), inner)))


def crown(brief: Brief) -> Design:
    """A ring with a point on each corner and in the middle of each side."""
    width, depth, height = brief.size(5, 5, 2, least=(3, 3, 2))
    points = [
        (x, y)
        for x in range(0, width, 2)
        for y in range(0, depth, 2)
        if x in (0, width - 1) or y in (0, depth - 1)
    ]
    return Design(
        brief.noun,
        (
            *ring(0, 0, 0, width, depth, height - 1),
            *(Box(x, y, height - 1, 1, 1, 1) for x, y in points),
        ),
    )


def television(brief: Brief) -> Design:
    """A flat screen on a foot."""
    width, _, height = brief.size(6, 3, 5, least=(3, 3, 3))
    return Design(
        brief.noun,
        (
            Box(1, 0, 0, width - 2, 3, 1),
            Box(width // 2 - 1, 1, 1, 2, 1, 1),
            Box(0, 1, 2, width, 1, height - 2),
        ),
    )


def hourglass(brief: Brief) -> Design:
    """Broad, narrow, broad."""
    height = brief.size(3, 3, 5, least=(3, 3, 5))[2]
    square, plus, dot = ("###", "###", "###"), (".#.", "###", ".#."), ("...", ".#.", "...")
    return Design(brief.noun, stacked((square, plus, *((dot,) * (height - 4)), plus, square)))


_WHEELS = {"wheels": Count(4, 4, "It stands on four.")}

FAMILIES = (
    Family("lamp", ("lamp", "floor lamp", "table lamp", "light", "lantern", "desk lamp"), lamp),
    Family("mug", ("mug", "cup", "teacup", "jug", "pitcher"), mug),
    Family(
        "pot", ("pot", "flower pot", "flowerpot", "bowl", "bucket", "basket", "vase", "tub"), pot
    ),
    Family("boat", ("boat", "ship", "sailboat", "sailing boat", "yacht"), boat),
    Family("car", ("car", "vehicle", "taxi", "automobile"), car, _WHEELS),
    Family("bus", ("bus", "van", "coach", "caravan"), bus, _WHEELS),
    Family("lorry", ("lorry", "truck", "pickup"), lorry, _WHEELS),
    Family("rocket", ("rocket", "spaceship", "space shuttle"), rocket),
    Family("ball", ("ball", "sphere", "globe", "planet", "moon", "sun"), ball),
    Family("crown", ("crown",), crown),
    Family("television", ("television", "tv", "monitor", "screen"), television),
    Family("hourglass", ("hourglass", "sand timer"), hourglass),
)
