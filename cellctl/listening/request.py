"""The request reader: a sentence becomes a Request, by rules, in well under a millisecond.

The order decides: control words by exact match first; then corrections by sound; then edits and
questions; then the frames in which people ask for things ("could you build me ..."); and last what
the phrase names: a thing, an idea, or nothing in particular.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from cellctl.assembly import Correction, Intent, Request
from cellctl.listening.attributes import read_attributes, read_glyph
from cellctl.listening.commands import spoken_command
from cellctl.listening.dimensions import read_sizes
from cellctl.listening.frames import Frame, find_frame, is_question
from cellctl.listening.phrases import NounPhrase, read_phrase, repair
from cellctl.listening.snapping import snap
from cellctl.listening.understanding.interpreter import DEFAULT_SETTING, Setting

_TRY = 'Try "a simple stool" or "a shelf with two tiers".'
_TOKEN = re.compile(r"\d+(?:\.\d+)?|[a-z]+(?:'[a-z]+)?")
_DECIMAL_COMMA = re.compile(r"\b(\d{1,3}),(\d{1,2})\b")
_SUFFIXED_FIGURE = re.compile(r"(\d)(cm|mm|m|ft)\b")


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
        return _none(text, "I heard nothing.")
    if (command := spoken_command(text)) is not None:
        return Request(
            text=text,
            intent=Intent.CONTROL,
            phrase="false",
            command=command,
            reason=f"That is the command {command!r}.",
        )
    snapped = snap(tokens(text))
    heard = _Heard(text, tuple(repair(snapped.words)), tuple(snapped.changes))
    frame = find_frame(heard.words)
    if frame.edits:
        return _edit(heard, frame)
    if is_question(heard.words) and not frame.asks:
        return Request(
            text=text,
            intent=Intent.QUERY,
            phrase="false",
            reason=f"That is a question; I build what I am asked for. {_TRY}",
        )
    return _design(heard, frame, setting)


def tokens(text: str) -> list[str]:
    """Lower-case words and figures, without stutters; hyphens part words, figures and units."""
    plain = text.lower().replace("’", "'").replace("½", " half")  # noqa: RUF001
    plain = _DECIMAL_COMMA.sub(r"\1.\2", plain)
    words = _TOKEN.findall(_SUFFIXED_FIGURE.sub(r"\1 \2", plain))
    return [w for i, w in enumerate(words) if i == 0 or w != words[i - 1] or not w.isalpha()]


def _design(heard: _Heard, frame: Frame, setting: Setting) -> Request:
    wish = _spell_out(frame.rest)
    sizes = read_sizes(wish, setting.pitch_m)
    phrase = read_phrase(wish, sizes.spans, asked=frame.asks)
    if phrase is None:
        return _none(heard.text, f"I heard no wish for an object in that. {_TRY}")
    glyph = read_glyph(wish)
    if phrase.abstract and glyph is None:
        return _none(
            heard.text,
            f'I can build things to touch, and "{phrase.text}" is none that I know. '
            f"Please say it as an object. {_TRY}",
        )
    return Request(
        text=heard.text,
        intent=Intent.DESIGN,
        phrase=phrase.text,
        objects=phrase.objects,
        count=phrase.count,
        attributes=read_attributes(wish, phrase.objects[0]),
        dimensions_m=sizes.metres,
        dimension_sources=sizes.sources,
        corrections=heard.changes,
        reason=_corrections(heard),
    )


def _spell_out(wish: tuple[str, ...]) -> tuple[str, ...]:
    """``a t`` is the letter T."""
    alone = len(wish) > 1 and len(wish[-1]) == 1 and set(wish[:-1]) <= {"a", "an", "the", "big"}
    return (*wish[:-1], "letter", wish[-1]) if alone else wish


def _edit(heard: _Heard, frame: Frame) -> Request:
    """``make it taller``; in ``make it a bench`` the new object is named."""
    replacement: NounPhrase | None = None
    if frame.rest[:1] == ("make",) and frame.rest[2:3] in (("a",), ("an",)):
        replacement = read_phrase(frame.rest[2:], [], asked=True)
    named = replacement is not None and not replacement.abstract
    return Request(
        text=heard.text,
        intent=Intent.EDIT,
        phrase=replacement.text if replacement is not None and named else "false",
        objects=replacement.objects if replacement is not None and named else (),
        count=replacement.count if replacement is not None and named else 0,
        reason="That changes an object that was designed before; please say the whole wish, "
        'such as "a tall stool".',
    )


def _none(text: str, reason: str) -> Request:
    return Request(text=text, intent=Intent.NONE, phrase="false", reason=reason)


def _corrections(heard: _Heard) -> str:
    changed = ", ".join(f'"{change.heard}" as "{change.taken}"' for change in heard.changes)
    return f"I understood {changed}." if changed else ""
