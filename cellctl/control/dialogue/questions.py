"""Which question is open, and which one an answer was meant for.

Every question gets a name that no other ever has, so that a yes counts for the one that it was an
answer to. Who answers on a screen names the question that was shown there. Who speaks answers the
newest question whose words had begun when the speech began: one that came later was not heard yet,
and that it was shown already says nothing, for the cell still reads back aloud what it understood
then, to which people say yes as well.
"""

from __future__ import annotations

import secrets
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

_REMEMBERED = 8
"""Questions that an answer may still be meant for: those of the last few seconds."""


@dataclass
class _Asked:
    name: str
    text: str
    put_s: float | None
    """Since when it can be answered in speech: its words have begun, or will never be heard."""


class Questions:
    """The questions asked lately.

    Args:
        now_s: this machine's monotonic clock, which the microphone's events go by.
    """

    def __init__(self, now_s: Callable[[], float] = time.monotonic) -> None:
        self._now_s = now_s
        self._asked: deque[_Asked] = deque(maxlen=_REMEMBERED)
        self._open = False

    @property
    def open(self) -> str:
        """Name of the question that is open; empty for none."""
        return self._asked[-1].name if self._open else ""

    def ask(self, text: str, *, aloud: bool) -> str:
        """Something is asked from now on; returns the question's name.

        Args:
            text: its words.
            aloud: they will be said; until they are, nobody can have heard them.
        """
        name = secrets.token_hex(8)
        self._asked.append(_Asked(name, text, None if aloud else self._now_s()))
        self._open = True
        return name

    def close(self) -> None:
        """Nothing is asked any more."""
        self._open = False

    def voiced(self, text: str, at_s: float) -> None:
        """The cell begins to say these words, or has left them to the screen."""
        for asked in self._asked:
            if asked.put_s is None and asked.text == text:
                asked.put_s = at_s

    def meant(self, at_s: float) -> str:
        """Name of the question that speech which began then is an answer to; empty for none."""
        put = [asked for asked in self._asked if asked.put_s is not None and asked.put_s <= at_s]
        return put[-1].name if put else ""

    def is_open(self, name: str) -> bool:
        """Whether that question is the one that is open."""
        return bool(name) and name == self.open
