"""Figures that are drawn: a person, a robot, birds and fish, a heart, an arrow."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import Brief, Count, Design, Family, Flag, titled
from cellctl.generating.families.forms import at_height, lying, standing
from cellctl.generating.wording import with_article


def person(brief: Brief) -> Design:
    """Somebody who stands with arms held out, feet to the front."""
    arms = brief.flag("arms", True)
    brief.count("legs", 2)
    shoulders = "#####" if arms else ".###."
    rows = ("..#..", shoulders, ".###.", ".###.", ".#.#.", ".#.#.")
    _, depth, height = brief.size(5, 2, 6, least=(5, 1, 4))
    drawn = (
        (*rows[:3], *at_height(rows[3:], height - 3)) if height >= 6 else at_height(rows, height)
    )
    figure = standing(drawn, 1, y=depth - 1)
    feet = tuple(Box(x, 0, 0, 1, depth, 1) for x in (1, 3))
    return Design(titled(brief.noun, "" if arms else "no arms"), (*figure, *feet))


def robot(brief: Brief) -> Design:
    """A square head with an antenna on a neck, and arms that are raised apart from it."""
    brief.count("legs", 2)
    rows = (".####.", "..##..", "######", ".####.", ".#..#.")
    _, depth, height = brief.size(6, 2, 6, least=(6, 1, 5))
    drawn = (*rows[:2], *at_height(rows[2:], height - 3))
    forearms = [Box(x, 0, height - 3, 1, 1, 1) for x in (0, 5)]
    antenna = Box(2, depth - 1, height - 1, 1, 1, 1)
    return Design(brief.noun, (*standing(drawn, depth), *forearms, antenna))


def bear(brief: Brief) -> Design:
    """A teddy bear: ears on the corners of a broad head, a snout, arms, and broad feet."""
    brief.count("legs", 2)
    _, depth, height = brief.size(5, 3, 5, least=(5, 3, 5))
    rows = ("#####", *(".###.",) * (height - 3), "##.##")
    front = depth - 2
    body = standing(rows, 2, y=front)
    beside = [Box(x, front, z, 1, 1, 1) for x in (0, 4) for z in (height - 1, height - 3)]
    return Design(brief.noun, (*body, *beside, Box(2, front - 1, height - 2, 1, 1, 1)))


def snake(brief: Brief) -> Design:
    """A winding body on the floor, its head raised."""
    height = brief.size(6, 5, 3, least=(6, 5, 2))[2]
    body = lying(("####..", "...#..", "...###", ".....#", "..####"), 0)
    return Design(
        brief.noun, (*body, Box(2, 0, 1, 1, 1, height - 1), Box(1, 0, height - 1, 1, 1, 1))
    )


@dataclass(frozen=True)
class Drawing:
    """A front view of one thickness."""

    nouns: tuple[str, ...]
    rows: tuple[str, ...]
    depth: int = 1


DRAWINGS: dict[str, Drawing] = {
    "duck": Drawing(
        ("duck", "bird", "swan", "goose", "duckling", "rubber duck", "dove"),
        (".##...", "###...", ".##..#", ".#####", ".####.", "..##.."),
        2,
    ),
    "fish": Drawing(
        ("fish", "shark", "dolphin", "goldfish"),
        ("..##.#", ".#####", "######", ".#####", "..##.#"),
    ),
    "heart": Drawing(("heart", "love heart"), (".#.#.", "#####", "#####", ".###.", "..#..")),
    "arrow": Drawing(("arrow",), ("..#..", ".###.", "#####", "..#..", "..#..")),
}
"""By family."""


def _drawn(drawing: Drawing) -> Callable[[Brief], Design]:
    def figure(brief: Brief) -> Design:
        width, height = len(drawing.rows[0]), len(drawing.rows)
        _, depth, height = brief.size(width, drawing.depth, height)
        return Design(brief.noun, standing(at_height(drawing.rows, height), depth))

    figure.__doc__ = f"{with_article(drawing.nouns[0]).capitalize()}, drawn from its side."
    return figure


_STANDS = Count(2, 2, "It stands on two.")

FAMILIES = (
    Family(
        "person",
        (
            "person",
            "man",
            "woman",
            "child",
            "boy",
            "girl",
            "doll",
            "human",
            "figure",
            "statue",
            "mannequin",
            "scarecrow",
            "people",
        ),
        person,
        {"arms": Flag("Arms held out."), "legs": _STANDS},
    ),
    Family("robot", ("robot", "android"), robot, {"legs": _STANDS}),
    Family("bear", ("bear", "teddy bear", "panda", "polar bear", "teddy"), bear, {"legs": _STANDS}),
    Family("snake", ("snake", "worm", "serpent"), snake),
    *(Family(name, drawing.nouns, _drawn(drawing)) for name, drawing in DRAWINGS.items()),
)
