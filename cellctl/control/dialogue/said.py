"""Who said what, as far as it is understood, and which answers are for all to hear."""

from __future__ import annotations

from dataclasses import dataclass

from cellctl.assembly import Request, Role, Utterance
from cellctl.control.dialogue.reading import Reading
from cellctl.control.dialogue.table import Place
from cellctl.wording import Line

_ANSWERED_ONLY = frozenset({"reply.thinking", "reply.changing", "reply.another", "reply.no"})
"""Lines for the one who said something: what the cell itself says then tells more."""


@dataclass(frozen=True)
class Who:
    """The one who says something."""

    role: Role
    owner: str = ""
    """Mark of a visitor; empty for the one in front of the cell."""


@dataclass(frozen=True)
class Said:
    """What somebody said, as far as it is understood."""

    who: Who
    utterance: Utterance
    reading: Reading
    request: Request | None = None
    answers: str | None = None
    """Name of the question that a yes would be for; None: of whichever is open."""


def is_for_all(line: Line, place: Place) -> bool:
    """Whether an answer is said aloud and shown to everybody.

    Args:
        line: the answer.
        place: where the conversation is by then; what the cell asks or waits for there was said
            already, and comes last.
    """
    if line.key == "reply.resume":
        return place in {Place.THINKING, Place.WORKING}
    return bool(line.text) and line.key not in _ANSWERED_ONLY
