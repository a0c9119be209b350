"""The messages of one language."""

from __future__ import annotations

import gettext
import re
import string
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

from cellctl.wording.line import Line

REFERENCE_LANGUAGE = "en"
"""The language whose file says which messages there are, and which fields each has."""

WRITTEN = (
    *("refused.", "design.", "plan.", "route.", "change.", "term.", "counted."),
    *("told.", "doubt.", "fault.", "detail.", "service."),
)
"""Tables of what is written where it arises, in the reference's language: for logs, for other
processes and for the journal as much as for people."""
_ARTICLE = re.compile(r"(?:an?|the) ", re.IGNORECASE)
_BETWEEN_SENTENCES = re.compile(r"(?<=[.!?]) (?=[A-Z`])")
_AFTER_A_COLON = re.compile(r"(?<=:) (?=[A-Z`])")
_IN_A_FIELD = r"(?:(?!(?<=[.!?:]) (?-i:[A-Z`])).)+?"
"""Never more than one sentence: others are found by themselves."""
_COUNT = r"[^\s,]+"
"""A number, in digits or as a word."""
_BETWEEN_WORDS = re.compile(r"(, or |, and |, | and )")

Forms = tuple[str, ...]
"""The wordings of one message: one, or one for each form of the language's plural."""


@dataclass(frozen=True)
class Wording:
    """The messages of one language, checked.

    Args:
        language: its code, such as ``de``.
        name: what its speakers call it.
        plural: which form a count takes, as gettext has it: an expression of ``n`` in C.
        messages: forms by dotted key.
        hearing: what people say in it: sentences and words, for those who interpret them.
        reference: the messages that say what the code itself writes; None for those themselves.
    """

    language: str
    name: str
    plural: str
    messages: Mapping[str, Forms]
    hearing: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    reference: Wording | None = None

    def text(self, key: str, **fields: object) -> str:
        """A message with its fields filled in.

        Args:
            key: such as ``ask.build``.
            fields: by name; ``count`` also picks the form.

        Raises:
            KeyError: there is no such message, or one of its fields is missing.
        """
        count = fields.get("count", 0)
        return self._filled(key, count if isinstance(count, int) else 0, fields)

    def _filled(self, key: str, count: int, fields: Mapping[str, object]) -> str:
        forms = self.messages[key]
        form = gettext.c2py(self.plural)(count) if len(forms) > 1 else 0
        return forms[form].format(**fields)

    def line(self, key: str, **fields: object) -> Line:
        """A message as something to say."""
        return Line(key=key, text=self.text(key, **fields), language=self.language)

    def translated(self, text: str) -> str:
        """A sentence that the code wrote in English, or several, in this language.

        Its message is found by the reference's wording, its fields by theirs; what is not found
        stays as it is.
        """
        if self.reference is None or not text:
            return text
        if (whole := self._found(text)) is not None:
            return whole
        for between in (_BETWEEN_SENTENCES, _AFTER_A_COLON):
            pieces = between.split(text)
            if len(pieces) > 1:
                return " ".join(map(self.translated, pieces))
        return text

    def _found(self, text: str) -> str | None:
        """The message that says just this; None for none."""
        assert self.reference is not None, "the reference's own words need no translation"
        for key, pattern in self.reference.patterns:
            if match := pattern.fullmatch(text):
                given = match.groupdict()
                fields = {name: self._field(value) for name, value in given.items()}
                said = self._filled(key, _number(given.get("count", "")), fields)
                capital = text[:1].isupper() and not given
                return said[:1].upper() + said[1:] if capital else said
        return None

    def _field(self, text: str) -> str:
        """What stands in a field: a number, a name, a thing, a sentence, or several of them."""
        if not any(letter.isalpha() for letter in text):
            return text
        if (thing := self._thing(text)) is not None:
            return thing
        if (said := self.translated(text)) != text:
            return said
        pieces = _BETWEEN_WORDS.split(text)
        if len(pieces) == 1:
            return text
        joints = {", or ": f" {self.text('term.or')} ", ", ": ", "}
        both = f" {self.text('term.and')} "
        return "".join(
            joints.get(piece, both) if index % 2 else self._field(piece)
            for index, piece in enumerate(pieces)
        )

    def _thing(self, text: str) -> str | None:
        """What a thing is called, with its article or without, as it is given."""
        bare = _ARTICLE.sub("", text, count=1)
        name = self.hearing.get("things", {}).get(bare.lower())
        if not isinstance(name, str):
            return None
        return name if bare != text else name.partition(" ")[2] or name

    def knows(self, text: str) -> bool:
        """Whether every sentence of an English text is a message of the reference."""
        patterns = (self.reference or self).patterns

        def known(piece: str) -> bool:
            return any(pattern.fullmatch(piece) for _, pattern in patterns)

        return known(text) or all(
            known(sentence) or all(map(known, _AFTER_A_COLON.split(sentence)))
            for sentence in _BETWEEN_SENTENCES.split(text)
        )

    @cached_property
    def patterns(self) -> tuple[tuple[str, re.Pattern[str]], ...]:
        """What the code itself writes, as patterns; the most particular first."""
        written = [
            (key, form)
            for key, forms in self.messages.items()
            if key.startswith(WRITTEN)
            for form in forms
        ]
        written.sort(key=lambda one: (len(fields_of((one[1],))) > 0, -len(one[1])))
        return tuple((key, _pattern(form)) for key, form in written)

    def has(self, key: str) -> bool:
        """Whether there is such a message."""
        return key in self.messages

    def under(self, table: str) -> dict[str, str]:
        """The messages of one table that need no fields, by the rest of their keys."""
        start = f"{table}."
        return {
            key.removeprefix(start): forms[0]
            for key, forms in self.messages.items()
            if key.startswith(start) and not fields_of(forms)
        }


def _number(count: str) -> int:
    """The count that picks a form, of a number in digits or in words; words need no more than to
    tell one from several."""
    return int(count) if count.isdecimal() else 1 if count.lower() == "one" else 2


def _pattern(form: str) -> re.Pattern[str]:
    """What a message looks like with its fields filled in."""
    pieces = [
        re.escape(text)
        + (f"(?P<{name}>{_COUNT if name == 'count' else _IN_A_FIELD})" if name is not None else "")
        for text, name, _, _ in string.Formatter().parse(form)
    ]
    return re.compile("".join(pieces), re.IGNORECASE)


def fields_of(forms: Forms) -> frozenset[str]:
    """The names of a message's fields.

    Raises:
        ValueError: braces that do not pair.
    """
    return frozenset(
        name
        for form in forms
        for _, name, _, _ in string.Formatter().parse(form)
        if name is not None
    )
