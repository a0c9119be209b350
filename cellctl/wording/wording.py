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

_WRITTEN = ("refused.", "change.")
"""Tables of the sentences that are written where they arise, in the reference's language."""

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
        forms = self.messages[key]
        count = fields.get("count", 0)
        form = gettext.c2py(self.plural)(count) if len(forms) > 1 and isinstance(count, int) else 0
        return forms[form].format(**fields)

    def line(self, key: str, **fields: object) -> Line:
        """A message as something to say."""
        return Line(key=key, text=self.text(key, **fields), language=self.language)

    def translated(self, text: str) -> str:
        """A sentence that the code wrote in English, in this language.

        It is found by the reference's wording, with its fields; what is not found stays as it is.
        """
        if self.reference is None:
            return text
        for key, pattern in self.reference.patterns:
            if match := pattern.fullmatch(text):
                return self.text(key, **match.groupdict())
        return text

    @cached_property
    def patterns(self) -> tuple[tuple[str, re.Pattern[str]], ...]:
        """Messages that the code itself writes, as patterns; the plainest first."""
        written = [(k, forms[0]) for k, forms in self.messages.items() if k.startswith(_WRITTEN)]
        written.sort(key=lambda one: len(fields_of((one[1],))))
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


def _pattern(form: str) -> re.Pattern[str]:
    """What a message looks like with its fields filled in."""
    pieces = [
        re.escape(text) + (f"(?P<{name}>.+?)" if name is not None else "")
        for text, name, _, _ in string.Formatter().parse(form)
    ]
    return re.compile("".join(pieces))


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
