"""Which words count that nobody was asked for."""

from __future__ import annotations

import re

from cellctl.listening.commands import Sayings, spoken_command

_STOPS = frozenset({"stop", "halt", "freeze"})
_NEGATIONS = frozenset({"don't", "not", "never", "can't", "won't", "non"})
_STOP_MOST_WORDS = 6
_ENGLISH_ONLY = Sayings()


def overheard_command(text: str, own: Sayings = _ENGLISH_ONLY) -> str | None:
    """The command in a sentence that somebody said near the cell, not to it; None for none.

    Like ``spoken_command``, and more willing to stop: a short sentence that begins or ends with
    the word is enough. A stop too many does no harm, one too few may.
    """
    if (word := spoken_command(text, own)) is not None:
        return word
    words = re.findall(r"[a-z']+", text.lower().replace("\N{RIGHT SINGLE QUOTATION MARK}", "'"))
    if not 0 < len(words) <= _STOP_MOST_WORDS or _NEGATIONS & set(words):
        return None
    return "stop" if words[0] in _STOPS or words[-1] in _STOPS else None
