"""English words, by how physical they are and what they can be: a table compiled from WordNet.

``scripts/compile_words.py`` makes the table and says from what. It is read when it is first needed.
"""

from __future__ import annotations

import gzip
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

_THINGS = "afbdolhp"
_CLASSES = {
    "a": "animal",
    "b": "body",
    "d": "food",
    "f": "artifact",
    "g": "group",
    "h": "shape",
    "l": "plant",
    "o": "natural object",
    "p": "person",
    "s": "substance",
    "t": "time",
    "u": "work",
    "c": "communication",
    "k": "act or fact",
    "m": "money",
    "w": "place",
    "x": "idea",
    "-": "no noun",
}


@dataclass(frozen=True, slots=True)
class Word:
    """What the table says of a word."""

    physical: float
    """0 for an idea, 1 for a thing."""
    kind: str
    """Letter of its main class, such as ``f`` for artifact."""
    parts: str
    """What it can be, the most frequent first: ``n``, ``v``, ``a``, ``r`` (adverb); and ``p``, an
    irregular past."""
    proper: bool
    """Whether it is a name."""

    @property
    def noun(self) -> bool:
        """Whether it can be a noun."""
        return "n" in self.parts

    @property
    def class_name(self) -> str:
        """Its main class in words."""
        return _CLASSES[self.kind]


def look_up(word: str) -> Word | None:
    """A word or a compound of two or three words, singular, lower case; None when unknown."""
    line = _table().get(word)
    if line is None:
        return None
    return Word(physical=int(line[0]) / 9, kind=line[1], proper=line[2] == "N", parts=line[3:])


@lru_cache(maxsize=1)
def _table() -> dict[str, str]:
    packed = files("cellctl.listening.understanding").joinpath("words.gz").read_bytes()
    table = {}
    for line in gzip.decompress(packed).decode("ascii").splitlines():
        word, level, kind, parts = line.split("\t")
        table[word] = f"{level}{kind[0]}{kind[1:] or '.'}{parts}"
    return table
