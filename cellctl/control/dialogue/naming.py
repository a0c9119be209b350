"""What was understood of a wish, in words of the cell's language."""

from __future__ import annotations

from collections.abc import Mapping

from cellctl.assembly import Attribute, Request
from cellctl.generating.wording import with_article
from cellctl.wording import REFERENCE_LANGUAGE, Wording

_IN_WORDS = ("two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")
"""Numbers from 2 on, as the message files call them."""


class Naming:
    """Names what somebody wishes for.

    A language may say in its file what things and their features are called
    (``hearing.things``, ``hearing.features``); for what is not there the English words stay.

    Args:
        wording: the cell's language.
    """

    def __init__(self, wording: Wording) -> None:
        self._wording = wording
        self._english = wording.language == REFERENCE_LANGUAGE
        self._things = wording.hearing.get("things", {})
        self._features = wording.hearing.get("features", {})

    def wish(self, request: Request) -> str:
        """Such as ``a stool with four legs``."""
        noun = request.objects[0] if request.objects else ""
        thing = self._things.get(noun)
        if self._english or not isinstance(thing, str):
            counted = request.count > 1 or not request.phrase
            phrase = _spelt(request)
            return phrase if counted else with_article(phrase)
        features = [self._feature(name, value) for name, value in _as_changed(request).items()]
        return " ".join([thing, *filter(None, features)])

    def title(self, request: Request | None, title: str) -> str:
        """A plan's title: as it is, or in the cell's language where the wish can be named in it."""
        if self._english or request is None or not request.objects:
            return title
        return self.wish(request) if request.objects[0] in self._things else title

    def _feature(self, name: str, value: Attribute) -> str:
        forms = self._features.get(name)
        if isinstance(forms, list) and len(forms) == 2 and isinstance(value, int):
            if value is False:
                return ""
            return str(forms[0 if value == 1 else 1]).format(count=self._number(value))
        return str(forms).format(value=value) if isinstance(forms, str) and value else ""

    def _number(self, count: int) -> str:
        """Small numbers in words, as people say them."""
        if not 2 <= count < 2 + len(_IN_WORDS):
            return str(count)
        return self._wording.text(f"term.{_IN_WORDS[count - 2]}")


def _spelt(request: Request) -> str:
    """The phrase, with a letter that is to be built as a capital."""
    glyph, phrase = request.attributes.get("glyph"), request.phrase
    if not isinstance(glyph, str):
        return phrase
    if phrase == "letter":
        return f"letter {glyph}"  # an I was taken for the one who speaks
    return phrase[: -len(glyph)] + glyph.upper() if phrase.endswith(f" {glyph.lower()}") else phrase


def _as_changed(request: Request) -> Mapping[str, Attribute]:
    """The attributes after all edits; those of which it is not known any more are left out."""
    attributes = dict(request.attributes)
    for edit in request.edits:
        if edit.op == "set" and edit.attribute and edit.value is not None:
            attributes[edit.attribute] = edit.value
        elif edit.op in {"add", "remove"}:
            attributes.pop(edit.attribute, None)
    return attributes
