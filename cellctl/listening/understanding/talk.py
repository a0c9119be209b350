"""The guard: talk that names a thing and yet wants nothing built."""

from __future__ import annotations

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from typing import Any

from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.understanding.words import look_up


@dataclass(frozen=True)
class Talk:
    """The words of ``talk.toml``."""

    served: frozenset[str]
    written: frozenset[str]
    elsewhere: frozenset[str]
    figures: frozenset[str]
    times: frozenset[str]
    places: frozenset[str]
    weapons: frozenset[str]
    harmless: frozenset[str]
    insults: frozenset[str]
    unwanted_compounds: dict[str, str]
    """``weapon`` or ``insult`` by compound."""
    affordances: dict[str, str]
    small: frozenset[str]
    big: frozenset[str]


@lru_cache(maxsize=1)
def talk() -> Talk:
    """The words, read once."""
    source = files("cellctl.listening.understanding").joinpath("talk.toml")
    table: dict[str, Any] = tomllib.loads(source.read_text(encoding="utf-8"))

    def words(section: str, key: str = "nouns") -> frozenset[str]:
        return frozenset(table[section][key].split())

    def compounds(section: str) -> list[str]:
        return [" ".join(each.split()) for each in table[section]["compounds"].split("|")]

    return Talk(
        served=words("served"),
        written=words("written"),
        elsewhere=words("elsewhere", "words"),
        figures=words("figures"),
        times=words("elsewhere", "times"),
        places=words("elsewhere", "places"),
        weapons=words("weapons"),
        harmless=words("weapons", "harmless"),
        insults=words("insults"),
        unwanted_compounds={
            **dict.fromkeys(compounds("weapons"), "weapon"),
            **dict.fromkeys(compounds("insults"), "insult"),
        },
        affordances=dict(table["affordances"]),
        small=words("sizes", "small"),
        big=words("sizes", "big"),
    )


FURNISHING = frozenset(
    {"stand", "rack", "holder", "footstool", "wardrobe", "dresser", "nightstand"}
)
"""Furniture that no family of designs is called after."""
_EDIBLE = frozenset("ds")
_PEOPLE = frozenset({"one", "two", "three", "four", "five", "six", "eight", "1", "2", "4", "6"})
_AFTER_PEOPLE = frozenset({"by", "at", "in", "on", "near", "outside", "inside"})
_SERVED_KINDS = frozenset({"rental", "credit", "debit", "aisle", "boarding", "savings", "checking"})
_SCENES = (["in", "a"], ["on", "a"], ["under", "a"], ["in", "an"], ["with", "a"])
_DRINKS = frozenset({"water", "wine", "beer", "coffee", "tea", "milk", "juice", "soda", "whiskey",
                     "champagne", "lemonade", "cola"})  # fmt: skip
_WAYS = (["to", "go"], ["by", "the"], ["to", "the"])
_EXISTING = frozenset({"the", "my", "your", "our", "his", "her", "their", "its", "this", "that",
                       "these", "those"})  # fmt: skip


def served_instead(  # noqa: PLR0911 - one way out a reason
    head: str, core: Sequence[str], rest: Sequence[str], determiner: str, *, asked: bool
) -> str:
    """Why a phrase is a wish for a service or an errand rather than for an object.

    Args:
        head: the phrase's noun, singular.
        core: the words up to it, without the article.
        rest: what follows them in the sentence.
        determiner: the word before the core, or "".
        asked: whether the sentence said that it is wanted; it did not say "make".

    Returns:
        In words for whoever looks into it; empty when it may well be an object.
    """
    words = talk()
    after = list(rest)
    around = set(after)
    # "A flamingo in a zoo" and "a star on a christmas tree" tell of no errand.
    scene = not asked and determiner in ("a", "an") and after[:2] in _SCENES
    if (around & words.times or around & words.places) and not scene:
        return "it names a time or a place, as errands do"
    # "A step ladder for the library" is no errand.
    for_a_room = after[:1] == ["for"] and (
        (not asked and after[1:2] == ["the"] and LEXICON.is_physical(head))
        or (set(after[1:2]) & (_EXISTING | {"a"}) and head in LEXICON.families | FURNISHING)
    )
    named = around | {singular(word) for word in around}
    if named & words.elsewhere and not for_a_room and not scene:
        return "it speaks of services"
    seats = head in LEXICON.families - {"table"}
    if (
        not seats
        and after[:1] == ["for"]
        and set(after[1:2]) & _PEOPLE
        and set(after[2:3]) & _AFTER_PEOPLE
    ):
        return "it reserves a place for people"
    if after[:3] == ["by", "the", "window"]:
        return "it reserves a place"
    if after[:2] in _WAYS and (asked or head not in LEXICON.families):
        return "it is an order or a direction"
    if set(core[:-1]) & _SERVED_KINDS or core[-2:] == ("window", "seat"):
        return "such a thing is rented or issued"
    if after[:1] == ["of"] and set(after[1:3]) & _DRINKS:
        return "it is a drink"
    if head in LEXICON.families:
        return ""
    if head in words.served and (asked or determiner not in ("a", "an")):
        return f"a {head} is served or ordered, not built"
    entry = look_up(" ".join([*core[-2:-1], head])) or look_up(head)  # a "coffee maker" is no maker
    if asked and entry is not None and entry.kind in _EDIBLE:
        return f"a {head} is eaten or used up, not built"
    if asked and entry is not None and entry.kind in "pb" and LEXICON.is_physical(head) is not True:
        return f"a {head} is no object"
    if determiner in _EXISTING and asked and not core[0].endswith("est"):
        return f'"{determiner} {head}" exists already'
    return ""
