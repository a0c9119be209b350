"""Animals on four legs: one body plan, and the measures by which a dog is no giraffe."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

from cellctl.generating.boxes import Box
from cellctl.generating.families.brief import (
    Brief,
    Count,
    Design,
    Family,
    Flag,
    Sign,
    Takes,
)
from cellctl.generating.wording import with_article

_DEPTH = 3
"""A leg, the gap that tells two legs apart, and a leg."""
_MID = 1


@dataclass(frozen=True)
class Measures:
    """Of one kind of animal, in cells; it looks to the left and is seen from its side."""

    body: int = 4
    """Length of its trunk."""
    belly: int = 1
    """Height of its trunk."""
    legs: int = 2
    neck: int = 0
    """Height of its neck, one cell thick."""
    head: Literal["broad", "narrow", "low", "deep"] = "broad"
    """``broad``: as wide as its body, on top of it; ``narrow``: one cell; ``low``: before it;
    ``deep``: before it and a row further down, where its snout is."""
    snout: int = 1
    """How far it reaches forward of the head."""
    ears: int = 1
    """Height of its ears; none for 0."""
    tail: Literal["up", "out", "none"] = "up"
    """``up``: it stands on the back; ``out``: it reaches to the rear."""
    tail_length: int = 1
    trunk: bool = False
    """An elephant's, from the head down to the floor."""
    horn: Literal["none", "pair", "antlers", "one"] = "none"
    carapace: int = 0
    """Length of what lies on its back, as wide as that."""
    humps: bool = False
    """A camel's two, with a dip before each."""
    woolly: bool = False
    """A sheep's back is round: its corners are cut."""
    mane: bool = False
    """A lion's: its head is larger by a row above and below."""
    splayed: bool = False
    """A turtle's: legs stand beside its body, each under a flipper, and its head is narrow."""
    crest: bool = False
    """A unicorn's mane, behind its head."""


ANIMALS: dict[str, tuple[tuple[str, ...], Measures]] = {
    "dog": (("dog", "puppy", "wolf", "fox", "hound"), Measures()),
    "cat": (
        ("cat", "kitten", "tiger", "leopard", "panther", "cheetah", "squirrel"),
        Measures(snout=0, tail_length=3),
    ),
    "horse": (
        ("horse", "pony", "donkey", "zebra", "foal", "mule"),
        Measures(neck=1, head="narrow", ears=0, tail="out"),
    ),
    "unicorn": (
        ("unicorn",),
        Measures(head="narrow", ears=0, crest=True, horn="one", tail="out"),
    ),
    "deer": (
        ("deer", "reindeer", "moose", "elk", "stag", "goat"),
        Measures(tail="out", horn="antlers", ears=0),
    ),
    "cow": (
        ("cow", "bull", "ox", "buffalo", "calf"),
        Measures(legs=1, belly=2, head="low", snout=0, ears=0, horn="pair", tail="out"),
    ),
    "sheep": (
        ("sheep", "lamb"),
        Measures(legs=1, belly=2, head="narrow", ears=0, tail="none", woolly=True),
    ),
    "pig": (
        ("pig", "piglet", "boar", "hippo", "rhino"),
        Measures(legs=1, belly=2, head="deep"),
    ),
    "elephant": (
        ("elephant", "mammoth"),
        Measures(body=3, legs=1, belly=2, snout=0, ears=0, tail="out", trunk=True),
    ),
    "giraffe": (
        ("giraffe", "okapi"),
        Measures(body=3, legs=2, neck=2, head="narrow", ears=0, tail="out"),
    ),
    "camel": (
        ("camel", "dromedary", "llama", "alpaca"),
        Measures(body=5, neck=1, head="narrow", ears=0, humps=True, tail="none"),
    ),
    "lion": (
        ("lion",),
        Measures(legs=1, ears=0, mane=True, tail="out"),
    ),
    "rabbit": (
        ("rabbit", "bunny", "hare", "kangaroo"),
        Measures(body=3, legs=1, snout=0, ears=2, tail="out"),
    ),
    "dinosaur": (
        ("dinosaur", "brontosaurus", "diplodocus"),
        Measures(body=3, legs=1, neck=3, head="narrow", ears=0, tail="out", tail_length=2),
    ),
    "turtle": (
        ("turtle", "tortoise"),
        Measures(legs=1, head="low", snout=0, ears=0, carapace=2, tail="out", splayed=True),
    ),
}
"""Nouns and measures, by family."""


def _maker(name: str, usual: Measures) -> Callable[[Brief], Design]:
    def animal(brief: Brief) -> Design:
        if not usual.trunk:
            brief.count("legs", 4)
        own = replace(
            usual,
            neck=brief.count("neck", usual.neck) if usual.neck else 0,
            tail_length=brief.count("tail", usual.tail_length) if usual.tail != "none" else 0,
        )
        plain = _cells(own, own.body, own.legs)
        extents = [max(c[axis] for c in plain) + 1 for axis in range(3)]
        width, _, height = brief.size(extents[0], _DEPTH, extents[2], least=(3, 3, 2))
        if extents[2] - own.legs + 1 > brief.grid[2]:
            raise brief.refuse_short("so long a neck", brief.grid[2])
        if extents[0] - own.body + 2 > brief.grid[0]:
            raise brief.refuse_short("so long a tail", brief.grid[2])
        body = max(2, own.body + width - extents[0])
        legs = max(1, own.legs + height - extents[2])
        boxes = tuple(Box(*cell, 1, 1, 1) for cell in sorted(_cells(own, body, legs)))
        return Design(brief.noun or name, boxes)

    animal.__doc__ = f"{with_article(name).capitalize()}, seen from its side."
    return animal


def _cells(it: Measures, body: int, legs: int) -> set[tuple[int, int, int]]:
    """The cells of an animal, its minimum corner at the origin."""
    top = legs + it.belly  # the first layer above its back
    sides, below = ((-1, _DEPTH), legs + 1) if it.splayed else ((0, 2), legs)
    cells = {(x, y, z) for x in (0, body - 1) for y in sides for z in range(below)}
    cells |= {(x, y, z) for x in range(body) for y in range(_DEPTH) for z in range(legs, top)}
    if it.woolly:
        cells -= {(x, y, top - 1) for x in (0, body - 1) for y in (0, 2)}
    cells |= _head(it, top)
    cells |= _tail(it, body, top)
    if it.carapace:
        first = (body - 1) // 2
        cells |= {(first + k, y, top) for k in range(it.carapace) for y in range(_DEPTH)}
    if it.humps:
        cells |= {(x, y, top) for x in {max(1, body - 3), body - 1} for y in range(_DEPTH)}
    left = min(x for x, _, _ in cells)
    return {(x - left, y, z) for x, y, z in cells}


def _head(it: Measures, top: int) -> set[tuple[int, int, int]]:
    """Before or above the front of the body, which begins at x = 0."""
    before = it.head in ("low", "deep")
    at = -1 if before else 0
    level = top - 1 if before else top + it.neck
    cells = {(at, _MID, z) for z in range(top, level)}
    across = (_MID,) if it.head == "narrow" or it.splayed else range(_DEPTH)
    cells |= {(at, y, level) for y in across}
    above = level + 1
    if it.head == "deep":
        level -= 1
        cells |= {(at, y, level) for y in across}
    cells |= {(at - 1 - k, _MID, level) for k in range(it.snout)}
    if it.trunk:
        cells |= {(-1, y, level) for y in range(_DEPTH)}
        cells |= {(-2, _MID, z) for z in range(level + 1)}
    if it.crest:
        cells |= {(at + 1, _MID, level)}
    if it.mane:
        cells |= {(0, y, level + 1) for y in range(_DEPTH)}
        cells |= {(-1, y, z) for y in range(_DEPTH) for z in (level, level + 1)}
        cells |= {(-2, _MID, level)}
    pair = (_MID,) if it.head == "narrow" else (0, 2)
    # Nothing can be pressed onto a head that is one thin row: ears then stand on the shoulders.
    shoulder, over = (0, top) if it.head == "low" else (at, above)
    cells |= {(shoulder, y, over + k) for y in pair for k in range(it.ears)}
    match it.horn:
        case "one":
            cells |= {(at, _MID, above + k) for k in range(2)}
        case "pair":
            cells |= {(shoulder, y, over) for y in pair} | {(at, y, level) for y in range(_DEPTH)}
        case "antlers":
            # Each with points forwards, backwards and outwards, which are held at their side.
            cells |= {(at, y, above) for y in pair}
            cells |= {(at + k, y, above + 1) for y in pair for k in (-1, 0, 1)}
            cells |= {(at, y, above + 1) for y in (-1, _DEPTH)}
    return cells


def _tail(it: Measures, body: int, top: int) -> set[tuple[int, int, int]]:
    rear, back = body, top - 1
    match it.tail:
        case "up":
            return {(rear - 1, _MID, top + k) for k in range(it.tail_length)}
        case "out":
            return {(rear + k, _MID, back) for k in range(it.tail_length)}
        case _:
            return set()


def _takes(measures: Measures) -> Takes:
    """An elephant's trunk reaches the floor, so that its legs cannot be counted there."""
    takes: dict[str, Count | Flag | Sign] = {}
    if not measures.trunk:
        takes["legs"] = Count(4, 4, "It stands on four.")
    if measures.neck:
        takes["neck"] = Count(1, 4, "Height of its neck in parts.")
    if measures.tail != "none":
        takes["tail"] = Count(1, 3, "Length of its tail in parts.")
    return takes


FAMILIES = tuple(
    Family(name, nouns, _maker(name, measures), _takes(measures))
    for name, (nouns, measures) in ANIMALS.items()
)
