"""The report: what stands in it of a plan, and of a refusal."""

from __future__ import annotations

import json
import pickle

import pytest

from cellctl.assembly import Cell, Closeness, StepKind
from cellctl.cli.plan_report import PlanInput, PlanReport, report_plan, report_refusal
from cellctl.cli.reference_plan import plan_schema
from cellctl.config import load_config
from cellctl.errors import (
    CellctlError,
    CellFault,
    DesignError,
    Nearest,
    NoObjectError,
    PlanError,
    UsageError,
)
from tests.cell.harness import CONFIG
from tests.cli.plans import BEAM, WEAKEST, beam, changeover, placing, plan_of

SETTINGS = load_config(CONFIG)
ASKED = PlanInput(given="a beam", kind="sentence")


def test_a_report_has_the_steps_and_the_least_margin_of_all() -> None:
    report = report_plan(beam(), ASKED, SETTINGS, 1.23456)
    assert report.refused is None
    assert [step.cell for step in report.placements] == list(BEAM)
    # Where no magnet is needed, whether that is told as nothing or as infinity, there is none.
    assert [step.margin for step in report.placements] == [None, None, 4.0, 1.5]
    assert report.margin == 1.5
    assert report.weakest_placement == report.placements[3]
    assert report.weakest == WEAKEST
    assert report.size_m == (0.3, 0.1, 0.2)
    assert report.cells == beam().assembly.cells
    assert report.parts == 4
    assert report.duration_s == 20.0
    assert report.planning_s == 1.235
    assert report.budget_s == SETTINGS.planning.budget_s


def test_a_plan_that_needs_no_magnet_has_no_margin() -> None:
    report = report_plan(plan_of(placing(BEAM[:2]), BEAM[:2]), ASKED, SETTINGS, 0.0)
    assert report.margin is None
    assert report.weakest_placement is None
    assert report.weakest is None


def test_how_close_it_is_comes_from_the_plan() -> None:
    near = Closeness(score=0.9, baseline_score=0.7, bound=0.95, proven=False)
    report = report_plan(beam(near), ASKED, SETTINGS, 0.0)
    assert (report.score, report.baseline_score) == (0.9, 0.7)
    assert (report.bound, report.proven) == (0.95, False)
    assert report_plan(beam(), ASKED, SETTINGS, 0.0).proven is None


def test_steps_that_take_away_are_told_apart() -> None:
    report = report_plan(changeover(), ASKED, SETTINGS, 0.0)
    kinds = [step.kind for step in report.placements]
    assert kinds == [StepKind.REMOVE, StepKind.REMOVE, StepKind.PLACE]
    assert report.parts == 1
    assert report.duration_s is None


@pytest.mark.parametrize(
    ("error", "rule", "status"),
    [
        (PlanError("It hangs.", "Make it smaller.", rule="overhang"), "overhang", 4),
        (PlanError("It cannot be."), "plan", 4),
        (DesignError("A dragon?"), "design", 4),
        (NoObjectError("Beauty is none."), "request", 3),
        (UsageError("No such file."), "input", 2),
        (CellFault("internal"), "internal", 5),
    ],
)
def test_a_refusal_names_its_rule(error: CellctlError, rule: str, status: int) -> None:
    report = report_refusal(error, ASKED, SETTINGS, 0.0)
    assert report.refused is not None
    assert report.refused.rule == rule
    assert report.refused.message == error.message
    assert report.refused.hint == error.hint
    assert report.refused.exit_status == status
    assert report.placements == ()
    assert report.margin is None


def test_a_refusal_has_the_cells_and_the_nearest_thing() -> None:
    nearest = Nearest(what="A beam with an arm of three.", cells=BEAM)
    error = PlanError("It hangs.", "", rule="overhang", cells=(Cell(3, 0, 1),), nearest=nearest)
    refused = report_refusal(error, ASKED, SETTINGS, 0.0).refused
    assert refused is not None
    assert refused.cells == (Cell(3, 0, 1),)
    assert refused.nearest == nearest


def test_a_refusal_keeps_what_it_knows_on_its_way_between_processes() -> None:
    error = PlanError("No.", "So.", "overhang", (Cell(3, 0, 1),), Nearest(what="Less."))
    arrived = pickle.loads(pickle.dumps(error))  # noqa: S301 - our own bytes
    assert (str(arrived), arrived.rule) == ("No. What could be built: Less. So.", "overhang")
    assert (arrived.cells, arrived.nearest) == (error.cells, error.nearest)


def test_a_report_is_json_as_its_schema_says() -> None:
    schema = json.loads(plan_schema())
    near = Closeness(score=1.0, proven=True)
    for report in (
        report_plan(beam(near), ASKED, SETTINGS, 0.5),
        report_refusal(PlanError("No."), ASKED, SETTINGS, 0.5),
    ):
        text = report.model_dump_json()
        assert PlanReport.model_validate_json(text) == report
        assert set(json.loads(text)) == set(schema["required"]) == set(schema["properties"])
    assert all("description" in field for field in schema["properties"].values())
