"""The arm's way to every step of a plan that takes parts away, proven while planning."""

from __future__ import annotations

import itertools

from cellctl.assembling.route import SETTING_OUT_S, Route, RoutePlanner, Stance
from cellctl.assembly import BuildPlan, Cell, Check, Step, StepKind, TakeOff
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.validating.rules import Cells

_PULL = TakeOff(how="pull", force_n=0.0)


def routed(
    plan: BuildPlan, standing: Cells, config: CellConfig, planner: RoutePlanner | None = None
) -> BuildPlan:
    """The same plan with the height and the time of each step, and a check that all can be reached.

    A part that is taken off goes to the pick station, or, where a part is placed next, straight to
    its new cell.

    Args:
        plan: its steps place and remove parts.
        standing: what stands before the first step.
        config: the cell.
        planner: its routes.

    Raises:
        PlanError: the arm cannot get to a part, take it off as stated, or bring it where it goes.
    """
    planner = planner or RoutePlanner(config)
    now, at, holding = set(standing), planner.home, False
    steps: list[Step] = []
    bring: Route | None
    for step, after in itertools.zip_longest(plan.steps, plan.steps[1:]):
        took_s, height_m = 0.0, 0.0
        try:
            if step.kind is StepKind.PLACE:
                if not holding:
                    fetch = planner.to_pick(at, now)
                    at, took_s = fetch.end, fetch.duration_s + planner.closing_s
                bring = planner.to_seat(step.cell, at, now)
                took_s += planner.placing_s(step.cell, now)
                now.add(step.cell)
                holding = False
            else:
                at, took_s = _taken(planner, step, now, at)
                now.discard(step.cell)
                holding = after is not None and after.kind is StepKind.PLACE
                bring = None if holding else planner.to_station(now, at)
                took_s += 0.0 if holding else planner.opening_s
        except PlanError as error:
            what = "placed at" if step.kind is StepKind.PLACE else "taken from"
            raise PlanError(
                f"The arm cannot do step {step.index + 1}, a part {what} {list(step.cell)}: "
                f"{error.message}",
                error.hint,
                rule="reach",
                cells=(step.cell,),
            ) from error
        if bring is not None:
            placed = step.kind is StepKind.PLACE
            at, height_m = (
                planner.freed(step.cell) if placed else bring.end,
                bring.crossing_height_m,
            )
            took_s += bring.duration_s
        steps.append(
            step.model_copy(
                update={
                    "clearance_m": round(height_m, 4) if bring is not None else None,
                    "duration_s": round(took_s, 3),
                }
            )
        )
    reach = Check(
        name="reach", passed=True, message="The arm reaches every part, and takes it off."
    )
    return plan.model_copy(update={"steps": tuple(steps), "checks": (*plan.checks, reach)})


def _taken(planner: RoutePlanner, step: Step, now: set[Cell], at: Stance) -> tuple[Stance, float]:
    """Where the arm is when it has taken a part off, and how long that takes."""
    there = planner.to_grip(step.cell, now, at)
    off = planner.take_off(step.cell, step.take_off or _PULL, now, there.end)
    gripped_s = there.duration_s + planner.gripping_s
    return off.end, gripped_s + SETTING_OUT_S + off.duration_s
