"""Whether a noun phrase names a thing: by the words of the house first, then by the table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.numbers import read_number
from cellctl.listening.understanding.words import Word, look_up

_NOTHING = Word(0.0, "-", "", proper=False)
_SHAPES = LEXICON.comparatives | {"round", "square", "simple", "plain", "double", "single"}
_OF_UNITS = frozenset({"shelving", "storage", "wall", "tv", "media", "display", "drawer", "kitchen",
                       "corner", "base", "vanity"})  # fmt: skip
_WAYS = frozenset({"left", "right", "up", "down", "upwards", "downwards", "forward", "forwards",
                   "backwards", "sideways", "north", "south", "east", "west"})  # fmt: skip
_THING = 0.5
"""From here on a noun of the table is a thing."""


@dataclass(frozen=True)
class Judgement:
    """What a noun phrase names."""

    physical: bool | None
    """None: nobody knows the noun."""
    confidence: float
    kind: str
    """Class of the noun, as in the table; empty when it is not in there."""
    why: str


def judge(core: Sequence[str], head: str) -> Judgement:  # noqa: PLR0911 - the first that knows
    """Judge a noun phrase by its longest known ending.

    Args:
        core: its words up to the noun, lower case.
        head: its noun, singular.
    """
    entry = look_up(head)
    kind = entry.kind if entry is not None else ""
    for size in (3, 2):
        # A "round table" is a meeting to WordNet, and to nobody who wants one built.
        if len(core) < size or (head in LEXICON.families and core[-2] in _SHAPES):
            continue
        compound = " ".join([*core[-size:-1], head])
        found = look_up(compound) or look_up(" ".join(core[-size:]))
        if found is None and size == 2:
            found = look_up("".join([*core[-2:-1], head]))  # a "fork lift" is a forklift
        if found is not None and found.proper and LEXICON.is_physical(head):
            break  # a "trojan horse" is a name for more than a horse, and a horse
        if found is not None and found.noun:
            return _by_table(compound, found.physical, found.kind, found.class_name)
    if head == "unit" and len(core) > 1 and core[-2] in _OF_UNITS:
        return Judgement(True, 0.8, "f", f"a {core[-2]} unit is furniture")
    if head == "piece" and len(core) > 1 and (look_up(core[-2]) or _NOTHING).noun:
        return Judgement(True, 0.7, kind, f"{core[-2]!r} says of what it is a piece")
    known = LEXICON.is_physical(head)
    if known is not None:
        why = f"{head!r} is listed as {'a thing' if known else 'no thing'}"
        return Judgement(known, 0.95, kind, why)
    if "shaped" in core[:-1]:
        return Judgement(True, 0.8, kind, "what has a shape is a thing")
    if entry is not None and entry.noun:
        return _by_table(head, entry.physical, entry.kind, entry.class_name)
    if entry is not None:
        return Judgement(False, 0.7, "", f"{head!r} is no noun")
    if LEXICON.sounds_abstract(head):
        return Judgement(False, 0.8, "", f"{head!r} ends like an idea")
    return Judgement(None, 0.5, "", f"nothing is known of {head!r}")


def kind_of(noun: str) -> str:
    """What kind of thing a singular noun names, in words; empty for an unknown one."""
    if noun in LEXICON.characters:
        return "character"
    entry = look_up(noun)
    return entry.class_name if entry is not None and entry.noun and not entry.proper else ""


def _by_table(noun: str, physical: float, kind: str, class_name: str) -> Judgement:
    return Judgement(
        physical >= _THING,
        0.5 + abs(physical - _THING) * 0.9,
        kind,
        f"{noun!r} ({class_name}) is a thing by {physical:.0%}",
    )


def is_participle(words: Sequence[str], index: int) -> bool:
    """Whether a word begins what a thing does or was done to: ``a cat wearing a hat``.

    It stands after a noun; a "rocking chair" and a "writing desk" begin with theirs, and a
    "building" is a noun of its own.
    """
    word = words[index]
    before = look_up(singular(words[index - 1]))
    if before is None or "n" not in before.parts or LEXICON.is_physical(singular(word)):
        return False
    entry = look_up(word)
    last = index + 1 == len(words)
    if not last and words[index + 1] in ("out", "up", "off", "down") and word.endswith("ing"):
        return True
    if word in ("shaped", "made", "built", "carved", "filled", "covered", "dressed"):
        return not last and words[index + 1] in ("like", "of", "from", "out", "as", "with", "in")
    follows = last or (
        words[index + 1] in LEXICON.enders | LEXICON.determiners
        or read_number(words, index + 1) is not None
    )
    if word.endswith("ing") and len(word) > 5:
        noun = entry is not None and entry.parts[:1] == "n" and entry.physical > _THING
        ahead = index + 2 == len(words) and words[index + 1] in _WAYS
        return (follows or ahead) and not noun
    if word.endswith("ed") and len(word) > 4:
        return follows and (entry is None or not (last or "n" in entry.parts))
    return False


def acts_at(core: Sequence[str]) -> int | None:
    """Where an animal or a person begins to do something: "a dragon breathing fire"; else None.

    A "dog training ramp" ends in a thing, and so is one.
    """
    if not core or LEXICON.is_physical(singular(core[-1])):
        return None
    for index in range(1, len(core) - 1):
        before = look_up(singular(core[index - 1]))
        if core[index - 1] in LEXICON.determiners:
            continue  # "the leaning tower"
        if core[index].endswith("ing") and (before is None or before.kind in "ap"):
            return index
    return None


def tells(core: Sequence[str]) -> bool:
    """Whether what looks like a noun phrase has a verb in it: ``the tower fell down``."""
    for index, word in enumerate(core):
        entry = look_up(word)
        if index and entry is not None and "p" in entry.parts and singular(word) != core[-1]:
            return True
        if index and entry is None and word.endswith("ed") and index + 1 < len(core):
            stem = look_up(word[:-2]) or look_up(word[:-1]) or look_up(word[:-3])
            after = look_up(core[index + 1])
            if stem is not None and stem.parts[:1] == "v" and after is None:
                return True
    if LEXICON.is_physical(singular(core[-1])):
        return False  # "bed" is an old past of something, too
    last = look_up(core[-1]) if len(core) > 1 else None
    if last is not None and last.parts[:1] == "v" and singular(core[-2]) != core[-2]:
        return True  # "the birds fly"
    return last is not None and ("p" in last.parts or "r" in last.parts[:1])


def commands(core: Sequence[str]) -> bool:
    """Whether a phrase without an article starts with a verb: ``fix shelf``."""
    first = look_up(core[0])
    return first is not None and first.parts[:1] == "v"
