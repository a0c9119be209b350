"""What is said around a wish: hesitation, politeness, vocatives, tags; see ``asides.toml``."""

from __future__ import annotations

import re
import tomllib
from functools import lru_cache
from importlib.resources import files


def without_asides(text: str) -> str:
    """A sentence less what is said before and after a wish.

    Args:
        text: lower-case words, one space between them.

    Returns:
        What is left; empty when all of it was said around a wish.
    """
    before, after = _patterns()
    while end := max((match.end() for each in before if (match := each.match(text))), default=0):
        text = text[end:]
    while found := [match.start() for each in after if (match := each.search(text))]:
        text = text[: min(found)]
    return text


@lru_cache(maxsize=1)
def _patterns() -> tuple[list[re.Pattern[str]], list[re.Pattern[str]]]:
    """Of what stands before a wish, and of what stands after it; read once."""
    source = files("cellctl.listening.understanding").joinpath("asides.toml")
    table = tomllib.loads(source.read_text(encoding="utf-8"))
    return (
        [re.compile(rf"(?:{line})(?: |$)") for line in table["before"]["said"].splitlines()],
        [re.compile(rf"(?:^| )(?:{line})$") for line in table["after"]["said"].splitlines()],
    )
