"""Numbers in words and figures: ``two``, ``thirty five``, ``half a``, ``1.5``, ``a hundred``."""

from __future__ import annotations

import re
from collections.abc import Sequence

DIGITS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine")
_TEENS = (
    *("ten", "eleven", "twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen"),
    *("eighteen", "nineteen"),
)
_TENS = ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety")
_SMALL = {
    **{word: value for value, word in enumerate((*DIGITS, *_TEENS))},
    **{word: 10 * value for value, word in enumerate(_TENS, start=2)},
}
_FRACTIONS = {"half": 0.5, "quarter": 0.25}
_FIGURE = re.compile(r"\d{1,6}(\.\d{1,4})?")


def read_number(  # noqa: PLR0911 - one way out a kind of number
    words: Sequence[str], start: int
) -> tuple[float, int] | None:
    """Read the longest number that starts at ``words[start]``.

    Returns:
        Its value and the index after its last word; None when no number starts there.
    """
    word = words[start] if start < len(words) else ""
    if _FIGURE.fullmatch(word):
        return _with_fraction(words, start + 1, float(word))
    if word in _FRACTIONS:
        end = start + 1
        if end < len(words) and words[end] in ("a", "an"):
            end += 1
        if words[end : end + 1] in (["dozen"], ("dozen",)):
            return 12 * _FRACTIONS[word], end + 1
        return _FRACTIONS[word], end
    if word == "dozen":
        return 12.0, start + 1
    if word in ("a", "an", "the") and start + 1 < len(words):
        return _after_article(words, start)
    if word in _SMALL or word == "hundred":
        value, end = _cardinal(words, start)
        return _with_fraction(words, end, value)
    return None


def _after_article(words: Sequence[str], start: int) -> tuple[float, int] | None:
    """``a hundred``, ``a dozen``, ``a couple of``, ``a half``."""
    following = words[start + 1]
    if following in ("hundred", "dozen", *_FRACTIONS):
        return read_number(words, start + 1)
    if list(words[start + 1 : start + 3]) in (["couple", "of"], ["pair", "of"]):
        return 2.0, start + 3
    return None


def _cardinal(words: Sequence[str], start: int) -> tuple[float, int]:
    total, end = 0, start
    while end < len(words):
        word = words[end]
        if word == "hundred":
            total = max(1, total) * 100
        elif word in _SMALL and (total == 0 or _fits(total, _SMALL[word])):
            total += _SMALL[word]
        elif not _joins(words, start, end):
            break
        end += 1
    return float(total), end


def _joins(words: Sequence[str], start: int, index: int) -> bool:
    """Whether ``words[index]`` is the "and" of "a hundred and five"."""
    after_hundred = index > start and words[index - 1] == "hundred"
    before_number = index + 1 < len(words) and words[index + 1] in _SMALL
    return words[index] == "and" and after_hundred and before_number


def _fits(total: int, addend: int) -> bool:
    """Whether a number may follow: ``thirty five``, ``hundred fifty``, but not ``two three``."""
    if total % 100 == 0:
        return addend < 100
    return total % 100 >= 20 and total % 10 == 0 and 0 < addend < 10


def _with_fraction(words: Sequence[str], end: int, value: float) -> tuple[float, int]:
    """``one point five``, ``one and a half``."""
    if list(words[end : end + 3]) == ["and", "a", "half"]:
        return value + 0.5, end + 3
    if end + 1 < len(words) and words[end] == "point" and words[end + 1] in _SMALL:
        digit = _SMALL[words[end + 1]]
        if digit < 10:
            return value + digit / 10, end + 2
    return value, end
