"""The request reader's words, read once from ``lexicon.toml`` beside this module."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from importlib.resources import files

_IRREGULAR = {
    "shelves": "shelf",
    "bookshelves": "bookshelf",
    "knives": "knife",
    "leaves": "leaf",
    "wolves": "wolf",
    "feet": "foot",
    "mice": "mouse",
    "men": "man",
    "women": "woman",
    "people": "people",
    "geese": "goose",
    "boxes": "box",
    "dice": "die",
}
_NEVER_PLURAL = ("aos", "ss", "us", "is", "ics", "news", "stairs")


@dataclass(frozen=True)
class Lexicon:
    """Sets of words by what they mean for a request; all nouns are singular."""

    families: frozenset[str]
    physical: frozenset[str]
    characters: frozenset[str]
    """Names that need no article: ``batman``."""
    abstract: frozenset[str]
    abstract_suffixes: tuple[str, ...]
    vague: frozenset[str]
    of_nouns: frozenset[str]
    colours: frozenset[str]
    parts: dict[str, str]
    """Attribute by part: ``rung`` is counted as ``steps``."""
    spelled: dict[str, str]
    """Letter by a way to write its name: ``tea`` is ``T``."""
    fillers: frozenset[str]
    greetings: frozenset[str]
    determiners: frozenset[str]
    verbs: frozenset[str]
    gerunds: frozenset[str]
    enders: frozenset[str]
    finite: frozenset[str]
    comparatives: frozenset[str]
    questions: frozenset[str]

    def is_physical(self, noun: str) -> bool | None:
        """Whether a singular noun names a thing that can be touched; None for an unknown noun."""
        if noun in self.physical or noun in self.families or noun in self.characters:
            return True
        if noun in self.abstract or noun in self.vague or noun in self.colours:
            return False
        # Closed compounds: a "birdcage" is a cage.
        if any(len(noun) > len(known) + 2 and noun.endswith(known) for known in self.families):
            return True
        return None

    def sounds_abstract(self, noun: str) -> bool:
        """Whether a noun that nobody listed ends as those do that name no thing."""
        return len(noun) > 6 and noun.endswith(self.abstract_suffixes)


def singular(noun: str) -> str:
    """The singular of an English noun, by rule."""
    if noun in _IRREGULAR:
        return _IRREGULAR[noun]
    if len(noun) < 4 or noun.endswith(_NEVER_PLURAL) or not noun.endswith("s"):
        return noun
    if noun.endswith("ies") and len(noun) > 4:
        return noun[:-3] + "y"
    if noun.endswith(("ches", "shes", "sses", "xes")):
        return noun[:-2]
    return noun[:-1]


def _load() -> Lexicon:
    source = files("cellctl.listening").joinpath("lexicon.toml").read_text(encoding="utf-8")
    table = tomllib.loads(source)

    def words(section: str, key: str = "nouns") -> frozenset[str]:
        return frozenset(table[section][key].split())

    return Lexicon(
        families=words("families"),
        physical=words("physical"),
        characters=words("characters"),
        abstract=words("abstract"),
        abstract_suffixes=tuple(table["abstract"]["suffixes"].split()),
        vague=words("vague"),
        of_nouns=words("kinds", "of"),
        colours=words("kinds", "colours"),
        parts={part: name for name, line in table["parts"].items() for part in line.split()},
        spelled={
            name: letter for letter, line in table["spelled"].items() for name in line.split()
        },
        **{key: words("grammar", key) for key in table["grammar"]},
    )


LEXICON = _load()
