"""The page's labels: every language says everything, with the same fields."""

from __future__ import annotations

import string
import tomllib
from importlib.resources import files

import pytest

from cellctl.kiosk import words
from cellctl.kiosk.words import Words, languages


def labels(language: str) -> dict[str, set[str]]:
    """The fields of every label, by its key."""
    text = files(words).joinpath(f"{language}.toml").read_text(encoding="utf-8")
    return {
        f"{table}.{name}": {field for _, field, _, _ in string.Formatter().parse(line) if field}
        for table, lines in tomllib.loads(text).items()
        for name, line in lines.items()
    }


@pytest.mark.parametrize("language", sorted(languages()))
def test_a_language_has_every_label_with_its_fields(language: str) -> None:
    assert labels(language) == labels("en")


def test_an_unknown_language_is_english() -> None:
    assert Words("xx").say("offer.yes") == Words("en").say("offer.yes") == "Yes"
    assert Words("de").say("page.seconds", n=3) == "3 s"
