"""``cellctl paper``: what it prints, and what its marks mean."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner, Result

from cellctl.cli.app import command_line
from cellctl.cli.paper_view import quantity
from cellctl.errors import UsageError
from cellctl.validating.paper.comparing import TableName, compare
from cellctl.validating.paper.report import Figure, Mark, compared
from tests.validating.shapes import CONFIG

CONFIG_FILE = Path(__file__).parents[2] / "config" / "sim.toml"

Figures = dict[tuple[str, str, str], dict[str, Any]]
"""(table, row, column) -> figure."""


def run(*arguments: str) -> Result:
    return CliRunner().invoke(command_line(), ["paper", "--config", str(CONFIG_FILE), *arguments])


@pytest.fixture(scope="module")
def figures() -> Figures:
    done = run("--json", "-")
    assert done.exit_code == 0
    report = json.loads(done.stdout)
    assert report["cell"] == CONFIG.cell.name
    return {
        (table["name"], row["name"], column): figure
        for table in report["tables"]
        for row in table["rows"]
        for column, figure in zip(table["columns"], row["figures"], strict=True)
    }


def marked(figures: Figures, table: str, mark: Mark) -> set[tuple[str, str]]:
    return {
        (row, column)
        for (name, row, column), figure in figures.items()
        if name == table and figure["mark"] == mark
    }


def test_every_table_is_there_and_all_that_is_not_equal_has_a_reason(figures: Figures) -> None:
    assert list(dict.fromkeys(table for table, _, _ in figures)) == list(TableName)
    for figure in figures.values():
        assert figure["mark"] == Mark.EQUAL or figure["reason"]


@pytest.mark.parametrize("table", ["count", "overhang", "requests"])
def test_these_tables_are_the_papers(figures: Figures, table: str) -> None:
    assert not marked(figures, table, Mark.DIFFERENT)
    assert not marked(figures, table, Mark.CONTRADICTED)


def test_the_stool_that_gained_a_part_is_contradicted(figures: Figures) -> None:
    assert not marked(figures, "stack", Mark.DIFFERENT)
    assert marked(figures, "stack", Mark.CONTRADICTED) == {
        ("Stool", "baseline"),
        ("Stool", "rescaled"),
    }
    figure = figures["stack", "Stool", "baseline"]
    assert (figure["printed"], figure["computed"]) == (46, 45)


def test_the_ablation_differs_once_and_contradicts_itself_thrice(figures: Figures) -> None:
    assert marked(figures, "ablation", Mark.DIFFERENT) == {("Shelf", "no overhang")}
    assert "5 x 2 x 5" in figures["ablation", "Shelf", "no overhang"]["reason"]
    assert marked(figures, "ablation", Mark.CONTRADICTED) == {
        ("Shelf", "no connectivity"),
        ("Letter T", "no connectivity"),
        ("Table", "no stack"),
    }
    for name in ("Stool", "Shelf", "Letter T", "Table"):
        assert figures["ablation", name, "complete"]["computed"] == "pass"
    failing = {
        (row, column)
        for (table, row, column), figure in figures.items()
        if table == "ablation" and figure["computed"] == "fail"
    }
    assert failing == {
        ("Stool", "no count"),
        ("Stool", "no connectivity"),
        ("Shelf", "no count"),
        ("Letter T", "no stack"),
        ("Letter T", "no connectivity"),
        ("Table", "no stack"),
        ("Table", "no connectivity"),
    }


def test_the_naive_order_bears_out_the_text_and_not_table_1(figures: Figures) -> None:
    for name in ("Stool", "Shelf", "Letter T", "Table"):
        by_text = figures["order", name, "naive, text"]
        assert by_text["printed"] == by_text["computed"]
        assert figures["order", name, "connectivity, text"]["mark"] == Mark.EQUAL
    assert marked(figures, "order", Mark.CONTRADICTED) == {
        (name, column)
        for name in ("Shelf", "Letter T")
        for column in ("naive, table 1", "naive, text")
    }


def test_the_papers_path_takes_the_papers_time_in_metres_and_hours_in_millimetres(
    figures: Figures,
) -> None:
    path = "algorithm 5, 2 m/s, 1 m/s²"
    assert figures["time", "Letter T", path]["mark"] == Mark.EQUAL
    shelf = figures["time", "Shelf", path]
    assert shelf["mark"] == Mark.CONTRADICTED
    assert shelf["computed"] == pytest.approx(shelf["printed"], rel=0.05)
    for name in ("Stool", "Shelf", "Letter T", "Table"):
        assert figures["speed", name, "algorithm 5, 2 mm/s, 1 mm/s²"]["computed"] > 3 * 3600
        assert (
            figures["time", name, "routes of this cell"]["computed"]
            < figures["time", name, path]["computed"]
        )


def test_the_fdm_reference_is_a_quotient_of_times(figures: Figures) -> None:
    assembled = figures["fdm", "Stool", "assembled in"]
    faster = figures["fdm", "Stool", "faster than FDM"]
    assert faster["printed"] == round(73.75 * 3600 / assembled["printed"])
    # The time is shown rounded to a tenth of a second.
    assert faster["computed"] == pytest.approx(73.75 * 3600 / assembled["computed"], rel=1e-3)


def test_an_equal_is_an_equal_and_a_contradiction_beats_both() -> None:
    assert compared(30, 30, "").mark is Mark.EQUAL
    assert compared(30, 32, "why").mark is Mark.DIFFERENT
    assert compared(100.0, 109.0, "", tolerance=0.1).mark is Mark.EQUAL
    assert compared("pass", None, "why").mark is Mark.DIFFERENT
    both = compared(30, 30, "Why.", contradiction="Elsewhere 31.")
    assert both.mark is Mark.CONTRADICTED
    assert both.reason == "Elsewhere 31. Why."
    with pytest.raises(ValueError, match="has a reason"):
        Figure(printed=1, computed=2, mark=Mark.DIFFERENT)


def test_figures_as_people_write_them() -> None:
    assert quantity(45, "parts") == "45"
    assert quantity(216, "s") == "3m36s"
    assert quantity(59.7, "s") == "1m00s"
    assert quantity(50_506.1, "s") == "14.0 h"
    assert quantity(6496, "cm3") == "6496 cm³"
    assert quantity(1229, "times") == "1229x"
    assert quantity("pass", "") == "pass"
    assert quantity(None, "s") == "none"


def test_the_screen_shows_marks_and_numbered_reasons_within_100_columns() -> None:
    done = run()
    assert done.exit_code == 0
    lines = done.stdout.splitlines()
    assert max(len(line) for line in lines) <= 100
    assert any("46 ‡ 45¹" in line for line in lines)
    assert any(line.split()[0] == "Shelf" and "fail ≠ pass" in line for line in lines[1:] if line)
    assert any(line.strip().startswith("¹ Tables 2 and 3") for line in lines)
    assert "…" not in done.stdout  # nothing is cut off
    assert re.match(r"\d+ figures:  = \d+ equal  ≠ \d+ different  ‡ \d+ contradicted", lines[-1])


def test_one_table_by_name_and_its_json_in_a_file(tmp_path: Path) -> None:
    file = tmp_path / "paper.json"
    done = run("--table", "count", "--json", str(file))
    assert done.exit_code == 0
    assert "Component count" in done.stdout
    assert "Overhang" not in done.stdout
    assert [table["name"] for table in json.loads(file.read_text())["tables"]] == ["count"]


def test_help_names_every_table() -> None:
    shown = run("--help").stdout
    assert all(re.search(rf"\b{name}\b", shown) for name in TableName)


def test_times_are_left_out_with_the_reason_where_the_arm_cannot_reach() -> None:
    far = CONFIG.base.model_copy(update={"frame": (0.30, -3.0, 0.35, 0.0, 0.0, 0.0)})
    config = CONFIG.model_copy(update={"base": far})
    (table,) = compare(config, str, (TableName.TIME,)).tables
    for row in table.rows:
        _, routes = row.figures
        assert routes.computed is None
        assert "Not in the middle of this workspace" in routes.reason
    compare(config, str, (TableName.FDM, TableName.CLAIMS))


def test_other_parts_and_limits_of_the_cell_change_no_figure() -> None:
    voxel = CONFIG.voxel.model_copy(update={"pitch_m": 0.05})
    limits = CONFIG.limits.model_copy(update={"inventory_parts": 7})
    config = CONFIG.model_copy(update={"voxel": voxel, "limits": limits})
    names = (TableName.COUNT, TableName.ABLATION, TableName.TIME)
    assert compare(config, str, names).tables == compare(CONFIG, str, names).tables


def test_a_table_that_is_not_there_is_a_usage_error() -> None:
    done = run("--table", "counts")
    assert isinstance(done.exception, UsageError)
    assert "ablation" in (done.exception.hint or "")


def test_a_file_that_cannot_be_written_is_a_usage_error(tmp_path: Path) -> None:
    done = run("--table", "count", "--json", str(tmp_path / "none" / "a.json"))
    assert isinstance(done.exception, UsageError)
    assert "cannot be written" in done.exception.message
