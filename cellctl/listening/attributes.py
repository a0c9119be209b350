"""What a sentence says about an object besides its name: legs, tiers, a back, a glyph, a colour."""

from __future__ import annotations

import re
from collections.abc import Sequence

from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.numbers import read_number

Attributes = dict[str, int | str | bool]

_SWITCHED = frozenset({"back", "arms", "lid", "chimney"})
"""Parts that are there or not; the others are counted."""
_LONG = {"long": 3, "short": 1, "longer": 3, "shorter": 1}
"""Parts of a neck or a tail."""
_LACKING = frozenset({"no", "without"})
_LESS = re.compile(r"(back|arm|lid|leg)less")
_SINGLE = re.compile(
    r"(?:with|on|and|has|having) (?:an?|only|just an?|only an?|the)(?: (?!(?:an?|the)\b)\w+){0,2}$"
)
_JOINTS = re.compile(r" and with | and | with |, ")
_ARTICLE = re.compile(r"^(?:an?|the|some) ")
_LEGGED = frozenset({"legged", "footed"})
_TIERED = frozenset({"tiered", "level", "leveled", "levelled"})
_SEVERAL = re.compile(
    r"(?:(?:the|my|our|his|her|their|two|three|some) )*(?:capital |big )?(?:(?:letters?|numbers?|"
    r"digits?|initials?) (?P<signs>\w+(?:(?: and)? \w+)+)|(?:word|name) (?P<word>[a-z]{2,12}))"
    r"(?: please)?"
)
_WORDS_OF_A_SIGN = frozenset({"a", "i"})
GLYPH_NOUNS = frozenset(
    {"letter", "number", "digit", "numeral", "capital", "figure", "uppercase", "lowercase"}
)


def read_attributes(words: Sequence[str], head: str) -> Attributes:
    """Find what is said of the object; later words correct earlier ones.

    Args:
        words: the whole sentence, lower case, without punctuation.
        head: the object's noun, singular. Only a bookcase's shelves are tiers.
    """
    found: Attributes = {}
    for index, word in enumerate(words):
        if (number := read_number(words, index)) is not None:
            _counted(words, number, head, found)
        part = LEXICON.parts.get(singular(word))
        if part is not None and _SINGLE.search(" ".join(words[max(0, index - 4) : index])):
            _single(word, part, found)
        if part in _SWITCHED and singular(word) != head and _names_a_part(words, index):
            # "no back", "without a back"
            found[part] = not _LACKING & set(words[max(0, index - 2) : index])
        if match := _LESS.fullmatch(word):
            name = LEXICON.parts[match[1]]
            found[name] = False if name in _SWITCHED else 0
        if word in _LONG and singular(" ".join(words[index + 1 : index + 2])) in ("neck", "tail"):
            found[singular(words[index + 1])] = _LONG[word]
        if word == "steep" and list(words[index + 1 : index + 2]) == ["roof"]:
            found["steepness"] = 2
        if word in LEXICON.colours:
            found["colour"] = word
    if (glyph := read_glyph(words)) is not None:
        found["glyph"] = glyph
    return found


def read_features(phrase: str) -> tuple[str, ...]:
    """What a phrase says that a thing has and no attribute counts: ``two sails``, ``floppy ears``.

    Args:
        phrase: the whole of it, lower case.
    """
    _, joint, told = phrase.partition(" with ")
    pieces = _JOINTS.split(told) if joint else []
    found = [_ARTICLE.sub("", piece) for piece in pieces if piece]
    return tuple(piece for piece in found if piece and not _is_read(piece.split()))


def _is_read(words: list[str]) -> bool:
    ends = (i for i, word in enumerate(words) if i and word in LEXICON.enders)
    noun = singular(words[next(ends, len(words)) - 1])
    return noun in LEXICON.parts or noun in LEXICON.colours or words[0] in ("no", "without")


def read_glyph(words: Sequence[str]) -> str | None:
    """The letter or digit of ``letter t``, ``two letters t``, ``number seven``; upper case."""
    for index in range(len(words) - 1):
        name = words[index + 1]
        several = words[index] not in GLYPH_NOUNS
        if singular(words[index]) not in GLYPH_NOUNS or (several and name in _WORDS_OF_A_SIGN):
            continue
        if len(name) == 1 and name.isalnum():
            return name.upper()
        number = read_number(words, index + 1)
        if number is not None and number[0] == int(number[0]) and number[0] < 1000:
            return str(int(number[0]))
    return None


def read_signs(words: Sequence[str]) -> tuple[str, ...]:
    """The letters and digits of ``the letters a and b``, ``my initials j k``, ``the word hi``.

    Upper case; empty where the words name none, or no more than one. ``words`` is the whole wish.
    """
    match = _SEVERAL.fullmatch(" ".join(words))
    if match is None:
        return ()
    if match["word"]:
        return tuple(match["word"].upper())
    signs = [word for word in match["signs"].split() if word != "and"]
    numbers = [read_number([sign], 0) for sign in signs]
    read = [
        str(int(number[0])) if number is not None else sign.upper()
        for sign, number in zip(signs, numbers, strict=True)
    ]
    return tuple(read) if len(read) > 1 and all(len(sign) == 1 for sign in read) else ()


def _counted(words: Sequence[str], number: tuple[float, int], head: str, found: Attributes) -> None:
    """``four legs``, ``three tier``, ``four sturdy legs``, ``three legged``."""
    value, end = number
    if value != int(value):
        return
    for noun in words[end : end + 2]:
        if noun in _LEGGED:
            found["legs"] = int(value)
            return
        if noun in _TIERED:
            found["tiers"] = int(value)
            return
        part = LEXICON.parts.get(singular(noun))
        if part is None:
            continue
        if singular(noun) == "shelf" and head not in (
            "bookcase",
            "shelf",
            "rack",
            "wardrobe",
            "bookshelf",
            "cabinet",
            "cupboard",
        ):
            return
        if singular(noun) == "foot":
            return  # a length; "three feet" are legs to nobody
        found[part] = value > 0 if part in _SWITCHED else int(value)
        return


def _single(word: str, part: str | None, found: Attributes) -> None:
    """``with a drawer`` counts one; ``with a shelf`` says nothing of how many tiers."""
    if part in ("legs", "drawers", "steps") and word == singular(word) and word != "foot":
        found[part] = 1


def _names_a_part(words: Sequence[str], index: int) -> bool:
    """A switched part is meant after "with", "no", "and" and the like, not in "at the back"."""
    before = set(words[max(0, index - 4) : index])
    return bool(before & {"with", "without", "no", "and", "have", "has", "having", "plus"})
