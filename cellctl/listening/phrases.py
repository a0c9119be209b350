"""The noun phrase of a wish: its words, its head noun, how many, and whether it is a thing."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.numbers import read_number

_REPAIR_MARK = (
    r"(?:(?:no|actually) make (?:it|that)|no wait|wait no|no sorry|sorry|i mean|no|or rather|rather"
    r"|make that)"
)
_NUMBER_REPAIR = re.compile(rf"\b(\w+) (\w+) {_REPAIR_MARK} (\w+) (\w+)\b")
_OBJECT_REPAIR = re.compile(rf"\b(?:a|an|the) [a-z ]+? {_REPAIR_MARK} ((?:a|an|the) \w+)")
_TRAILING = frozenset({"please", "instead", "now", "today", "then", "thanks"})


@dataclass(frozen=True)
class NounPhrase:
    """What a wish names."""

    text: str
    """Lower case, without its article."""
    objects: tuple[str, ...]
    """Head nouns, singular."""
    count: int
    abstract: bool
    """True when it names nothing that can be touched."""


def repair(words: list[str]) -> list[str]:
    """Obey what speakers correct: ``four legs no wait three legs``, ``a shelf no a bench``."""
    text = " ".join(words)
    text = _NUMBER_REPAIR.sub(_keep_later_number, text)
    text = _OBJECT_REPAIR.sub(lambda match: match[1], text)
    return text.split()


def _keep_later_number(match: re.Match[str]) -> str:
    earlier, noun, later, again = match.groups()
    is_count = read_number([earlier], 0) is not None and read_number([later], 0) is not None
    return f"{later} {again}" if is_count and singular(noun) == singular(again) else match[0]


def read_phrase(
    words: Sequence[str], size_spans: Sequence[tuple[int, int]], *, asked: bool
) -> NounPhrase | None:
    """Read the phrase that a wish starts with.

    Args:
        words: the wish, without what asks for it.
        size_spans: ranges of words that state a size; they are no part of the phrase.
        asked: whether the sentence said that something is wanted. A phrase that stands alone must
            have an article or be known.

    Returns:
        None when there is no noun phrase that could be a wish.
    """
    sized = {index for start, end in size_spans for index in range(start, end)}
    kept = [word for index, word in enumerate(words) if index not in sized]
    while kept and kept[-1] in _TRAILING:
        kept.pop()
    count, start, determined = _determiner(kept)
    numeral = _numeral(kept, start) if count > 1 else []
    end = start
    while end < len(kept) and kept[end] not in LEXICON.enders | LEXICON.finite:
        if end > start and read_number(kept, end) is not None and kept[end - 1] not in _GLYPHS:
            break
        end += 1
    core = kept[start:end]
    if core and not core[-1].isalpha() and not (len(core) > 1 and core[0] in _GLYPHS):
        return None
    owned = kept[start - 1 : start] not in ([], ["a"], ["an"], ["the"], ["another"], ["some"])
    if not core or (not asked and (_is_statement(kept, end) or LEXICON.determiners & set(core))):
        return None
    head, tail = _head(core, kept[end:])
    physical = _is_physical(core, head, determined=determined and not owned)
    if not physical and not asked and not determined and _is_unknown(head):
        return None
    others, tail = _others(tail)
    text = " ".join([*numeral, *core, *tail])
    return NounPhrase(
        text=text,
        objects=(head, *others),
        count=count + len(others),
        abstract=not physical,
    )


_GLYPHS = frozenset({"letter", "number", "digit", "numeral", "capital", "figure"})


def _determiner(words: Sequence[str]) -> tuple[int, int, bool]:
    """Count, index of the first word after the determiner, and whether there was one."""
    start, determined = 0, False
    while start < len(words) and words[start] in LEXICON.determiners:
        number = read_number(words, start)
        if number is not None:
            break
        start, determined = start + 1, True
    number = read_number(words, start)
    if number is None:
        return 1, start, determined
    value, end = number
    following = words[end] if end < len(words) else ""
    counts_part = singular(following) in LEXICON.parts and end + 1 < len(words)
    adjective = following.endswith("ed")
    if counts_part or adjective or end >= len(words) or words[end] in LEXICON.enders:
        return 1, start, True  # "a three tier shelf", "a three legged stool", "a seven"
    return max(1, int(value)), end, True


def _numeral(words: Sequence[str], end: int) -> list[str]:
    """The words of the number that ends before ``end``, without an article."""
    start = next(i for i in range(end) if (read_number(words, i) or (0, 0))[1] == end)
    return list(words[start + (words[start] in ("a", "an", "the")) : end])


def _head(core: list[str], rest: Sequence[str]) -> tuple[str, list[str]]:
    """The head noun, and the words after the core that belong to the phrase."""
    nouns = [word for word in core if not (len(word) == 1 and word.isalnum())]
    if core[0] in _GLYPHS and len(core) > 1:
        nouns = ["letter" if core[0] in ("letter", "capital") else "number"]
    if core[0] == "capital" and len(core) > 1:
        core[0] = "letter"
    if core[0] == "word" and len(core) > 1:
        return "word", _with(rest)
    head = singular(nouns[-1] if nouns else core[-1])
    if rest[:1] == ["of"] and head in LEXICON.of_nouns:
        after = list(rest[1:])
        stop = next((i for i, word in enumerate(after) if word in LEXICON.enders), len(after))
        inner = after[:stop]
        if inner:
            return singular(inner[-1]), ["of", *inner, *_with(after[stop:])]
    return head, _with(rest)


def _with(rest: Sequence[str]) -> list[str]:
    """What follows the core: features ("with ...") stay, uses ("for ...", "to ...") go."""
    if rest[:1] not in (["with"], ["without"], ["and"], ["plus"]):
        return []
    stops = (LEXICON.enders | LEXICON.finite | {"make"}) - {"with", "without", "and", "no", "plus"}
    end = next((i for i, word in enumerate(rest) if word in stops), len(rest))
    kept = list(rest[:end])
    while kept and kept[-1] in ("and", "plus", "with"):
        kept.pop()
    return kept


def _others(tail: list[str]) -> tuple[tuple[str, ...], list[str]]:
    """Further objects of "a shelf and a stool"; "a shelf and make it red" has none."""
    if tail[:1] not in (["and"], ["plus"]) or len(tail) < 2:
        return (), tail
    noun = singular(tail[-1])
    if tail[1] in LEXICON.determiners and LEXICON.is_physical(noun):
        return (noun,), tail
    return (), []


def _is_physical(core: list[str], head: str, *, determined: bool) -> bool:
    known = LEXICON.is_physical(head)
    if known is not None:
        return known
    # A noun nobody listed: things take an article ("a waffle iron"), ideas do not ("create ennui"),
    # and what is somebody's ("my mommy") exists already.
    return determined or core[-1] != head


def _is_unknown(head: str) -> bool:
    return LEXICON.is_physical(head) is None


def _is_statement(words: Sequence[str], end: int) -> bool:
    return end < len(words) and words[end] in LEXICON.finite
