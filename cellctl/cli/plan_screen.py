"""A plan's report for people, on a screen of 100 columns."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

from cellctl.assembly import Cell, StepKind
from cellctl.cli.plan_report import PlanReport, Refused
from cellctl.validating.words import count, named, parts

COLUMNS: Final = 100
"""No line is longer, however wide the screen."""

_AMPLE: Final = 1.1
"""A smaller margin is remarked upon."""
_GAP: Final = "   "
_LEGEND: Final = "From above, x to the right, y up the page; the numbers are the steps."
_LEAST_ABREAST: Final = 3
"""Where the workspace is too wide for so many layers side by side, the object is shown alone."""


def report_console() -> Console:
    """Standard output, no wider than the report needs; without a terminal exactly that wide."""
    console = Console(highlight=False)
    console.width = min(console.width, COLUMNS) if console.is_terminal else COLUMNS
    return console


def show_report(console: Console, report: PlanReport, grid: tuple[int, int, int]) -> None:
    """Print the report of a plan.

    Args:
        console: where to.
        report: of a plan, not of a refusal.
        grid: the workspace's size in cells along x, y and z.
    """
    console.print(Text(headline(report), style="bold"))
    if report.provenance:
        console.print(Text(report.provenance, style="dim"))
    console.print()
    if lines := layer_lines(report, grid, console.width - 2):
        for line in lines:
            console.print(Text(f"  {line}"), no_wrap=True, overflow="ignore", crop=False)
        console.print()
    table = Table.grid(padding=(0, 2))
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for label, style, words in _rows(report):
        table.add_row(Text(label, style=style), Text(words))
    console.print(table)


def show_refusal(console: Console, refused: Refused) -> None:
    """Print what a refusal knows beyond its message, which the command prints at its end."""
    if refused.cells and not any(str(list(cell)) in refused.message for cell in refused.cells):
        console.print(Text(f"Where: {named(refused.cells)}."))
    if refused.nearest is not None and refused.nearest.what not in refused.message:
        console.print(Text(f"What could be built: {refused.nearest.what}"))


def headline(report: PlanReport) -> str:
    """``stool with three legs: 30 parts, 50 x 40 x 50 cm``."""
    return f"{report.title}: {_amount(report)}"


def summary(report: PlanReport) -> str:
    """Parts, size, margin and time in a line, for a picture's caption."""
    words = [_amount(report)]
    if report.margin is not None:
        words.append(f"margin {report.margin:.2f}")
    if report.duration_s is not None and report.placements:
        words.append(f"about {duration(report.duration_s)}")
    return ", ".join(words)


def duration(seconds: float) -> str:
    """``47 s``, ``2 min 27 s``."""
    whole = round(seconds)
    return f"{whole} s" if whole < 60 else f"{whole // 60} min {whole % 60} s"


def margin_words(report: PlanReport) -> str:
    """How safely it stands, and when and where it does least; empty where that is not known."""
    worst = report.weakest_placement
    if not report.placements:
        return ""
    if worst is None:
        judged = any(check.name == "stability" for check in report.checks)
        return "It stands by its weight alone; no step needs a magnet." if judged else ""
    assert worst.margin is not None
    done = "placed at" if worst.kind is StepKind.PLACE else "taken from"
    words = (
        f"{worst.margin:.2f} at its least, in step {worst.index + 1} of {len(report.placements)}, "
        f"a part {done} {list(worst.cell)}: "
    )
    if worst.margin >= 1.0:
        words += f"the magnets are {worst.margin:.2f} times as strong as they must be."
    else:
        words += "it would come apart then."
    if 1.0 <= worst.margin < _AMPLE:
        words += " That leaves next to nothing to spare: have an eye on that step."
    if report.weakest is not None:
        words += f" The weakest joint is the one {report.weakest.description}."
    return words


def closeness_words(report: PlanReport) -> str:
    """How near it is to what was asked for; empty where nothing had to be sought."""
    if report.score is None:
        return ""
    words = f"{report.score:.0%} of the shape is kept"
    if report.baseline_score is not None:
        words += f"; the rescaling of the Speech-to-Reality paper keeps {report.baseline_score:.0%}"
    if report.proven:
        words += (
            ". No object with the same symmetry and without new gaps keeps more: this is proven."
        )
    elif report.bound is not None:
        words += (
            f". With the same symmetry and without new gaps, at most {report.bound:.0%} can be "
            f"kept; whether more than this can was left open after {report.planning_s:.1f} s."
        )
    else:
        words += ". How much more could be kept is not known."
    return words


def layer_lines(report: PlanReport, grid: tuple[int, int, int], columns: int) -> list[str]:
    """The object's layers from the floor up as text, side by side as far as they fit.

    y runs up the page and x to the right; a part has the number of the step that places it, from 1,
    or ``#`` if it stood there before. A line at the end says so. Nothing where nothing stands.
    """
    if not report.cells:
        return []
    number = {
        step.cell: str(step.index + 1) for step in report.placements if step.kind is StepKind.PLACE
    }
    shown = {cell: number.get(cell, "#") for cell in report.cells}
    digits = max(len(text) for text in shown.values())
    span = (range(grid[0]), range(grid[1]))
    legend = _LEGEND
    if "#" in shown.values():
        legend += " # stood before."
    if (digits + 1) * grid[0] > columns // _LEAST_ABREAST:  # a wide workspace: the object alone
        span = (_span(cell.x for cell in shown), _span(cell.y for cell in shown))
        legend += f" Lower left is x {span[0][0]}, y {span[1][0]}."
    width = max((digits + 1) * len(span[0]) - 1, len("layer 00"))
    abreast = max(1, (columns + len(_GAP)) // (width + len(_GAP)))
    layers = range(max(cell.z for cell in shown) + 1)
    lines: list[str] = []
    for first in range(0, len(layers), abreast):
        together = layers[first : first + abreast]
        lines += [""] * bool(lines)
        lines.append(_GAP.join(f"layer {z}".ljust(width) for z in together).rstrip())
        for y in reversed(span[1]):
            rows = (
                " ".join(shown.get(Cell(x, y, z), ".").rjust(digits) for x in span[0]).ljust(width)
                for z in together
            )
            lines.append(_GAP.join(rows).rstrip())
    return [*lines, "", legend]


def _rows(report: PlanReport) -> Iterator[tuple[str, str, str]]:
    """Everything but the layers, as (label, style, words)."""
    if words := margin_words(report):
        yield "margin", "bold", words
    if words := closeness_words(report):
        yield "shape", "bold", words
    for change in report.changes:
        yield "changed", "yellow", f"{change.what} {change.why}"
    for question in report.questions:
        yield "to ask", "yellow", question
    for check in report.checks:
        mark, style = ("pass", "green") if check.passed else ("FAIL", "red")
        yield mark, style, f"{check.name}: {check.message}"
    steps = len(report.placements)
    if report.duration_s is not None and steps:
        each = report.duration_s / steps
        yield "time", "bold", f"about {duration(report.duration_s)} to build, {each:.1f} s a part"
    paper = ", the rules of the Speech-to-Reality paper" if report.policy == "paper" else ""
    yield (
        "planned",
        "bold",
        f"in {report.planning_s:.1f} s, by the policy {report.policy!r}{paper}",
    )


def _amount(report: PlanReport) -> str:
    """``30 parts, 50 x 40 x 50 cm``; of a plan that leaves nothing, how much it takes away, and of
    one without steps that it stands already."""
    if not report.cells:
        return f"taken apart in {count(len(report.placements), 'step')}"
    size = " x ".join(f"{round(edge * 100, 1):g}" for edge in report.size_m)
    stands = "" if report.placements else ", standing already"
    return f"{parts(len(report.cells))}, {size} cm{stands}"


def _span(values: Iterator[int]) -> range:
    all_of = list(values)
    return range(min(all_of), max(all_of) + 1)
