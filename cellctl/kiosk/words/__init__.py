"""The page's own labels: for each language a file, and one for the operator's view."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Final

FALLBACK: Final = "en"


@cache
def _labels(language: str) -> dict[str, str]:
    folder = files(__name__)
    found: dict[str, str] = {}
    for file in (folder / f"{language}.toml", folder / "operator" / f"{language}.toml"):
        if not file.is_file():
            continue  # a language may lack the operator's view, which is in English then
        for table, lines in tomllib.loads(file.read_text(encoding="utf-8")).items():
            found |= {f"{table}.{name}": line for name, line in lines.items()}
    return found


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
