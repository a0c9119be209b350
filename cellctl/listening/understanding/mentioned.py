"""A thing that a sentence mentions where it wishes, however it puts that.

``what would be really neat is a windmill`` and ``how difficult is a giraffe`` are in no list of
ways to ask. A thing with "a" before it is taken for wanted when the sentence wishes or asks, and
nothing speaks against it: it tells of what was or is, of somebody's own, of another place, or of
doing something else with it. The cell asks before it builds, so that a mistake costs a "no".
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

from cellctl.listening.lexicon import LEXICON
from cellctl.listening.understanding.words import look_up

_ARTICLES = frozenset({"a", "an", "one", "two", "three"})
_NEGATED = frozenset(
    {"not", "no", "don't", "can't", "won't", "without", "never", "isn't", "doesn't"}
)
_PLACING = frozenset({"of", "in", "on", "at", "by", "from", "into", "than"})
_LEADING_UP = frozenset(
    {("interested", "in"), ("thinking", "of"), ("think", "of"), ("dreaming", "of"), ("fan", "of"),
     ("instead", "of"), ("want", "of"), ("need", "of"), ("keen", "on"), ("settle", "on")}
)  # fmt: skip
_TELLING = frozenset({"have", "has", "like", "love", "see", "take", "get"})
"""These wish only with a "would" or a "can" before them."""
_MODAL = frozenset({"would", "could", "can", "may", "might", "let's", "to", "want", "wants"})
_DREAMED = frozenset({"dreamed", "dreamt", "wished"})


@dataclass(frozen=True)
class _Words:
    wishes: re.Pattern[str]
    against: re.Pattern[str]
    others: frozenset[str]


@lru_cache(maxsize=1)
def _words() -> _Words:
    source = files("cellctl.listening.understanding").joinpath("asides.toml")
    table = tomllib.loads(source.read_text(encoding="utf-8"))["mentioned"]
    wishes, first, anywhere = (
        "|".join(table[key].splitlines()) for key in ("wishes", "against_at_first", "against")
    )
    return _Words(
        re.compile(rf"\b(?:{wishes})\b"),
        re.compile(rf"^(?:{first})\b|\b(?:{anywhere})\b"),
        frozenset(table["others"].split()),
    )


def mentioned(text: str) -> tuple[str, ...] | None:
    """The end of a sentence from the thing on that it may wish for; None where it wishes for none.

    Args:
        text: lower-case words, without what is said around a wish.
    """
    if _words().wishes.search(text) is None or speaks_against(text):
        return None
    words = text.split()
    for index in reversed(range(1, len(words) - 1)):
        of_a_part = words[index - 1] in ("with", "without", "and", "has", "having")
        if words[index] in _ARTICLES and not of_a_part and _may_govern(words[:index]):
            return tuple(words[index:])
    return None


def speaks_against(text: str) -> bool:
    """Whether a sentence tells of what was, of elsewhere or of doing something else."""
    return _words().against.search(text) is not None


def _may_govern(before: Sequence[str]) -> bool:
    """Whether what stands before an article asks for what follows rather than tells of it."""
    if _NEGATED & set(before[-3:]):
        return False
    if before[-1] in _PLACING and tuple(before[-2:]) not in _LEADING_UP:
        return False
    verbs = [word for word in before if _is_verb(word)]
    if not verbs:
        return True
    at = len(before) - 1 - list(reversed(before)).index(verbs[-1])
    if verbs[-1] in _words().others:
        return False
    if verbs[-1] in _TELLING:
        modal = (set(before[:at]) & _MODAL) | (set(before) & _DREAMED)
        shortened = any(word.endswith(("'d", "'ll")) for word in before[:at])
        return bool(modal or shortened) and "you" not in before[max(0, at - 1) : at]
    return True


def _is_verb(word: str) -> bool:
    if word in LEXICON.finite or word in _words().others or word in _TELLING:
        return True
    entry = look_up(word)
    return entry is not None and entry.parts[:1] == "v"
