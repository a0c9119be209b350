"""Numbers and places in the sentences of checks, changes and refusals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from cellctl.assembly import Cell

_NAMED: Final = 6
"""How many cells a sentence names; a report has all of them."""


def count(number: int, noun: str) -> str:
    """``1 step``, ``2 steps``, ``0 steps``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def parts(number: int, one: str = "", several: str = "") -> str:
    """``1 part``, ``2 parts``; with verbs ``1 part stands``, ``2 parts stand``."""
    return f"{count(number, 'part')} {one if number == 1 else several}".rstrip()


def counted(number: int, one: str, several: str) -> str:
    """A number before its verb, where the noun is clear: ``1 stands``, ``2 stand``."""
    return f"{number} {one if number == 1 else several}"


def named(cells: Sequence[Cell]) -> str:
    """The first cells in their order, and how many more there are: ``[0, 0, 1], [1, 0, 1]``."""
    shown = ", ".join(str(list(cell)) for cell in cells[:_NAMED])
    more = len(cells) - _NAMED
    return f"{shown} and {more} more" if more > 0 else shown


def times(size: Sequence[int]) -> str:
    """A size in cells: ``3 x 1 x 5``."""
    return " x ".join(str(edge) for edge in size)


def listed(phrases: Sequence[str]) -> str:
    """``a``, ``a and b``, ``a, b and c``; at least one."""
    return " and ".join(filter(None, (", ".join(phrases[:-1]), phrases[-1])))
