"""Who says lines aloud."""

from __future__ import annotations

from typing import Protocol

from cellctl.wording import Line


class Speaker(Protocol):
    """Says one line after the other; none of its methods waits, blocks or raises."""

    def say(self, line: Line) -> None:
        """Say a line as soon as what is being said has ended."""
        ...

    def hush(self) -> None:
        """Stop speaking at once, and forget what was still to be said."""
        ...

    @property
    def speaking(self) -> bool:
        """Whether something is being said now."""
        ...

    @property
    def aloud(self) -> bool:
        """Whether a line will be heard; else it is only read."""
        ...


class SilentSpeaker:
    """Says nothing: for a cell without a voice."""

    speaking = False
    aloud = False

    def say(self, line: Line) -> None:
        """Leave the line to the screen."""

    def hush(self) -> None:
        """Nothing is being said."""
