"""Things that grow, or are heaped: trees, a mushroom, a snowman."""

from __future__ import annotations

from cellctl.generating.families.brief import Brief, Design, Family
from cellctl.generating.families.forms import stacked

_DOT = (".....", ".....", "..#..", ".....", ".....")
_PLUS = (".....", "..#..", ".###.", "..#..", ".....")
_SQUARE = (".....", ".###.", ".###.", ".###.", ".....")
_DIAMOND = ("..#..", ".###.", "#####", ".###.", "..#..")
_ROUND = (".###.", "#####", "#####", "#####", ".###.")
_ARMED = (".....", "..#..", "#####", "..#..", ".....")
_NOSED = (".....", ".....", "..#..", "..#..", ".....")


def tree(brief: Brief) -> Design:
    """A thin trunk with a broad crown."""
    return _grown(brief, trunk=2, crown=(_SQUARE, _SQUARE, _SQUARE, _PLUS))


def fir(brief: Brief) -> Design:
    """A short trunk with boughs that are shorter the higher they are."""
    return _grown(brief, trunk=1, crown=(_DIAMOND, _SQUARE, _PLUS, _DOT, _DOT))


def mushroom(brief: Brief) -> Design:
    """A stem with a broad cap."""
    return _grown(brief, trunk=2, crown=(_ROUND, _SQUARE))


def snowman(brief: Brief) -> Design:
    """A ball of snow, a smaller one with arms, a face with a nose, and a hat with a brim."""
    return _grown(brief, trunk=0, crown=(_SQUARE, _SQUARE, _ARMED, _NOSED, _PLUS, _DOT))


def _grown(brief: Brief, trunk: int, crown: tuple[tuple[str, ...], ...]) -> Design:
    """Layers on a trunk that is as long as a stated height leaves."""
    usual = trunk + len(crown)
    height = brief.size(5, 5, usual, least=(3, 3, len(crown) + min(1, trunk)))[2]
    below = (_DOT,) * (height - len(crown)) if trunk else (crown[0],) * (height - len(crown))
    boxes = stacked((*below, *crown))
    left, front = min(box.x for box in boxes), min(box.y for box in boxes)
    return Design(brief.noun, tuple(b._replace(x=b.x - left, y=b.y - front) for b in boxes))


FAMILIES = (
    Family(
        "fir tree",
        ("fir tree", "fir", "christmas tree", "pine", "pine tree", "conifer", "spruce"),
        fir,
    ),
    Family("tree", ("tree", "oak", "apple tree", "palm tree", "plant", "bush", "shrub"), tree),
    Family("mushroom", ("mushroom", "toadstool"), mushroom),
    Family("snowman", ("snowman",), snowman),
)
