"""The ways people ask: which part of a sentence is the wish, and whether it is one at all."""

from __future__ import annotations

import re
from dataclasses import dataclass

from cellctl.listening.lexicon import LEXICON

_VERB = f"(?:{'|'.join(sorted(LEXICON.verbs))})"
_GERUND = f"(?:{'|'.join(sorted(LEXICON.gerunds))})"
_FOR_ME = r"(?: for (?:me|us))?(?: (?:me|us))?"
_VERBS = rf"{_VERB}(?: and {_VERB})*{_FOR_ME}"
_WHO = r"(?:i|we|you|they|he|she|my \w+|our \w+|the \w+)"
_FRAMES = tuple(
    re.compile(pattern)
    for pattern in (
        # "I want you to build", "I would like to have", "my daughter wants"
        rf"{_WHO} (?:would like|'d like|want|wants|need|needs|wish for|could use|would love)"
        rf"(?: you)?(?: to (?:have|{_VERBS}))?",
        rf"(?:i'd|we'd) (?:like|love)(?: you)?(?: to (?:have|{_VERBS}))?",
        rf"(?:can|could|would|will) you {_VERBS}",
        rf"(?:can|could|may) (?:i|we) (?:have|get)(?: you to {_VERBS})?",
        rf"would you mind {_GERUND}{_FOR_ME}",
        r"(?:let me|let us|let's) (?:have|get)",
        rf"(?:let me|let us|let's) {_VERBS}",
        r"(?:i am|i'm|we are|we're) (?:looking for|after)",
        r"(?:is there )?any chance of",
        r"(?:it would|it'd) be (?:great|nice|lovely|good|cool) to have",
        r"(?:how|what) about",
        rf"{_VERBS}",
    )
)
_THINKING = re.compile(r"(?:i think|i guess|i suppose|you know|i mean|now|then|and|so) ")
_EDITS = tuple(
    re.compile(pattern)
    for pattern in (
        r"(?:add|remove|take (?:off|away)|put|attach|delete|lose) .+",
        r"(?:a (?:bit|little)|slightly|much|even|not|less|more|same but) .+",
        r"(?:the )?same .*",
        r"(?:the )?\w+ (?:is|are) (?:too|not) .+",
        r"(?:it|they|that|this) (?:needs?|should|must|has|is|looks?) (?:to )?(?:be |have |too )?.+",
        r"make (?:that|it) (?:one|two|three|four|five|six)",
        r"with .+",
        r"(?:bigger|smaller|taller|wider|shorter|longer|higher|lower|deeper)(?: .*)?",
    )
)
_MAKE_CHANGE = re.compile(r"(?:make|turn|change) (?:it|that|this|them|the \w+) (?P<how>.+)")
_QUESTION_FRAMES = re.compile(
    r"(?:is|are|do|does|did|was|were|have|has) (?:you|it|there|this|that|i) "
)


@dataclass(frozen=True)
class Frame:
    """A sentence split into how it asks and what for."""

    asks: bool
    """True when it says so ("build me ..."); False for a bare phrase."""
    rest: tuple[str, ...]
    """The wish."""
    edits: bool = False
    """True when the wish is to change an object rather than to have one."""


def find_frame(words: tuple[str, ...]) -> Frame:
    """Split off greetings, fillers, politeness and the words that ask."""
    text = " ".join(_without_fillers(words))
    while match := _THINKING.match(text):
        text = text[match.end() :]
    asks, polite = False, text
    for pattern in _FRAMES:
        if match := re.match(rf"{pattern.pattern}(?= |$)", text):
            asks, text = True, text[match.end() :].strip()
            break
    if asks and is_edit(tuple(polite_stripped := _unasked(polite))):
        return Frame(True, tuple(polite_stripped), edits=True)
    rest = tuple(text.split())
    return Frame(asks, rest, edits=not asks and is_edit(rest))


def is_edit(words: tuple[str, ...]) -> bool:
    """Whether a wish changes an object rather than naming one."""
    text = " ".join(words)
    if any(pattern.fullmatch(text) for pattern in _EDITS):
        return True
    if match := _MAKE_CHANGE.fullmatch(text):
        last = match["how"].split()
        article = len(last) > 1 and last[0] in ("a", "an")
        compares = last[0] in LEXICON.comparatives or last[-1] in LEXICON.comparatives
        coloured = last[-1] in LEXICON.colours
        return article or compares or coloured
    return False


def is_question(words: tuple[str, ...]) -> bool:
    """Whether a sentence asks for an answer."""
    text = " ".join(words)
    return words[:1] != () and (
        words[0] in LEXICON.questions or _QUESTION_FRAMES.match(text) is not None
    )


def _without_fillers(words: tuple[str, ...]) -> list[str]:
    kept = list(words)
    while kept and kept[0] in LEXICON.greetings:
        kept = kept[1:]
    return [word for word in kept if word not in LEXICON.fillers]


def _unasked(text: str) -> list[str]:
    """The sentence without "can you": what is left of an edit starts with its own verb."""
    return re.sub(r"^(?:can|could|would|will) you ", "", text).split()
