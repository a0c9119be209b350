"""The paper's figures beside those computed here: values, for the screen and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from enum import StrEnum
from typing import Self

from pydantic import model_validator

from cellctl.assembly import Value

Quantity = int | float | str
"""A number in the figure's unit, or a word."""


class Mark(StrEnum):
    """How a printed figure and the one computed for the same object compare."""

    EQUAL = "equal"
    """They agree, within the tolerance that the table states."""
    DIFFERENT = "different"
    """They do not, and the reason says why."""
    CONTRADICTED = "contradicted"
    """The paper says otherwise elsewhere, so that no figure could agree with all of it."""


class Figure(Value):
    """One cell of a table."""

    printed: Quantity
    computed: Quantity | None
    """None where this cell cannot compute one; the reason says why."""
    unit: str = ""
    """``parts``, ``s``, ``h``, ``cm3``, ``times``; empty for words."""
    mark: Mark
    reason: str = ""

    @model_validator(mode="after")
    def _says_why(self) -> Self:
        if self.mark is not Mark.EQUAL and not self.reason:
            raise ValueError("a figure that is not equal has a reason")
        return self


class Row(Value):
    """One object, request or claim."""

    name: str
    figures: tuple[Figure, ...]
    """One for each column of the table."""


class Table(Value):
    """One of the paper's tables, or what its text says."""

    name: str
    """For ``cellctl paper --table``."""
    title: str
    source: str
    """Where the printed figures stand in the paper."""
    of: str
    """What a row is about: the heading of the first column."""
    columns: tuple[str, ...]
    rows: tuple[Row, ...]
    note: str = ""
    """How the computed figures came about, where that is not plain."""


class Report(Value):
    """All tables, or those that were asked for."""

    paper: str
    cell: str
    """The cell whose routes and requests were computed."""
    tables: tuple[Table, ...]

    def figures(self) -> Iterator[Figure]:
        """Every figure of every table."""
        for table in self.tables:
            for row in table.rows:
                yield from row.figures

    def count(self, mark: Mark) -> int:
        """How many figures bear a mark."""
        return sum(1 for figure in self.figures() if figure.mark is mark)


def compared(
    printed: Quantity,
    computed: Quantity | None,
    why: str,
    *,
    unit: str = "",
    contradiction: str = "",
    tolerance: float = 0.0,
) -> Figure:
    """Mark one figure.

    Args:
        printed: the paper's.
        computed: this project's; None where there is none.
        why: what explains the computed one, in a sentence.
        unit: of both.
        contradiction: what else the paper says; empty for nothing.
        tolerance: largest difference of numbers that counts as none, as a part of the printed one.
    """
    if contradiction:
        mark = Mark.CONTRADICTED
        reason = f"{contradiction} {why}".strip()
    else:
        mark = Mark.EQUAL if _agree(printed, computed, tolerance) else Mark.DIFFERENT
        reason = why
    return Figure(printed=printed, computed=computed, unit=unit, mark=mark, reason=reason)


def _agree(printed: Quantity, computed: Quantity | None, tolerance: float) -> bool:
    if isinstance(printed, str) or isinstance(computed, str) or computed is None:
        return printed == computed
    return abs(computed - printed) <= tolerance * abs(printed)
