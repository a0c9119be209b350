"""The words of edits: which sizes comparatives change, parts, and amounts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from cellctl.listening.dimensions import UNITS_M
from cellctl.listening.lexicon import LEXICON
from cellctl.listening.numbers import read_number

Direction = Literal["+", "-"]
EditAxis = Literal["width", "depth", "height", "length"]
Unit = Literal["parts", "voxels", "metres", "times"]
Said = Unit | Literal["percent"]

_VOXELS = frozenset(
    {"block", "blocks", "voxel", "voxels", "cube", "cubes", "level", "levels", "brick", "bricks"}
)
_DEGREES = frozenset(
    {"a", "bit", "little", "slightly", "much", "lot", "way", "even", "somewhat", "far", "so", "too",
     "not", "quite", "very", "really", "still", "just", "that", "as", "tad", "touch", "wee", "tiny",
     "smidge", "smidgen", "teeny", "fraction", "whole", "super", "extra", "pretty"}
)  # fmt: skip
_MOST_TAKEN = 0.95
"""Of a size, whatever share is to be taken away."""
_OTHER_PARTS = frozenset(
    {"seat", "top", "roof", "door", "window", "wheel", "handle", "base", "side", "pole", "column",
     "post", "pillar", "head", "tail", "ear", "neck", "wing", "chimney", "row", "block", "voxel",
     "cube", "panel", "divider", "rail", "railing", "cushion", "headboard", "foot", "footrest",
     "floor", "wall", "tower", "beam", "support", "brace", "room"}
)  # fmt: skip
"""Parts that people name and no attribute counts; whether it has them is for the design to say."""


@dataclass(frozen=True)
class Trait:
    """What a comparative changes."""

    axis: EditAxis | None
    direction: Direction
    attribute: str = ""
    """Where it changes no size: ``strength``, ``roundness``, ``weight``, ``simplicity``."""
    amount: float | None = None
    unit: Unit | None = None

    def by(self, direction: Direction, amount: float | None, unit: Said | None) -> Trait:
        """The same that way and by so much; a share becomes a factor."""
        if unit == "percent" and amount is not None:
            share = amount / 100
            factor = 1 + share if direction == "+" else 1 / (1 - min(share, _MOST_TAKEN))
            return replace(self, direction=direction, amount=round(factor, 4), unit="times")
        assert unit != "percent", "a share is of something"
        return replace(self, direction=direction, amount=amount, unit=unit)


def _traits(words: dict[str, tuple[EditAxis | None, Direction]]) -> dict[str, Trait]:
    return {word: Trait(*what) for key, what in words.items() for word in key.split()}


COMPARATIVES = {
    **_traits(
        {
            "taller higher": ("height", "+"),
            "shorter lower flatter": ("height", "-"),
            "wider broader fatter": ("width", "+"),
            "narrower slimmer": ("width", "-"),
            "deeper thicker": ("depth", "+"),
            "thinner shallower": ("depth", "-"),
            "longer": ("length", "+"),
            "bigger larger": (None, "+"),
            "smaller tinier": (None, "-"),
        }
    ),
    **dict.fromkeys(("stronger", "sturdier", "stabler"), Trait(None, "+", "strength")),
    **dict.fromkeys(
        ("nicer", "prettier", "better", "fancier", "cooler", "cuter"), Trait(None, "+", "looks")
    ),
    "steeper": Trait(None, "+", "steepness"),
    "rounder": Trait(None, "+", "roundness"),
    "simpler": Trait(None, "+", "simplicity"),
    "heavier": Trait(None, "+", "weight"),
    "lighter": Trait(None, "-", "weight"),
}
BASES = {
    **_traits(
        {
            "tall high height": ("height", "+"),
            "short low flat": ("height", "-"),
            "wide broad fat width": ("width", "+"),
            "narrow slim": ("width", "-"),
            "deep thick depth": ("depth", "+"),
            "thin shallow": ("depth", "-"),
            "long length": ("length", "+"),
            "big large huge size": (None, "+"),
            "small tiny little": (None, "-"),
        }
    ),
    **dict.fromkeys(("strong", "sturdy", "stable", "solid"), Trait(None, "+", "strength")),
    "steep": Trait(None, "+", "steepness"),
    "heavy": Trait(None, "+", "weight"),
    "light": Trait(None, "-", "weight"),
    "round": Trait(None, "+", "roundness"),
    "square": Trait(None, "-", "roundness"),
    "simple": Trait(None, "+", "simplicity"),
    "weak": Trait(None, "-", "strength"),
    "wobbly": Trait(None, "-", "strength"),
}

VERBS = {
    **_traits(
        {
            "raise heighten": ("height", "+"),
            "lower": ("height", "-"),
            "widen broaden": ("width", "+"),
            "narrow": ("width", "-"),
            "deepen thicken": ("depth", "+"),
            "thin": ("depth", "-"),
            "lengthen extend stretch elongate": ("length", "+"),
            "shorten": ("length", "-"),
            "enlarge double grow expand": (None, "+"),
            "shrink halve reduce": (None, "-"),
        }
    ),
    **dict.fromkeys(("strengthen", "reinforce"), Trait(None, "+", "strength")),
}


@dataclass(frozen=True)
class Part:
    """A part of an object."""

    part: str
    attribute: str
    """What designs call it; empty when no attribute speaks of it."""

    @property
    def counted(self) -> bool:
        """Whether there may be several."""
        return self.attribute not in ("back", "arms", "lid", "chimney")


def part_of(noun: str) -> Part | None:
    """The part that a singular noun names; None for what is no part of an object."""
    if (attribute := LEXICON.parts.get(noun)) is not None and noun != "foot":
        return Part(noun, attribute)
    return Part(noun, "") if noun in _OTHER_PARTS else None


def split_degree(words: Sequence[str]) -> tuple[set[str], list[str]]:
    """``a bit``, ``much``, ``too``, ``not so``, and the words after it."""
    end = 0
    while end < len(words) and words[end] in _DEGREES:
        if words[end] == "a" and read_number(words, end) and words[end + 1] not in _DEGREES:
            break
        end += 1
    return set(words[:end]), list(words[end:])


def amount_of(words: Sequence[str]) -> tuple[float | None, Said | None, list[str]]:
    """``two blocks``, ``ten centimetres``, ``ten percent``, and the words after it."""
    number = read_number(words, 0)
    if number is None and words[:1] in (["a"], ["an"], ["one"]) and len(words) > 1:
        number = (1.0, 1)
    if number is None or number[0] <= 0 or number[1] >= len(words):
        return None, None, list(words)
    unit = words[number[1]]
    rest = list(words[number[1] + 1 :])
    if unit in _VOXELS:
        return number[0], "voxels", rest
    if unit in UNITS_M:
        return round(number[0] * UNITS_M[unit], 4), "metres", rest
    if unit == "percent":
        return number[0], "percent", rest
    return None, None, list(words)


def opposite(direction: Direction) -> Direction:
    """The other way."""
    return "-" if direction == "+" else "+"
