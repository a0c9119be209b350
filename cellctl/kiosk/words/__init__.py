"""The page's own labels: a file for each language."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Final

FALLBACK: Final = "en"


@cache
def _labels(language: str) -> dict[str, str]:
    text = files(__name__).joinpath(f"{language}.toml").read_text(encoding="utf-8")
    return {
        f"{table}.{name}": line
        for table, lines in tomllib.loads(text).items()
        for name, line in lines.items()
    }


@cache
def languages() -> dict[str, str]:
    """Code -> the language's own name, for every file that is there."""
    names = sorted(entry.name for entry in files(__name__).iterdir())
    codes = [name.removesuffix(".toml") for name in names if name.endswith(".toml")]
    return {code: _labels(code)["page.language"] for code in codes}


class Words:
    """The labels in one language; what it lacks comes in English.

    Args:
        language: two letters; another one than there are files for is English.
    """

    def __init__(self, language: str) -> None:
        self.language = language if language in languages() else FALLBACK

    def say(self, key: str, **values: object) -> str:
        """The label of that key with the values put in.

        Raises:
            KeyError: no language has it.
        """
        line = _labels(self.language).get(key) or _labels(FALLBACK)[key]
        return line.format(**values) if values else line
