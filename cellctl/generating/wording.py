"""What is said of wishes, and asked of them first; light enough for the daemon's loop."""

from __future__ import annotations

import re

from cellctl.assembly import Request
from cellctl.errors import NoObjectError

_FEATURES = re.compile(r" (?:with|without|having|plus|of|and)\b")
"""Where the name of a thing ends and its features begin."""

_BEGINS_WITH_VOWEL = re.compile(
    r"(?!uni(?!n)|us[ae]|eu|one|ufo)[aeiou]|hour|honest|heir", re.IGNORECASE
)
"""By sound: a unicorn, an hourglass."""


def with_article(phrase: str) -> str:
    """``a stool``, ``an arch``; plural names such as ``steps`` stay alone."""
    named = _FEATURES.split(phrase)[0]
    if named.endswith("s") and not named.endswith(("ss", "us", "glass")):
        return phrase
    return f"{'an' if _BEGINS_WITH_VOWEL.match(phrase) else 'a'} {phrase}"


def refuse_no_object(request: Request) -> None:
    """Raises NoObjectError where there is nothing to design, or nothing that shall be built."""
    if not request.buildable:
        raise NoObjectError(
            request.refusal
            or request.reason
            or f"{request.text!r} names no object. Say what to build, such as a simple stool."
        )
