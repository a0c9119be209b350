"""What ``cellctl plan`` reports: one document for programs, from a plan or from its refusal.

The JSON schema in docs/reference is generated from ``PlanReport``. Programs may rely on it: fields
are added, never renamed, and ``schema_version`` rises when one changes its meaning.
"""

from __future__ import annotations

import math
from typing import Annotated, Final, Literal

from pydantic import ConfigDict, Field

from cellctl.assembly import (
    BuildPlan,
    Cell,
    Change,
    Check,
    Step,
    StepKind,
    TakeOff,
    Value,
    Weakest,
)
from cellctl.config import CellConfig
from cellctl.errors import (
    CellctlError,
    DesignError,
    Nearest,
    NoObjectError,
    PlanError,
    UsageError,
)

SCHEMA_VERSION: Final = 1

InputKind = Literal["sentence", "description", "mesh", "cells"]
"""``cells``: a JSON file of cells or of a plan."""


class Described(Value):
    """Base of the report's values: their docstrings are the schema's descriptions."""

    model_config = ConfigDict(
        use_attribute_docstrings=True, json_schema_serialization_defaults_required=True
    )


class PlanInput(Described):
    """What was asked for."""

    given: str
    """The sentence or the file, as it was typed."""
    kind: InputKind
    """How it was read; `cells` is a JSON file of cells or of a plan."""
    height_m: float | None = None
    """The height that was asked for beside it."""
    up: Literal["auto", "y", "z"] = "auto"
    """Which axis of a mesh was to point up."""
    standing: str | None = None
    """The file of what stands before, as it was typed; null where nothing does."""
    take_apart: bool = False
    """Whether the input is what stands, and is to be taken away."""


class Placement(Described):
    """One step of the plan."""

    index: int
    """Its place in the order, from 0."""
    kind: StepKind
    """Whether a part is put there or taken away."""
    cell: Cell
    """[x, y, z] in cells from the workspace's corner; z is up and layer 0 stands on the floor."""
    margin: float | None
    """How many times stronger the magnets are than this step needs; null where it needs none."""
    clearance_m: float | None
    """Height of the tool's centre above the floor while the part crosses; null where unknown."""
    duration_s: float | None
    """Predicted time in the cell; null where unknown."""
    take_off: TakeOff | None
    """Of a removal: how the part comes off; null of a placement."""


class Refused(Described):
    """Why there is no plan."""

    rule: str
    """Name of the check that fails, such as `overhang` or `stability`; else `input` (the file
    cannot be used), `request` (it asks for no object), `design` (nobody can draw it), `plan` (no
    single rule is to blame) or `internal`."""
    message: str
    """What is wrong, and where."""
    hint: str
    """What to do about it; may be empty."""
    cells: tuple[Cell, ...]
    """The cells that fail the rule; empty where no cells are to blame."""
    nearest: Nearest | None
    """The nearest thing that could be built; null where none is known."""
    exit_status: int
    """That of the command."""


class PlanReport(Described):
    """What would be built, in what order, how safely, and what was changed to get there."""

    schema_version: Literal[1] = SCHEMA_VERSION
    """Rises when a field changes its meaning."""
    input: PlanInput
    """What was asked for, and how it was read."""
    refused: Refused | None
    """Why there is no plan; null where there is one."""
    title: str
    """What it is, for people; empty where it was refused before anybody knew."""
    plan_id: str | None
    """The same object in the same cell has the same; null where there is no plan."""
    provenance: str
    """Where the shape came from."""
    policy: str
    """Which rules it was planned by: `cellctl` or `paper`."""
    pitch_m: float
    """Edge of a cell."""
    parts: int
    """How many parts are placed."""
    size_m: tuple[float, float, float]
    """Width, depth and height of the finished object."""
    cells: tuple[Cell, ...]
    """The finished object, sorted by z, x, y."""
    placements: tuple[Placement, ...]
    """The steps, in order."""
    margin: float | None
    """The least margin of all steps; null where no step needs a magnet."""
    weakest: Weakest | None
    """The joint that comes nearest to giving way, and when; null where that is not known."""
    checks: tuple[Check, ...]
    """Every question that was asked of the plan, and its answer."""
    changes: tuple[Change, ...]
    """What is different from what was asked for, and why."""
    questions: tuple[str, ...]
    """What a person must be asked before it is built."""
    score: float | None
    """How much of the shape is kept, from 0 to 1; null where nothing had to be sought."""
    baseline_score: float | None
    """The same of what the paper's rescaling makes of the shape; null where unknown, and where it
    keeps more but breaks a rule or was not found to stand."""
    bound: float | None
    """No object has a higher score than this, of those that have the symmetry of the shape, no gaps
    that it has not, no rows that reach out too far to be sought, and no edge that is longer than
    its; null where unknown."""
    proven: bool | None
    """Whether none of those objects has a higher score than the planned one; null where nothing had
    to be sought."""
    duration_s: float | None
    """Predicted time in the cell of all steps; null where unknown."""
    budget_s: float
    """How long the plan might be improved (wall time)."""
    planning_s: Annotated[float, Field(ge=0.0)]
    """How long planning took (wall time)."""

    @property
    def weakest_placement(self) -> Placement | None:
        """The step with the least margin, the first of them; None where none needs a magnet."""
        needing = [step for step in self.placements if step.margin is not None]
        return min(needing, key=lambda step: step.margin or 0.0, default=None)


def report_plan(
    plan: BuildPlan, asked: PlanInput, config: CellConfig, planning_s: float
) -> PlanReport:
    """The report of a plan.

    Args:
        plan: what was planned.
        asked: what it was planned for.
        config: the cell, with the policy and the budget that it was planned with.
        planning_s: how long that took, wall time.
    """
    placements = tuple(_placement(step) for step in plan.steps)
    margins = [step.margin for step in placements if step.margin is not None]
    durations = [step.duration_s for step in placements if step.duration_s is not None]
    near = plan.closeness
    width, depth, height = (round(edge * plan.pitch_m, 6) for edge in plan.assembly.size)
    return PlanReport(
        input=asked,
        refused=None,
        title=plan.title,
        plan_id=plan.plan_id,
        provenance=plan.provenance,
        policy=plan.policy,
        pitch_m=plan.pitch_m,
        parts=plan.parts,
        size_m=(width, depth, height),
        cells=plan.assembly.cells,
        placements=placements,
        margin=min(margins, default=None),
        weakest=plan.weakest,
        checks=plan.checks,
        changes=plan.changes,
        questions=plan.questions,
        score=near.score if near is not None else None,
        baseline_score=near.baseline_score if near is not None else None,
        bound=near.bound if near is not None else None,
        proven=near.proven if near is not None else None,
        duration_s=round(sum(durations), 3) if len(durations) == len(placements) else None,
        budget_s=config.planning.budget_s,
        planning_s=round(planning_s, 3),
    )


def report_refusal(
    error: CellctlError, asked: PlanInput, config: CellConfig, planning_s: float
) -> PlanReport:
    """The report of a refusal; arguments as for ``report_plan``."""
    planned = error if isinstance(error, PlanError) else None
    return PlanReport(
        input=asked,
        refused=Refused(
            rule=_rule(error),
            message=error.message,
            hint=error.hint,
            cells=planned.cells if planned is not None else (),
            nearest=planned.nearest if planned is not None else None,
            exit_status=int(error.exit_status),
        ),
        title="",
        plan_id=None,
        provenance="",
        policy=config.planning.policy,
        pitch_m=config.voxel.pitch_m,
        parts=0,
        size_m=(0.0, 0.0, 0.0),
        cells=(),
        placements=(),
        margin=None,
        weakest=None,
        checks=(),
        changes=(),
        questions=(),
        score=None,
        baseline_score=None,
        bound=None,
        proven=None,
        duration_s=None,
        budget_s=config.planning.budget_s,
        planning_s=round(planning_s, 3),
    )


def _placement(step: Step) -> Placement:
    needs = step.margin is not None and math.isfinite(step.margin)
    return Placement(
        index=step.index,
        kind=step.kind,
        cell=step.cell,
        margin=step.margin if needs else None,
        clearance_m=step.clearance_m,
        duration_s=step.duration_s,
        take_off=step.take_off,
    )


def _rule(error: CellctlError) -> str:
    match error:
        case PlanError():
            return error.rule or "plan"
        case DesignError():
            return "design"
        case NoObjectError():
            return "request"
        case UsageError():
            return "input"
        case _:
            return "internal"
