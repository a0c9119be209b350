"""One thing said: the same words on the screen and in the air."""

from __future__ import annotations

from cellctl.assembly import Value


class Line(Value):
    """One thing that the cell says."""

    key: str
    """The message that it is, or begins with, as the message files call it: ``ask.build``."""
    text: str
    """Its words, with all fields filled in."""
    language: str = "en"
    number: int = 0
    """Grows from line to line of one daemon, from 1; 0 before it is said."""
