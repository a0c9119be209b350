"""How likely a thing that a sentence mentions is wished for: a linear model of the words around it.

Where no rule knows how a wish is put, the words before and after "a bunny" still tell: people who
tell of one say "had", "is", "when"; people who wish say "could", "so", "please". The model is a
weight for each such feature; ``scripts/train_wishes.py`` finds them and says from what. Which thing
it is plays no part, so that the model knows no more of a windmill than of a chair.
"""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files
from itertools import pairwise

from cellctl.listening.lexicon import LEXICON, singular
from cellctl.listening.phrases import NounPhrase, read_phrase
from cellctl.listening.understanding.judging import judge
from cellctl.listening.understanding.mentioned import speaks_against
from cellctl.listening.understanding.words import look_up

_ARTICLES = frozenset({"a", "an", "some", "another", "one", "two", "three", "four"})
_NEGATED = frozenset({"not", "no", "don't", "can't", "won't", "without", "never", "isn't",
                      "doesn't", "nobody", "none"})  # fmt: skip
_OF_A_THING = frozenset({"with", "without", "having", "than"})
"""After these a part is named, or what a thing is measured by."""
SURE = 0.65
"""From here on a thing is taken for wished for. The cell asks before it builds."""


@dataclass(frozen=True)
class Mention:
    """A thing with an article or a number before it."""

    start: int
    """Index of its article."""
    end: int
    """Index after its noun."""
    phrase: NounPhrase


@dataclass(frozen=True)
class _Model:
    bias: float
    words: frozenset[str]
    """Those that are features themselves; of others only the part of speech is."""
    weights: dict[str, float]


def wished(words: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """What a sentence may wish for, from its article on, the likeliest first.

    Args:
        words: all of it, lower case.
    """
    known = _model()
    found = []
    for mention in mentions(words):
        score = known.bias + sum(
            known.weights.get(feature, 0.0) for feature in features(words, mention, known.words)
        )
        found.append((1 / (1 + math.exp(-score)), mention.start))
    for likelihood, start in sorted(found, reverse=True):
        if likelihood >= SURE:
            yield tuple(words[start:])


def mentions(words: Sequence[str]) -> Iterator[Mention]:
    """Every thing that a sentence mentions with an article or a number before it."""
    for start, word in enumerate(words[:-1]):
        inside = start > 0 and words[start - 1] in _OF_A_THING
        phrase = read_phrase(words[start:], []) if word in _ARTICLES and not inside else None
        if phrase is None or phrase.core[0] in LEXICON.vague:
            continue
        if judge(phrase.core, phrase.objects[0]).physical is not True:
            continue
        size = len(phrase.core)
        begins = (i for i in range(start, len(words)) if tuple(words[i : i + size]) == phrase.core)
        yield Mention(start, next(begins, start + 1) + size, phrase)


def features(words: Sequence[str], mention: Mention, spelled: frozenset[str]) -> frozenset[str]:
    """What the words around a thing say, as the names of the model's weights.

    Args:
        words: the sentence, lower case.
        mention: the thing.
        spelled: words that count as such; the others count by their part of speech.
    """
    kinds = [_kind(word, spelled) for word in words]
    before = ["^", "^", "^", *kinds[: mention.start]]
    after = [*kinds[mention.end :], "$", "$"]
    first = kinds[: mention.start]
    found = {
        f"-1 {before[-1]}", f"-2 {before[-2]}", f"-3 {before[-3]}",
        f"-21 {' '.join(before[-2:])}", f"-321 {' '.join(before[-3:])}",
        *(f"first{count} {' '.join(kinds[:count])}" for count in (1, 2, 3)),
        f"+1 {after[0]}", f"+12 {' '.join(after[:2])}",
        f"before {min(mention.start, 6)}", f"after {min(len(words) - mention.end, 4)}",
        f"article {words[mention.start]}",
        *(f"has {kind}" for kind in first),
        *(f"pair {one} {two}" for one, two in pairwise(first)),
        *(f"then {kind}" for kind in kinds[mention.end :]),
        f"negated {bool(_NEGATED & set(words[max(0, mention.start - 3) : mention.start]))}",
        f"told {speaks_against(' '.join(words))}",
        f"begins told {speaks_against(' '.join(words[: mention.start]))}",
    }  # fmt: skip
    return frozenset(found)


def _kind(word: str, spelled: frozenset[str]) -> str:
    if word in spelled:
        return word
    entry = look_up(word) or look_up(singular(word))
    if entry is None:
        return next((f"<{end}>" for end in ("ed", "ing", "'s") if word.endswith(end)), "<?>")
    return "<past>" if "p" in entry.parts else f"<{entry.parts[:1]}>"


@lru_cache(maxsize=1)
def _model() -> _Model:
    source = files("cellctl.listening.understanding").joinpath("wishes.json.gz")
    table = json.loads(gzip.decompress(source.read_bytes()))
    return _Model(table["bias"], frozenset(table["words"]), table["weights"])
