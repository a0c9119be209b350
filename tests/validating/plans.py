"""Plans for the tests of the planner: bare steps, with no route and no checks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cellctl.assembly import Assembly, BuildPlan, Cell, Step, StepKind
from tests.validating.shapes import CONFIG


def plan_of(
    order: Sequence[Cell],
    *,
    kinds: Sequence[StepKind] | None = None,
    end: Iterable[Cell] | None = None,
    index_from: int = 0,
) -> BuildPlan:
    """A plan that places cells in an order, or does what ``kinds`` says."""
    done = kinds or [StepKind.PLACE] * len(order)
    return BuildPlan(
        plan_id="test",
        title="thing",
        pitch_m=CONFIG.voxel.pitch_m,
        assembly=Assembly.of(order if end is None else end, CONFIG.voxel.pitch_m),
        steps=tuple(
            Step(index=number, kind=kind, cell=cell)
            for number, (cell, kind) in enumerate(zip(order, done, strict=True), index_from)
        ),
        checks=(),
    )
