"""Who said what, as far as it is understood."""

from __future__ import annotations

from dataclasses import dataclass

from cellctl.assembly import Request, Role, Utterance
from cellctl.control.dialogue.reading import Reading


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
