"""What a person reads of a plan."""

from __future__ import annotations

import io

import pytest
from rich.console import Console

from cellctl.assembly import Cell, Closeness
from cellctl.cli.plan_report import PlanInput, PlanReport, Refused, report_plan
from cellctl.cli.plan_screen import (
    COLUMNS,
    closeness_words,
    duration,
    headline,
    layer_lines,
    margin_words,
    show_refusal,
    show_report,
    summary,
)
from cellctl.config import load_config
from cellctl.errors import Nearest
from tests.cell.harness import CONFIG
from tests.cli.plans import BEAM, beam, changeover, placing, plan_of, standing_already, taking_apart

SETTINGS = load_config(CONFIG)
ASKED = PlanInput(given="a beam", kind="sentence")


def reported(closeness: Closeness | None = None) -> PlanReport:
    return report_plan(beam(closeness), ASKED, SETTINGS, 0.5)


def printed(report: PlanReport, grid: tuple[int, int, int] = (4, 2, 3)) -> str:
    console = Console(file=io.StringIO(), width=COLUMNS, highlight=False)
    show_report(console, report, grid)
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


def test_layers_show_which_step_places_which_part() -> None:
    *layers, empty, legend = layer_lines(reported(), (4, 2, 3), 80)
    assert layers == [
        "layer 0    layer 1",
        ". . . .    . . . .",
        "1 . . .    2 3 4 .",
    ]
    assert empty == ""
    assert "x to the right" in legend


def test_what_stood_before_has_no_number() -> None:
    report = report_plan(changeover(), ASKED, SETTINGS, 0.0)
    assert layer_lines(report, (2, 1, 3), 80)[:-2] == [
        "layer 0    layer 1    layer 2",
        "# .        # .        3 .",
    ]


def test_layers_are_never_wider_than_the_screen() -> None:
    cells = [Cell(x, y, z) for z in range(12) for x in range(3, 15) for y in range(2, 8)]
    report = report_plan(plan_of(placing(cells), cells), ASKED, SETTINGS, 0.0)
    *lines, legend = layer_lines(report, (40, 30, 12), 98)
    assert max(map(len, lines)) <= 98
    assert legend.endswith("Lower left is x 3, y 2.")
    shown = " ".join(lines).split()
    assert all(shown.count(str(number)) >= 1 for number in range(1, len(cells) + 1))
    assert "." not in shown  # 40 cells do not fit: only the object is shown


def test_everything_is_on_the_screen_within_its_columns() -> None:
    text = printed(reported(Closeness(score=0.9, baseline_score=0.7, bound=0.9, proven=True)))
    assert max(map(len, text.splitlines())) <= COLUMNS
    for words in (
        "beam: 4 parts, 30 x 10 x 20 cm",
        "by hand",
        "1.50 at its least, in step 4 of 4, a part placed at [2, 0, 1]",
        "The weakest joint is the one between [1, 0, 1] and [0, 0, 1].",
        "90% of the shape is kept; the rescaling of the Speech-to-Reality paper keeps 70%.",
        "One leg moved in. It would have tipped.",
        "Shall I build it so?",
        "pass     stability: It stands.",
        "about 20 s to build, 5.0 s a part",
        "in 0.5 s, by the policy 'cellctl'",
    ):
        assert words in " ".join(text.split()) or words in text


def test_words_in_brackets_are_no_markup() -> None:
    report = reported().model_copy(update={"title": "[red]beam[/red]", "provenance": "[/]"})
    assert "[red]beam[/red]: 4 parts" in printed(report)


def test_margin_words_say_when_no_magnet_is_needed_and_nothing_when_nobody_looked() -> None:
    column = plan_of(placing(BEAM[:2]), BEAM[:2])
    judged = report_plan(column, ASKED, SETTINGS, 0.0)
    assert "no step needs a magnet" in margin_words(judged)
    assert margin_words(judged.model_copy(update={"checks": ()})) == ""


def test_a_margin_with_nothing_to_spare_is_remarked_upon() -> None:
    bare = plan_of(placing(BEAM, (None, None, 2.0, 1.0)), BEAM)
    assert "next to nothing to spare" in margin_words(report_plan(bare, ASKED, SETTINGS, 0.0))
    assert "to spare" not in margin_words(reported())


def test_margin_words_say_when_it_would_not_hold() -> None:
    weak = plan_of(placing(BEAM, (None, None, 2.0, 0.4)), BEAM)
    words = margin_words(report_plan(weak, ASKED, SETTINGS, 0.0))
    assert words == (
        "0.40 at its least, in step 4 of 4, a part placed at [2, 0, 1]: it would come apart then."
    )


@pytest.mark.parametrize(
    ("near", "says"),
    [
        (
            Closeness(score=0.9, bound=0.9, proven=True),
            "No object with the same symmetry and without new gaps keeps more: this is proven.",
        ),
        (
            Closeness(score=0.8, bound=0.9),
            "With the same symmetry and without new gaps, at most 90% can be kept",
        ),
        (Closeness(score=0.8), "How much more could be kept is not known."),
    ],
)
def test_closeness_says_how_far_from_proven_best_it_is(near: Closeness, says: str) -> None:
    assert says in closeness_words(reported(near))
    assert closeness_words(reported()) == ""


def test_a_plan_that_leaves_nothing_says_so() -> None:
    report = report_plan(taking_apart(), ASKED, SETTINGS, 0.0)
    assert headline(report) == "beam: taken apart in 4 steps"
    assert "taken apart" in printed(report)


def test_one_step_is_no_plural() -> None:
    plan = plan_of(taking_apart().steps[:1], ())
    assert headline(report_plan(plan, ASKED, SETTINGS, 0.0)) == "beam: taken apart in 1 step"


def test_a_plan_without_steps_says_that_it_stands_already() -> None:
    report = report_plan(standing_already(), ASKED, SETTINGS, 0.0)
    assert headline(report) == "beam: 4 parts, 30 x 10 x 20 cm, standing already"
    assert summary(report) == "4 parts, 30 x 10 x 20 cm, standing already"
    assert margin_words(report) == ""
    assert "# stood before." in printed(report)


def test_one_line_for_a_caption() -> None:
    assert summary(reported()) == "4 parts, 30 x 10 x 20 cm, margin 1.50, about 20 s"


def test_durations_are_told_in_minutes_when_they_are_long() -> None:
    assert [duration(s) for s in (4.6, 59.4, 59.6, 147.0)] == [
        "5 s",
        "59 s",
        "1 min 0 s",
        "2 min 27 s",
    ]


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        ("It breaks the rule of overhang.", ("[0, 0, 1], [1, 0, 1]", "and 4 more.", "shorter arm")),
        ("Cells: [0, 0, 1], [1, 0, 1] and 8 more.", ("a shorter arm.",)),
        ("Cells: [0, 0, 1]. What could be built: a shorter arm.", ()),
    ],
)
def test_a_refusal_shows_what_its_message_does_not_say(
    message: str, shown: tuple[str, ...]
) -> None:
    console = Console(file=io.StringIO(), width=COLUMNS)
    cells = tuple(Cell(x, 0, 1) for x in range(10))
    refused = Refused(
        rule="overhang",
        message=message,
        hint="",
        cells=cells,
        nearest=Nearest(what="a shorter arm."),
        exit_status=4,
    )
    show_refusal(console, refused)
    assert isinstance(console.file, io.StringIO)
    text = " ".join(console.file.getvalue().split())
    assert all(words in text for words in shown)
    assert ("[0, 0, 1]" in text) == ("[0, 0, 1]" not in message)
    assert bool(text) == bool(shown)
