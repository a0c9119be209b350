"""What is run together in speech: ``we'd`` is "we would", ``that is`` may be "that's"."""

from __future__ import annotations

import re

_SPELLED_OUT = (
    (re.compile(r"\bcan't\b"), "can not"),
    (re.compile(r"\bwon't\b"), "will not"),
    (re.compile(r"n't\b"), " not"),
    (re.compile(r"\b(i|we|you|he|she|they|it|that|this|there|what|who)'d\b"), r"\1 would"),
    (re.compile(r"'ll\b"), " will"),
    (re.compile(r"\bi'm\b"), "i am"),
    (re.compile(r"'re\b"), " are"),
    (re.compile(r"'ve\b"), " have"),
    (re.compile(r"\b(it|that|what|there|here|where|who|he|she)'s\b"), r"\1 is"),
)
_RUN_TOGETHER = (
    (re.compile(r"\b(it|that|what|there) is\b"), r"\1's"),
    (re.compile(r"\bi am\b"), "i'm"),
    (re.compile(r"\b(we|you|they) are\b"), r"\1're"),
    (re.compile(r"\b(i|we|you) would\b"), r"\1'd"),
    (re.compile(r"\b(i|we|you|that|it) will\b"), r"\1'll"),
    (re.compile(r"\b(i|we|you|they) have\b(?= \w+(?:ed|en|ne)\b)"), r"\1've"),
    (re.compile(r"\b(do|does|did|is|are|was|would|could|should) not\b"), r"\1n't"),
    (re.compile(r"\bcan ?not\b"), "can't"),
    (re.compile(r"\bwill not\b"), "won't"),
)


def spelled_out(text: str) -> str:
    """Lower-case words with each contraction in full."""
    return _replaced(text, _SPELLED_OUT)


def run_together(text: str) -> str:
    """Lower-case words with what is mostly run together run together."""
    return _replaced(text, _RUN_TOGETHER)


def _replaced(text: str, rules: tuple[tuple[re.Pattern[str], str], ...]) -> str:
    for pattern, plain in rules:
        text = pattern.sub(plain, text)
    return text
