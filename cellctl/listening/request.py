"""The request reader: a sentence becomes a Request, by rules and tables, in about a millisecond.

The order decides: control words by exact match first; then corrections by sound; then edits and
questions; then the frames in which people ask for things ("could you build me ..."); then what the
phrase names: a thing, an idea, or nothing in particular; and last whether such a thing is wanted
built, for people want coffee, tickets and a table for two as well.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from cellctl.assembly import Correction, Intent, Request
from cellctl.listening.attributes import read_attributes, read_features, read_glyph, read_signs
from cellctl.listening.commands import spoken_command
from cellctl.listening.dimensions import read_sizes
from cellctl.listening.frames import (
    Frame,
    find_frame,
    is_question,
    is_told,
    plain_words,
)
from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.numbers import DIGITS
from cellctl.listening.phrases import NounPhrase, read_phrase, repair
from cellctl.listening.snapping import snap
from cellctl.listening.understanding.edits import Editing, read_edits
from cellctl.listening.understanding.hints import hints_of, meant_by, object_for, question_of
from cellctl.listening.understanding.interpreter import DEFAULT_SETTING, Setting
from cellctl.listening.understanding.judging import Judgement, acts_at, kind_of
from cellctl.listening.understanding.later import clauses_of, readings, readings_of_edits
from cellctl.listening.understanding.policy import refusal_of
from cellctl.listening.understanding.wanting import Verdict, is_wanted
from cellctl.listening.understanding.words import look_up

_TRY = 'Try "a simple stool" or "a shelf with two tiers".'
_TOKEN = re.compile(r"\d+(?:\.\d+)?|[a-z]+(?:'[a-z]+)?")
_PERCENT = re.compile(r"(?<=\d) ?%")
_DECIMAL_COMMA = re.compile(r"\b(\d{1,3}),(\d{1,2})\b")
_SUFFIXED_FIGURE = re.compile(r"(\d)(cm|mm|m|ft)\b")
_HUMMING = re.compile(r"u+h+m*|u+m+|e+r+m+|e+h+m+|a+h+m+|h+m{2,}|m+h+m+|u+r+m+")
"""However a recogniser spells that somebody thinks."""
_SLURRED = {"lemme": "let me", "gonna": "going to", "gotta": "have to", "d'you": "do you",
            "dya": "do you", "wouldja": "would you", "couldja": "could you", "whatcha": "what you",
            "y'all": "you", "'em": "them", "bout": "about",
            "pls": "please", "plz": "please", "what'd": "what would", "that'd": "that would",
            "there'd": "there would", "kinda": "kind of", "sorta": "sort of", "whit": "with",
            "wit": "with", "wiv": "with", "fourty": "forty", "ninty": "ninety"}  # fmt: skip
_STUTTER = re.compile(r"\b((?!\w+ by\b|by\b)[a-z']+(?: (?!by\b)[a-z']+){1,2})(?: \1\b)+")
"""Two or three words said again: ``I want, I want a ship``; no "twenty by twenty by twenty"."""
_GOT_TO = re.compile(r"(?:(?<=\w)'s| has| have|(?<=\w)'ve) got to\b")
_WANNA = re.compile(r"\bwanna (\w+)")
_STYLE = re.compile(
    r"(?:[,.;] *(?:low poly|(?:\w+ )?aerial view|studio lighting|(?:high|highly) \w+|very \w+|"
    r"white background|product photography|3d render|photorealistic|realistic|(?:seen|viewed) from "
    r"[\w ]+|trending on [\w ]+|[48]k))+[,. ]*$",
    re.IGNORECASE,
)
"""What is said to generators of pictures after the object."""
_SIGNS = frozenset({"initial", "letter", "number", "digit"})
_WHICH_SIGN = "Which letter or digit shall it be?"
_AS_IN = (("for",), ("as", "in"), ("like", "in"))
"""``m for mother``."""
_BEFORE_DIGITS = frozenset({"a", "an", "the", "big", "large", "huge", "giant", "nice", "great"})
_MOST_CHARACTERS = 600
"""What is longer was not said to a cell; it bounds the time that reading takes."""


@dataclass(frozen=True)
class _Heard:
    """A sentence on its way: as it came, as words, and what was corrected."""

    text: str
    words: tuple[str, ...]
    changes: tuple[Correction, ...]


def read_request(text: str, setting: Setting = DEFAULT_SETTING) -> Request:
    """Understand one sentence.

    Args:
        text: as heard or typed, in English.
        setting: the cell.

    Returns:
        A request; its ``reason`` says, for the visitor, why it is none or what was corrected.
    """
    if not text.strip():
        return _none(text, "I heard nothing.", "there are no words")
    if (command := spoken_command(text)) is not None:
        return Request(
            text=text,
            intent=Intent.CONTROL,
            phrase="false",
            command=command,
            reason=f"That is the command {command!r}.",
            why="it is word for word a command",
        )
    if len(text) > _MOST_CHARACTERS:
        return _none(text, f"That was too long for me. {_TRY}", "it is too long")
    said = _STYLE.sub("", text)
    snapped = snap(tokens(said))
    heard = _Heard(text, tuple(repair(snapped.words)), tuple(snapped.changes))
    request = _as_a_whole(heard, setting)
    if request.intent in (Intent.NONE, Intent.QUERY):
        return _reread(heard, said, setting) or request
    return request


def _as_a_whole(heard: _Heard, setting: Setting) -> Request:
    plain = tuple(plain_words(heard.words))
    if (editing := read_edits(plain, setting.pitch_m)) is not None:
        return _edit(heard, editing, setting.pitch_m)
    frame = find_frame(heard.words)
    if not frame.asks and is_question(plain):
        return Request(
            text=heard.text,
            intent=Intent.QUERY,
            phrase="false",
            reason=f"That is a question; I build what I am asked for. {_TRY}",
            confidence=0.9,
            why="it begins as a question does",
        )
    if not frame.asks and is_told(plain):
        return _none(heard.text, _no_wish(), "it tells what somebody does or did")
    return _design(heard, frame, setting)


def _reread(heard: _Heard, said: str, setting: Setting) -> Request | None:
    """The wish in a sentence that says something else as well; None where there is none."""
    clauses = [repair(snap(tokens(clause)).words) for clause in clauses_of(said)]
    for editing in readings_of_edits(heard.words, clauses, setting.pitch_m):
        return _edit(heard, editing, setting.pitch_m)
    for reading in readings(heard.words, clauses):
        frame = find_frame(reading.words)
        if not frame.asks and (reading.asks or is_question(reading.words)):
            continue
        if not frame.asks and is_told(reading.words):
            continue
        request = _design(heard, frame, setting, reading.more)
        if request.intent is Intent.DESIGN:
            return request
    return None


def tokens(text: str) -> list[str]:
    """Lower-case words and figures, without stutters; hyphens part words, figures and units."""
    plain = text.lower().replace("’", "'").replace("½", " half")  # noqa: RUF001
    plain = _PERCENT.sub(" percent", _DECIMAL_COMMA.sub(r"\1.\2", plain))
    words = _TOKEN.findall(_SUFFIXED_FIGURE.sub(r"\1 \2", plain))
    words = ["um" if _HUMMING.fullmatch(word) else _SLURRED.get(word, word) for word in words]
    once = [w for i, w in enumerate(words) if i == 0 or w != words[i - 1] or not w.isalpha()]
    said = _GOT_TO.sub(" has to", _STUTTER.sub(r"\1", " ".join(once)))
    return _WANNA.sub(_wants, said).split()


def _wants(match: re.Match[str]) -> str:
    """``wanna see`` is "want to see", ``wanna robot`` is "want a robot"."""
    entry = look_up(match[1])
    if match[1] in LEXICON.determiners:
        return f"want {match[1]}"
    return f"want {'to' if entry is not None and entry.parts[:1] == 'v' else 'a'} {match[1]}"


def _design(heard: _Heard, frame: Frame, setting: Setting, more: tuple[str, ...] = ()) -> Request:
    """The object that a wish names; ``more`` tells of its parts and sizes only."""
    wish = _spell_out(frame.rest)
    if purpose := object_for(wish):
        # What it is for leaves no doubt about what it is.
        wish = ("a", *purpose.split())
    if (signs := read_signs(wish)) and (request := _signs(heard, wish, signs)) is not None:
        return request
    sizes = read_sizes(wish, setting.pitch_m)
    phrase = read_phrase(wish, sizes.spans)
    if phrase is not None and phrase.determiner and (doing := acts_at(phrase.core)) is not None:
        # "a goat drinking beer" is a goat.
        before = next(i for i in range(len(wish)) if wish[i : i + len(phrase.core)] == phrase.core)
        phrase = read_phrase(wish[: before + doing], sizes.spans)
    if phrase is None:
        return _none(heard.text, _no_wish(), "it has no noun phrase", ask=_meant(frame))
    verdict = is_wanted(phrase, frame, has_glyph=read_glyph(wish) is not None)
    if not verdict.wanted:
        return _unwanted(heard, frame, phrase, verdict)
    head = phrase.objects[0]
    if more:
        sizes = read_sizes((*wish, *more), setting.pitch_m)
    attributes = read_attributes((*wish, *more), head)
    return Request(
        text=heard.text,
        intent=Intent.DESIGN,
        phrase=phrase.text,
        objects=phrase.objects,
        kind=kind_of(head),
        count=phrase.count,
        attributes=attributes,
        features=read_features(phrase.text),
        dimensions_m=sizes.metres,
        dimension_sources=sizes.sources,
        hints=hints_of(head, phrase.count, sizes.metres, attributes, setting),
        ask=question_of(phrase.objects, phrase.count, either=phrase.either),
        refusal=refusal_of((*wish, *more), head),
        corrections=heard.changes,
        reason=_corrections(heard),
        confidence=_confidence(frame, verdict.judgement),
        why=f"{_asked(frame)}; {verdict.why}",
    )


def _signs(heard: _Heard, wish: tuple[str, ...], signs: tuple[str, ...]) -> Request | None:
    """Several letters: one is built at a time, and the first is asked for first."""
    words = [word for word in wish if word not in LEXICON.determiners or len(word) == 1]
    text = " ".join(words).removesuffix(" please")
    noun = singular(words[0])
    if refusal := refusal_of(words, words[-1]):
        noun = words[-1]
    return Request(
        text=heard.text,
        intent=Intent.DESIGN,
        phrase=text,
        objects=(noun,),
        count=1 if noun == "word" or refusal else len(signs),
        attributes={"glyph": signs[0]},
        hints=("too_many",),
        ask=f"I build one letter at a time. Shall I begin with the {signs[0]}?",
        refusal=refusal,
        corrections=heard.changes,
        reason=_corrections(heard),
        confidence=0.9,
        why="it names letters to be built",
    )


def _unwanted(heard: _Heard, frame: Frame, phrase: NounPhrase, verdict: Verdict) -> Request:
    physical = verdict.judgement.physical
    if physical is False and verdict.abstract:
        reason = (
            f'I can build things to touch, and "{phrase.text}" is none that I know. '
            f"Please say it as an object. {_TRY}"
        )
    else:
        reason = _no_wish()
    no_sign = phrase.objects[0] in _SIGNS and len(phrase.core) == 1 and not phrase.rest
    ask = _WHICH_SIGN if no_sign else _meant(frame)
    return _none(heard.text, reason, f"{_asked(frame)}; {verdict.why}", ask=ask)


def _asked(frame: Frame) -> str:
    return {
        "making": "it asks for something to be made",
        "having": "it says that something is wanted",
        "bare": "it is a phrase that stands alone",
    }[frame.kind]


def _meant(frame: Frame) -> str:
    """What may be meant by "something to sit on"."""
    if set(frame.rest[:1]) & LEXICON.vague or frame.rest[:2] in (("a", "thing"), ("a", "place")):
        return meant_by(frame.rest)
    return ""


def _spell_out(wish: tuple[str, ...]) -> tuple[str, ...]:
    """``a t`` is the letter T, ``a big zero`` the number 0."""
    if wish == ("double", "u"):
        return ("the", "letter", "w")
    if len(wish) > 2 and len(wish[0]) == 1 and wish[1:-1] in _AS_IN and wish[-1] != "one":
        return ("the", "letter", wish[0])
    if len(wish) > 1 and wish[-1] in DIGITS and set(wish[:-1]) <= _BEFORE_DIGITS:
        return ("the", "number", wish[-1])
    alone = len(wish) > 1 and len(wish[-1]) == 1 and set(wish[:-1]) <= {"a", "an", "the", "big"}
    return (*wish[:-1], "letter", wish[-1]) if alone else wish


def _edit(heard: _Heard, editing: Editing, pitch_m: float) -> Request:
    """``make it taller``; in ``make it a bench`` the new object is named."""
    sizes = read_sizes(editing.replacement, pitch_m)
    named = read_phrase(editing.replacement, sizes.spans) if editing.replacement else None
    if editing.replacement:
        frame = Frame("making", editing.replacement)
        glyph = read_glyph(editing.replacement) is not None
        if named is None or not is_wanted(named, frame, has_glyph=glyph).wanted:
            return _none(heard.text, _no_wish(), "what it shall become is no object")
    return Request(
        text=heard.text,
        intent=Intent.EDIT,
        phrase=named.text if named else "false",
        objects=named.objects if named else (),
        kind=kind_of(named.objects[0]) if named else "",
        count=named.count if named else 0,
        attributes=read_attributes(editing.replacement, named.objects[0]) if named else {},
        dimensions_m=sizes.metres,
        dimension_sources=sizes.sources,
        edits=editing.edits,
        refusal=refusal_of(editing.replacement, named.objects[0]) if named else "",
        corrections=heard.changes,
        reason="That changes an object that was designed before; please say the whole wish, "
        'such as "a tall stool".',
        confidence=0.9,
        why="every clause of it changes a size, a part, a colour or the object",
    )


def _none(text: str, reason: str, why: str, ask: str = "") -> Request:
    return Request(
        text=text,
        intent=Intent.NONE,
        phrase="false",
        reason=f"{reason} {ask}".strip(),
        ask=ask,
        confidence=0.9,
        why=why,
    )


def _no_wish() -> str:
    return f"I heard no wish for an object in that. {_TRY}"


def _confidence(frame: Frame, judgement: Judgement) -> float:
    certain = {"making": 1.0, "having": 0.95, "bare": 0.9}[frame.kind]
    return round(certain * judgement.confidence, 2)


def _corrections(heard: _Heard) -> str:
    changed = ", ".join(f'"{change.heard}" as "{change.taken}"' for change in heard.changes)
    return f"I understood {changed}." if changed else ""
