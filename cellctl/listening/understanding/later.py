"""Further readings of a sentence that as a whole is no wish: people think aloud and give reasons.

``it's for my daughter, so I guess a horse would be great`` asks in its last clause; ``um, quick, a
chair`` is a chair behind what is said around a wish; ``she loves dinosaurs, can you build her one``
names in one clause what the other asks for.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from cellctl.assembly import Edit
from cellctl.listening.contractions import spelled_out
from cellctl.listening.frames import (
    MAKES,
    POLITE,
    WANT,
    WHO,
    WOULD_DO,
    find_frame,
    plain_words,
)
from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.numbers import read_number
from cellctl.listening.understanding.asides import without_asides
from cellctl.listening.understanding.edits import Editing, read_edits
from cellctl.listening.understanding.judging import judge
from cellctl.listening.understanding.likely import wished as likely
from cellctl.listening.understanding.mentioned import mentioned
from cellctl.listening.understanding.recasting import recast
from cellctl.listening.understanding.words import look_up

_ONE = r"(?=(?:an?|some|another|two|three|four|five|the (?:letter|number)) )"
_ANCHOR = re.compile(
    r"\b(?:"
    rf"{POLITE} {MAKES} |"
    rf"{WHO} ?{WANT} {_ONE}|"
    rf"(?:can|could|may|might) (?:i|we) (?:please )?(?:have|get|see|ask for) {_ONE}|"
    rf"(?:let's|let us) (?:have|try|do|go (?:for|with)|{MAKES}) {_ONE}|"
    rf"it (?:really )?(?:needs|could use|could do with) {_ONE}|"
    rf"(?:how|what) about {_ONE}|"
    rf"(?:ask|asking) (?:it|him|the robot|you) for {_ONE}|"
    rf"(?:so |then |and |please )?{MAKES} {_ONE})"
)
"""What asks for an object wherever it stands; what is weaker must begin a clause."""
_GOVERNS = frozenset(
    {"to", "how", "if", "that", "when", "where", "what", "why", "who", "said", "says", "not", "no",
     "don't", "didn't", "can't", "won't", "never", "you", "i", "we", "they", "he", "she", "it",
     "do", "does", "did", "can", "could", "would", "should", "will", "think", "know", "whether",
     "because", "helped", "watched", "saw", "let", "robots", "people", "a", "an", "the", "or",
     "until", "before", "after", "while", "unless", "things", "thing", "asked", "told"}
)  # fmt: skip
"""After these a clause tells or depends, and asks for nothing."""
_PRAISED = re.compile(rf"\b(?:an?|some|any) (?:\w+ ){{1,3}}(?:{WOULD_DO})\b")
_THEREFORE = re.compile(
    r"\b(?:so|then|but|therefore|ah|aha|yes|yeah|i know|i've got it|i mean) (?:maybe |perhaps |"
    r"just |i guess )*(?=(?:an?|the) )"
)
_ONE_OF_THEM = re.compile(
    r"(?P<ask>.+? )(?:one|some)(?: (?:of (?:those|these|them)|like that|too))?"
    r"(?: for (?:him|her|me|us|them|(?:my|our|the) \w+))?"
)
_SEARCHING = re.compile(
    r"\b(?:what's (?:it|that) called|what's the word|what do you call it|(?:how|what) (?:do "
    r")?you (?:say|call)"
    r"(?: it| that)?|i don't know|i dunno|let me (?:think|see)|you know(?: what i mean)?|how shall "
    r"i put it|the thingy)(?: |$)"
)
_SAID_TWICE = re.compile(r"\b(an?|the|one of (?:those|these)) (?:an?|the) |\ban? (?=one of)")
_LIKE = re.compile(r"(?:something|anything) like ")
_BEGIN_FEATURES = frozenset({"with", "without", "no", "about", "half", "say", "and", "nothing"})
_SHOWS = re.compile(r"(?:\w+ )?(?:look|see|watch)\b(?! for)")
"""Who shows somebody a tower wants none."""
_POINTS_BACK = re.compile(r"\b(?:it|that|this|them|one|the \w+)\b")
_AT_LAST = re.compile(
    r"(?<= )(?:make|turn|set|paint) (?:it|them|that|this)\b|(?<= )give it\b|"
    r"(?<= )(?:take|leave) (?:it|them|that|one) (?:off|away|out)\b|(?<= )(?:add|remove) "
)
"""Where a change begins that follows what was said about the object, without a pause."""
_BREAKS = re.compile(r"[.!?;:\u2026]+(?!\d)|,(?!\d)|\s[-\u2013\u2014]+\s")


@dataclass(frozen=True)
class Reading:
    """A way to take a sentence."""

    words: tuple[str, ...]
    """The part of it that may be the wish."""
    more: tuple[str, ...] = ()
    """What follows it, which may tell more of the object: ``four tiers``."""
    asks: bool = True
    """Whether it counts only when it says that something is wanted."""


def clauses_of(text: str) -> list[str]:
    """What punctuation parts; recognisers often give none."""
    return [clause for clause in _BREAKS.split(text) if clause and clause.strip()]


def readings(words: Sequence[str], clauses: Sequence[Sequence[str]]) -> Iterator[Reading]:
    """Ways to take a sentence, the likeliest first.

    Args:
        words: all of it, lower case.
        clauses: the same, parted where punctuation was heard or typed.
    """
    text = " ".join(plain_words(tuple(words)))
    bare = without_asides(text)
    shown = _SHOWS.match(text) is not None
    if bare != text:
        yield Reading(tuple(bare.split()), asks=shown)
    plain = [without_asides(" ".join(plain_words(tuple(clause)))) for clause in clauses]
    kept = _without_parentheses(" ".join(clause for clause in plain if clause) or bare)
    if kept not in (text, bare):
        yield Reading(tuple(kept.split()), asks=shown)
    yield from _of_clauses(plain, clauses, shown=shown)
    for pattern in (_ANCHOR, _PRAISED, _THEREFORE):
        yield from _anchored(bare, pattern)
    yield from _with_please(words)
    if (named := _named_before(bare)) is not None:
        yield named
    for said in dict.fromkeys((bare, spelled_out(bare))):
        for wish in recast(said):
            yield Reading(tuple(wish.split()))
        if (wished := mentioned(said)) is not None:
            yield Reading(("i", "want", *without_asides(" ".join(wished)).split()))
    for mention in likely(text.split()):
        yield Reading(("i", "want", *without_asides(" ".join(mention)).split()))


def readings_of_edits(
    words: Sequence[str], clauses: Sequence[Sequence[str]], pitch_m: float
) -> Iterator[Editing]:
    """Changes that a sentence asks for besides what else it says: ``too wide, cut it down``."""
    text = " ".join(plain_words(tuple(words)))
    bare = without_asides(text)
    if bare != text and (editing := read_edits(tuple(bare.split()), pitch_m)) is not None:
        yield editing
    plain = [without_asides(" ".join(plain_words(tuple(clause)))) for clause in clauses]
    plain = [clause for clause in plain if clause]
    if len(plain) < 2:
        for match in _AT_LAST.finditer(bare):
            editing = read_edits(tuple(bare[match.start() :].split()), pitch_m)
            if editing is not None and not editing.replacement:
                yield editing
                return
        return
    found = [read_edits(tuple(clause.split()), pitch_m) for clause in plain]
    said = [editing for editing in found if editing is not None]
    if len(said) == len(found) and not any(editing.replacement for editing in said):
        yield Editing(_merged([edit for editing in said for edit in editing.edits]))
    elif said and found[-1] is said[-1] and _POINTS_BACK.search(plain[-1]):
        yield said[-1]


def _merged(edits: list[Edit]) -> tuple[Edit, ...]:
    """Each once; "too wide, cut it down" is one change of one size."""
    sized = {edit.direction for edit in edits if edit.op == "scale" and edit.axis is not None}
    kept = [
        edit
        for edit in edits
        if not (edit.op == "scale" and edit.direction in sized)
        or edit.axis is not None
        or edit.attribute
        or edit.part
    ]
    return tuple(dict.fromkeys(kept))


def _of_clauses(
    plain: Sequence[str], clauses: Sequence[Sequence[str]], *, shown: bool
) -> Iterator[Reading]:
    if len(plain) < 2:
        return
    for index in reversed(range(len(plain))):
        more = tuple(word for clause in plain[index + 1 :] for word in clause.split())
        yield Reading(tuple(plain[index].split()), more)
    for index, clause in enumerate(plain):
        # A thing that stands alone is wanted when nothing else is said, or when a hesitation or a
        # "so" leads to it.
        others = [each for at, each in enumerate(plain) if at != index and each]
        told = [each for at, each in enumerate(others) if not _is_feature(each)]
        vague = any(_asks_for_anything(each) for each in others)
        asided = len(clause.split()) < len(clauses[index]) or index + 1 < len(plain)
        led = not any(plain[index + 1 :]) and (vague or asided or _LIKE.match(clause) is not None)
        if clause and not shown and (not told or led):
            more = tuple(word for each in plain[index + 1 :] for word in each.split())
            yield Reading(tuple(clause.split()), more, asks=False)


def _without_parentheses(text: str) -> str:
    """Less what is said while looking for a word: ``a, what's it called, a lighthouse``."""
    return _SAID_TWICE.sub(
        lambda match: f"{match[1]} " if match[1] else "", _SEARCHING.sub(" ", text)
    ).strip()


def _asks_for_anything(clause: str) -> bool:
    """Whether it asks for "something", which the next clause names."""
    frame = find_frame(tuple(clause.split()))
    return bool(set(frame.rest[:1]) & LEXICON.vague)


def _is_feature(clause: str) -> bool:
    """Whether a clause only tells more of a thing: ``four tiers``, ``half a metre wide``."""
    words = clause.split()
    begins = words[0] in _BEGIN_FEATURES or read_number(words, 0) is not None
    return len(words) <= 6 and (begins or all(_describes(word) for word in words))


def _describes(word: str) -> bool:
    entry = look_up(word)
    return word in LEXICON.comparatives or (entry is not None and entry.parts[:1] == "a")


def _anchored(text: str, pattern: re.Pattern[str]) -> Iterator[Reading]:
    for match in reversed(list(pattern.finditer(text))):
        before = text[: match.start()].split()
        if not before or before[-1] in _GOVERNS:
            continue
        wish = text[match.start() :] if pattern is not _THEREFORE else text[match.end() :]
        yield Reading(tuple(without_asides(wish).split()), asks=pattern is not _THEREFORE)


def _with_please(words: Sequence[str]) -> Iterator[Reading]:
    """``we have waited so long so a simple table please``: "please" asks for what stands before."""
    for index in reversed(range(1, len(words) - 1)):
        if words[index] not in ("a", "an"):
            continue
        before = look_up(words[index - 1])
        governed = words[index - 1] in LEXICON.enders - {"so"} or (
            before is not None and before.parts[:1] == "v"
        )
        if words[index - 1] == "please" or (words[-1] == "please" and not governed):
            yield Reading(tuple(word for word in words[index:] if word != "please"), asks=False)


def _named_before(text: str) -> Reading | None:
    """``she loves dinosaurs can you build her one``: one dinosaur."""
    match = _ONE_OF_THEM.fullmatch(text)
    if match is None:
        return None
    words = match["ask"].split()
    for index in reversed(range(len(words))):
        noun = singular(words[index])
        if noun == words[index] or not judge((noun,), noun).physical:
            continue
        before = look_up(words[index - 1]) if index else None
        # "Grandfather clocks", but "loves dinosaurs".
        named = f"{words[index - 1]} {noun}" if before and before.parts[:1] in "na" else noun
        for anchor in (MAKES, r"(?:have|get|see)"):
            if re.search(rf"\b{anchor}(?: |$)", " ".join(words[index + 1 :])):
                return Reading(("make", "a", *named.split()))
    return None
