"""Wishes that could be built and shall not be, and how that is said."""

from __future__ import annotations

from collections.abc import Sequence

from cellctl.listening.lexicon import singular
from cellctl.listening.understanding.talk import talk

_REFUSALS = {
    "weapon": "I would rather not build weapons, not even of blocks. "
    "I am glad to build something else: perhaps a castle, or a dinosaur?",
    "insult": "I would rather not build what might offend somebody. "
    "I am glad to build something else: perhaps a heart, or a dog?",
}


_BEFORE_MY_OWN = frozenset({"as", "be", "is", "like", "of", "than"})
"""After these "mine" is no weapon but what is the speaker's: a house as big as mine."""


def refusal_of(words: Sequence[str], head: str) -> str:
    """What is said to a wish that shall not be built; empty for one that may be.

    Args:
        words: those of the whole wish, lower case.
        head: the noun of what is wanted, singular.
    """
    known = talk()
    plain = [singular(word) for word in words]
    text = f" {' '.join(plain)} "
    for compound, kind in known.unwanted_compounds.items():
        if f" {compound} " in text:
            return _REFUSALS[kind]
    if set(plain) & known.insults:
        return _REFUSALS["insult"]
    if len(words) > 1 and words[-1] == "mine" and words[-2] in _BEFORE_MY_OWN:
        return ""
    # A "gun rack" is a rack, a "sword in a stone" is a sword.
    if {head, *words[-1:]} & known.weapons and not set(plain) & known.harmless:
        return _REFUSALS["weapon"]
    return ""
