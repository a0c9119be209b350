"""Whether a noun phrase in its sentence is a wish for an object to be built."""

from __future__ import annotations

from dataclasses import dataclass

from cellctl.listening.attributes import GLYPH_NOUNS
from cellctl.listening.frames import Frame
from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.phrases import NounPhrase
from cellctl.listening.understanding.edit_words import COMPARATIVES
from cellctl.listening.understanding.judging import Judgement, commands, judge, tells
from cellctl.listening.understanding.talk import FURNISHING, served_instead, talk
from cellctl.listening.understanding.words import look_up

_MASS = frozenset("dsbpgxktc")
"""Classes of nouns that without an article are no objects: "make dinner", "make friends"."""
_COUNTED = frozenset("afh")
"""Classes of nouns of which one has one."""
_SURE = 0.66
"""Certainty of the table that a phrase needs that has neither an article nor a verb."""
_SOMEBODYS = frozenset({"my", "our", "his", "her", "their", "your", "its"})
_SUBJECTS = frozenset({"that", "which", "who", "whose", "where", "it", "i", "you", "we", "they",
                       "he", "she", "so", "because", "and"})  # fmt: skip
"""What follows these may have a verb of its own."""
_LENT = frozenset({"ride", "lift", "hand", "call", "ring"})
_PRAISE = frozenset({"nice", "good", "cool", "great", "lovely", "cute", "awesome", "amazing",
                     "wonderful", "pretty", "bad", "ugly"})  # fmt: skip
_OBJECTS = frozenset({"it", "me", "us", "them", "him", "her"})
_ASKING = frozenset({"can", "could", "would", "will", "should"})
_POINTING = frozenset({"this", "that", "these", "those"})


@dataclass(frozen=True)
class Verdict:
    """What was decided, and by what."""

    wanted: bool
    judgement: Judgement
    why: str
    abstract: bool = False
    """Whether it names an idea rather than nothing at all."""


def is_wanted(  # noqa: PLR0911, PLR0912 - one way out a reason
    phrase: NounPhrase, frame: Frame, *, has_glyph: bool
) -> Verdict:
    """Judge a phrase.

    Args:
        phrase: what the sentence names.
        frame: how the sentence asks for it.
        has_glyph: whether it names a letter or digit to build.
    """
    head = phrase.objects[0]
    # "a replica of stonehenge" is a replica; "some kind of shelf" is a shelf.
    outer = singular(phrase.core[-1])
    judgement = judge(phrase.core, head if outer in LEXICON.vague else outer)
    if outer in LEXICON.of_nouns and outer != head and not LEXICON.is_physical(outer):
        judgement = judge((head,), head)  # "a bunch of marbles"
    if has_glyph and (frame.kind != "bare" or GLYPH_NOUNS & set(phrase.core)):
        return Verdict(True, judgement, "it names a letter or a digit")
    if {head, phrase.core[-1]} & (talk().weapons | talk().insults):
        return Verdict(True, judgement, "it is a thing, and none to build")
    if head == "word" and len(phrase.core) > 1 and phrase.determiner == "the":
        return Verdict(True, judgement, "it names a word to be spelled")

    def no(why: str, *, abstract: bool = False) -> Verdict:
        return Verdict(False, judgement, why, abstract)

    if frame.kind == "bare" and (why := _no_phrase(phrase)):
        return no(why)
    if head == "number":
        return no("it is a number and does not say which")
    if LEXICON.determiners & set(phrase.core):
        return no("it says what to do with an object")
    if len(head) == 1:
        return no("it is a letter, and does not say so")
    if (phrase.determiner == "the" and _compares(phrase.core[-1])) or head in COMPARATIVES:
        return no("it changes something that exists already")
    plain = len(phrase.core) == 1 and not phrase.rest
    if frame.of_speaker and plain and judgement.kind == "p" and not LEXICON.is_physical(head):
        return no("it is what somebody would like to be")
    if judgement.physical is False or (frame.of_doing and judgement.physical is None):
        return no(judgement.why, abstract=True)
    if head in talk().written and (frame.kind != "bare" or not phrase.determiner):
        return no(f"a {head} is written or drawn, not built")
    if (
        head == "letter"
        and not has_glyph
        and (
            phrase.rest[:1] in (("to",), ("from",), ("about",))
            or (
                len(phrase.core) > 1
                and _is_idea(phrase.core[-2])
                and not _describes(phrase.core[-2])
            )
        )
    ):
        return no("such a letter is written, not built")
    of_idea = phrase.rest[:1] == ("of",) or (phrase.rest[:1] == ("to",) and len(phrase.rest) == 2)
    figure = head in talk().figures and of_idea
    between = phrase.rest[:1] in (("between",), ("among",))
    if (figure or between) and _is_idea(phrase.rest[-1]):
        return no("it is a figure of speech")
    if phrase.rest[-2:] in (("one", "day"), ("some", "day")) or phrase.rest[-1:] == ("someday",):
        return no("it is for another day")
    if phrase.rest[:1] == ("and",) and len(phrase.rest) == 2 and _is_idea(phrase.rest[1]):
        return no("with an idea it makes one, too")  # "a bed and breakfast"
    if frame.kind == "having" and "where" in phrase.rest:
        return no("it asks where something is")
    if head == "machine" and phrase.rest[:1] == ("like",):
        return no("it speaks of this machine")
    if phrase.determiner in _POINTING or (
        phrase.rest[:1] == ("with",) and set(phrase.rest[1:]) <= _POINTING | {"it"}
    ):
        return no("it points at something that is there")
    if frame.kind != "making":
        why = served_instead(
            head, phrase.core, phrase.rest, phrase.determiner, asked=frame.kind == "having"
        )
        if why and not _named(phrase):
            return no(why)
        if frame.kind == "having" and len(phrase.core) > 1 and phrase.core[0] in _LENT:
            return no("it is a favour")
        new = frame.kind == "having" and phrase.core[0] == "new"
        if new and head not in LEXICON.families | FURNISHING:
            return no(f"a new {head} is bought, not built")
    elif why := _idiom(phrase, judgement):
        return no(why)
    if phrase.determiner in _SOMEBODYS:
        return no("it is about something that exists already")
    if not phrase.determiner and (why := _no_article(phrase, frame, judgement)):
        return no(why, abstract=judgement.physical is None)
    return Verdict(True, judgement, judgement.why)


def _idiom(phrase: NounPhrase, judgement: Judgement) -> str:
    """Why what is to be "made" is none the less no object."""
    if phrase.core in (("face",), ("fist",), ("bed",)) and (
        phrase.determiner in ("the", "your") or phrase.core != ("bed",)
    ):
        return "it is said of something else than building"
    if phrase.rest[:1] == ("against",):
        return "nothing is built against somebody"
    if phrase.rest[:2] in (("of", "this"), ("of", "that"), ("of", "these")):
        return "it points at something that is there"
    if phrase.determiner == "some" and judgement.kind in "ds":
        return f"some {phrase.objects[0]} is eaten or used up, not built"
    return ""


def _no_phrase(phrase: NounPhrase) -> str:
    """Why a phrase that stands alone is rather a statement or a command."""
    if phrase.rest[:1] and phrase.rest[0] in LEXICON.finite | _ASKING:
        return "it says something about an object"
    if phrase.rest[:1] and phrase.rest[0] in _OBJECTS and not phrase.determiner:
        return "it says what to do with an object"
    for word in phrase.rest:
        if word in _SUBJECTS or (word == "one" and phrase.rest[0] in ("like", "as")):
            break
        if word in LEXICON.finite:
            return "it says something about an object"
    if phrase.determiner in _SOMEBODYS | _POINTING:
        return "it is about something that exists already"
    if tells(phrase.core):
        return "it says what an object did"
    return ""


def _no_article(  # noqa: PLR0911 - one way out a reason
    phrase: NounPhrase, frame: Frame, judgement: Judgement
) -> str:
    """Why a noun without an article names no object: "make dinner", "flight status"."""
    head = phrase.objects[0]
    if frame.kind == "bare" and phrase.core[0] in _PRAISE and len(phrase.core) > 1:
        return "it praises something that is there"
    if head in LEXICON.families:
        if (
            frame.kind == "bare"
            and phrase.core[0] not in LEXICON.families
            and commands(phrase.core)
        ):
            return "it is a command for something else"
        return ""
    plural = phrase.core[-1] != head
    known = LEXICON.is_physical(head) is True
    entry = look_up(head)
    if head in LEXICON.characters:
        return ""
    if judgement.physical is None and not (frame.kind == "making" and _a_name(phrase.core)):
        return f"nothing is known of {head!r}, and it has no article"
    if judgement.physical is None or _named(phrase):
        return ""
    if frame.kind == "making":
        if judgement.kind in _MASS and not known:
            return f"{head!r} has no article, and is no object without"
        return "" if plural or known or judgement.confidence >= _SURE else judgement.why
    if frame.kind == "having":
        # "I want train" is how children and many a language put it; who wants money has none.
        counted = judgement.kind in _COUNTED and not phrase.rest and head not in talk().served
        return "" if known and (plural or counted) else f"{head!r} has no article"
    if commands(phrase.core) and (len(phrase.core) > 1 or phrase.rest):
        return "it is a command for something else"
    plain = LEXICON.comparatives | {
        "old",
        "little",
        "huge",
        "tiny",
        "giant",
        "nice",
        "simple",
        "new",
    }
    if len([word for word in phrase.core if word not in plain]) > 3 or any(
        _odd(word) for word in phrase.core[:-1]
    ):
        return "its words make no noun phrase"
    if known or (judgement.kind in "afl" and judgement.confidence >= _SURE and entry is not None):
        return ""
    return f"{head!r} alone is not surely an object"


def _describes(word: str) -> bool:
    entry = look_up(word)
    return word in LEXICON.colours or (entry is not None and "a" in entry.parts)


def _is_idea(word: str) -> bool:
    """Whether a noun names no thing."""
    noun = singular(word)
    entry = look_up(noun)
    if entry is not None and entry.kind == "w" and entry.proper:
        return False  # "the tower of pisa"
    return noun not in LEXICON.vague and judge((noun,), noun).physical is False


def _compares(word: str) -> bool:
    """Whether a word is a comparative: ``warmer``."""
    if not word.endswith("er"):
        return False
    stems = [word[:-2], word[:-1], word[:-3], f"{word[:-3]}y"]
    return any((entry := look_up(stem)) is not None and "a" in entry.parts for stem in stems)


def _named(phrase: NounPhrase) -> bool:
    """Whether it is the name of one building or the like: ``the eiffel tower``."""
    core = phrase.core
    return any(
        (entry := look_up(" ".join(core[start:]))) is not None and entry.proper
        for start in range(len(core) - 1)
    )


def _a_name(core: tuple[str, ...]) -> bool:
    """Whether words of which the last is unknown may be somebody's name: ``minecraft steve``."""
    known = look_up(core[-2]) if len(core) == 2 else None
    name = core[-1]
    describes = _compares(name) or name.endswith(("ed", "ing", "ly"))
    return len(core) <= 2 and (known is None or known.noun) and name.isalpha() and not describes


def _odd(word: str) -> bool:
    """Whether a word cannot stand before a noun."""
    entry = look_up(word) or look_up(singular(word))
    return entry is not None and not set(entry.parts) & set("na") and not word.endswith("ing")
