"""Telling what people said from what the cell said itself, by the words.

An echo that is loud enough to be recognised comes back as words that the cell is saying at that
moment; whatever else is among them somebody said.
"""

from __future__ import annotations

import math
import re
from collections import deque
from dataclasses import dataclass
from difflib import SequenceMatcher

ECHO_SHARE = 0.6
"""Share of the words heard that must be the cell's own for all of them to be an echo, which is
never recognised without a slip."""
_FEW = 3
"""So few words are an echo only if all are the cell's own: "the letter L" answers "the letter T".
So many in a row are left out of a longer sentence."""
_TAIL_S = 0.6
"""An echo may come so much later."""
_REMEMBERED = 8
_STOPS = frozenset({"stop", "halt", "freeze"})


@dataclass
class _Said:
    number: int
    text: str
    began_s: float
    ended_s: float = math.inf


class OwnWords:
    """What the cell said lately, and when."""

    def __init__(self) -> None:
        self._said: deque[_Said] = deque(maxlen=_REMEMBERED)

    def began(self, number: int, text: str, at_s: float) -> None:
        """The cell says this from now on (monotonic); empty for a chime."""
        self._said.append(_Said(number, text, at_s))

    def ended(self, number: int, at_s: float) -> bool:
        """It says it no more; False when it had not begun to."""
        for said in self._said:
            if said.number == number:
                said.ended_s = at_s
                return True
        return False

    def during(self, start_s: float, end_s: float) -> str:
        """What may be heard of it between two moments; empty for nothing."""
        heard = (
            said.text
            for said in self._said
            if said.text and said.began_s < end_s and start_s < said.ended_s + _TAIL_S
        )
        return " ".join(heard)


def of_others(heard: str, own: str, *, command: bool = False) -> str:
    """What somebody else said: the words heard without those that the cell said itself.

    Args:
        heard: what was recognised.
        own: what the cell said at that time; empty for nothing.
        command: what was heard is a command, such as "take it apart": no slip of an echo is.
    """
    if not own:
        return heard
    mine, words = _words(own), _words(heard)
    if any(mine[start : start + len(words)] == words for start in range(len(mine))):
        return ""
    if command or len(words) <= _FEW:
        return heard
    matcher = SequenceMatcher(None, mine, words, autojunk=False)
    blocks = [block for block in matcher.get_matching_blocks() if block.size]
    if sum(block.size for block in blocks) >= ECHO_SHARE * len(words):
        return ""
    echoed = {b.b + offset for b in blocks if b.size >= _FEW for offset in range(b.size)}
    if not echoed:
        return heard
    return " ".join(word for index, word in enumerate(words) if index not in echoed)


def says_stop(own: str) -> bool:
    """Whether the cell itself says a word that would stop it."""
    return bool(_STOPS & set(_words(own)))


def _words(text: str) -> list[str]:
    return re.findall(r"\w+", text.lower().replace("'", ""))
