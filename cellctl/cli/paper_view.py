"""How the paper's tables are shown beside the computed ones: ``45 = 45``, ``46 ‡ 45``."""

from __future__ import annotations

from typing import Final

from rich import box
from rich.console import Console, Group
from rich.padding import Padding
from rich.table import Table as Grid
from rich.text import Text

from cellctl.validating.paper.report import Figure, Mark, Quantity, Report, Row, Table

SIGNS: Final = {Mark.EQUAL: "=", Mark.DIFFERENT: "≠", Mark.CONTRADICTED: "‡"}
_STYLES: Final = {Mark.EQUAL: "green", Mark.DIFFERENT: "yellow", Mark.CONTRADICTED: "magenta"}
_MEANINGS: Final = {
    Mark.EQUAL: "equal",
    Mark.DIFFERENT: "different",
    Mark.CONTRADICTED: "contradicted within the paper",
}
_UNITS: Final = {"cm3": " cm³", "times": "x"}
_RAISED: Final = str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")


def show_report(console: Console, report: Report) -> None:
    """Print every table, its reasons below it, and how many figures bear which mark."""
    console.print(Text(report.paper, style="bold"))
    legend = Text("as printed, a mark, as computed:", style="dim")
    for mark, sign in SIGNS.items():
        legend.append(f"  {sign} ", style=f"bold not dim {_STYLES[mark]}")
        legend.append(_MEANINGS[mark])
    console.print(legend)
    console.print(Text(f"times, robot and requests: {report.cell}", style="dim"))
    for table in report.tables:
        console.print()
        console.print(_shown(table))
    console.print()
    console.print(_summary(report))


def quantity(value: Quantity | None, unit: str) -> str:
    """A figure as people write it: ``45``, ``3m36s``, ``14.0 h``, ``6496 cm³``, ``1229x``."""
    if value is None or isinstance(value, str):
        return value or "none"
    if unit == "s":
        minutes, seconds = divmod(round(value), 60)
        return f"{minutes}m{seconds:02d}s" if minutes < 60 else f"{value / 3600:.1f} h"
    return f"{value:g}{_UNITS.get(unit, '')}"


def _shown(table: Table) -> Group:
    reasons = _numbered(table)
    grid = Grid(box=box.SIMPLE_HEAD, padding=(0, 1), pad_edge=False, show_edge=False)
    grid.add_column(table.of, no_wrap=True, min_width=9)
    for column in table.columns:
        grid.add_column(column)
    for row in table.rows:
        grid.add_row(row.name, *_aligned(row, table, reasons))
    heading = Text(table.title, style="bold")
    heading.append(f"   {table.source}   --table {table.name}", style="dim not bold")
    below = Grid.grid(padding=(0, 1))
    below.add_column(justify="right", no_wrap=True)
    below.add_column()
    if table.note:
        below.add_row("", Text(table.note, style="italic dim"))
    for reason, number in reasons.items():
        below.add_row(_raised(number), Text(reason, style="dim"))
    return Group(heading, *(Padding(part, (0, 0, 0, 2), expand=False) for part in (grid, below)))


def _aligned(row: Row, table: Table, reasons: dict[str, int]) -> list[Text]:
    """The figures of a row, their marks beneath each other in each column."""
    texts = []
    for index, figure in enumerate(row.figures):
        column = [other.figures[index] for other in table.rows]
        before = max(len(quantity(one.printed, one.unit)) for one in column)
        text = Text(quantity(figure.printed, figure.unit).rjust(before), no_wrap=True)
        text.append(f" {SIGNS[figure.mark]} ", style=f"bold {_STYLES[figure.mark]}")
        text.append(quantity(figure.computed, figure.unit))
        if _explained(figure):
            text.append(_raised(reasons[figure.reason]), style="dim")
        texts.append(text)
    return texts


def _numbered(table: Table) -> dict[str, int]:
    """The reasons that are shown, each once, numbered in reading order."""
    reasons: dict[str, int] = {}
    for row in table.rows:
        for figure in row.figures:
            if _explained(figure):
                reasons.setdefault(figure.reason, len(reasons) + 1)
    return reasons


def _explained(figure: Figure) -> bool:
    """Whatever is not equal has its reason shown, and so has what fails."""
    return bool(figure.reason) and (figure.mark is not Mark.EQUAL or figure.computed == "fail")


def _raised(number: int) -> str:
    return str(number).translate(_RAISED)


def _summary(report: Report) -> Text:
    total = sum(1 for _ in report.figures())
    text = Text(f"{total} figures:")
    for mark in Mark:
        text.append(f"  {SIGNS[mark]} ", style=f"bold {_STYLES[mark]}")
        text.append(f"{report.count(mark)} {_MEANINGS[mark]}")
    return text
