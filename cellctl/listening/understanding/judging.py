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
                   "backwards", "sideways", "north", "south", "east", "west", "out", "off", "away",
                   "tall", "still", "open"})  # fmt: skip
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
    judged = _by_compound(core, head) or _by_company(core, head, kind)
    if judged is not None:
        return judged
    if (entry is None or not entry.noun) and core and (plural := look_up(core[-1])) is not None:
        entry = plural  # there is no "goggle"
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


def _by_compound(core: Sequence[str], head: str) -> Judgement | None:
    """What the table says of its last two or three words together."""
    for size in (3, 2):
        # A "round table" is a meeting to WordNet, and to nobody who wants one built.
        if len(core) < size or (head in LEXICON.families and core[-2] in _SHAPES):
            continue
        if core[-2] in LEXICON.colours and LEXICON.is_physical(head):
            continue  # a "silver spoon" is a spoon
        compound = " ".join([*core[-size:-1], head])
        found = look_up(compound) or look_up(" ".join(core[-size:]))
        if found is None and size == 2:
            found = look_up("".join([*core[-2:-1], head]))  # a "fork lift" is a forklift
        if found is not None and found.proper and LEXICON.is_physical(head):
            return None  # a "trojan horse" is a name for more than a horse, and a horse
        if found is not None and found.noun:
            return _by_table(compound, found.physical, found.kind, found.class_name)
    return None


def _by_company(core: Sequence[str], head: str, kind: str) -> Judgement | None:
    """Of a noun that says little, such as "set", by the one before it."""
    before = core[-2] if len(core) > 1 else ""
    if head == "unit" and before in _OF_UNITS:
        return Judgement(True, 0.8, "f", f"a {before} unit is furniture")
    if head in ("set", "kit") and before and judge((before,), before).physical:
        return Judgement(True, 0.7, kind, f"it is a set of {before}")
    if head == "piece" and (look_up(before) or _NOTHING).noun:
        return Judgement(True, 0.7, kind, f"{before!r} says of what it is a piece")
    return None


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
    named = singular(words[index - 1])
    before = look_up(named)
    noun_before = (before is not None and before.noun) or LEXICON.is_physical(named)
    last = index + 1 == len(words)
    watering_can = not last and words[index + 1] == "can"
    if not noun_before or LEXICON.is_physical(singular(word)) or watering_can:
        return False
    entry = look_up(word)
    if not last and words[index + 1] in _WAYS and word.endswith(("ing", "ed")):
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
        coloured = not last and words[index + 1] in LEXICON.colours
        return (follows or coloured) and (entry is None or not (last or "n" in entry.parts))
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
        if core[index - 1] in LEXICON.colours or not core[index].endswith("ing"):
            continue  # "a white wedding gown"
        if before is None or before.kind in "ap":
            return index
    return None


def tells(core: Sequence[str]) -> bool:
    """Whether what looks like a noun phrase has a verb in it: ``the tower fell down``."""
    for index, word in enumerate(core):
        entry = look_up(word)
        # A "broken chair" and a "leather bound book" are things; "the tower fell down" is not.
        describes = entry is not None and "a" in entry.parts and index + 1 < len(core)
        past = entry is not None and "p" in entry.parts and not describes
        if index and past and singular(word) != core[-1]:
            return True
        if index and entry is None and word.endswith("ed") and index + 1 < len(core):
            stem = look_up(word[:-2]) or look_up(word[:-1]) or look_up(word[:-3])
            after = look_up(core[index + 1])
            if stem is not None and stem.parts[:1] == "v" and after is None:
                return True
    if LEXICON.is_physical(singular(core[-1])):
        return False  # "bed" is an old past of something, too
    last = look_up(core[-1]) if len(core) > 1 else None
    if last is not None and last.noun and last.physical > _THING and _qualifies(core[-2]):
        return False  # "a red rose"
    if last is not None and last.parts[:1] == "v" and singular(core[-2]) != core[-2]:
        return True  # "the birds fly"
    return last is not None and ("p" in last.parts or "r" in last.parts[:1])


def _qualifies(word: str) -> bool:
    entry = look_up(word)
    return word in LEXICON.colours or (entry is not None and entry.parts[:1] == "a")


def commands(core: Sequence[str]) -> bool:
    """Whether a phrase without an article starts with a verb: ``fix shelf``."""
    first = look_up(core[0])
    return first is not None and first.parts[:1] == "v"
