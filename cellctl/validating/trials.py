"""A plan as it is built in a trial of a pace: in the middle, of columns, with that pace's times.

Where an object stands must not depend on the pace, or its times could not be compared; and near the
arm's base its joints bear least. So it stands in the middle of the workspace, wherever a build of
it would.
"""

from __future__ import annotations

from cellctl.assembling.route import RoutePlanner
from cellctl.assembly import Assembly, BuildPlan, Pace, Step
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.validating.plan import recheck
from cellctl.validating.rules import size_of


def plan_trial(plan: BuildPlan, pace: Pace, config: CellConfig) -> BuildPlan:
    """The same object in the same order, for a trial.

    Raises:
        PlanError: it cannot be built there, the arm does not bear the pace at some cell, or would
            not feel whether the part there stands.
    """
    return paced(recheck(centred(plan, config), config), pace, config)


def centred(plan: BuildPlan, config: CellConfig) -> BuildPlan:
    """The same plan moved to the middle of the workspace; what was proven of it where it stood is
    left out."""
    order = [step.cell for step in plan.steps]
    size = size_of(frozenset(order))
    dx, dy = (
        (config.grid[axis] - size[axis]) // 2 - min(cell[axis] for cell in order) for axis in (0, 1)
    )
    moved = [cell._replace(x=cell.x + dx, y=cell.y + dy) for cell in order]
    steps = tuple(
        step.model_copy(update={"cell": cell}) for step, cell in zip(plan.steps, moved, strict=True)
    )
    return plan.model_copy(
        update={
            "assembly": Assembly.of(moved, plan.pitch_m),
            "steps": steps,
            "weakest": None,
            "wanted": (),
        }
    )


def paced(plan: BuildPlan, pace: Pace, config: CellConfig) -> BuildPlan:
    """The same plan with the times of a pace that is under trial.

    Raises:
        PlanError: the arm does not bear it at some cell, or would not feel whether the part there
            stands.
    """
    planner = RoutePlanner(config)
    steps: list[Step] = []
    for step in plan.steps:
        done = [before.cell for before in steps]
        if config.gripper.port is None and not planner.presses(step.cell, done):
            raise PlanError(
                f"Whether the part at {list(step.cell)} stands could not be felt: only one on a "
                "column down to the floor is pressed on, and no board of the gripper feels parts.",
                "Try an object of columns, with robot.touch_depth_m more than 0, or connect the "
                "gripper's board and name its port as gripper.port.",
                cells=(step.cell,),
            )
        try:
            route = planner.step(step.cell, done, done[-1] if done else None, pace)
        except PlanError as error:
            raise PlanError(
                f"{list(step.cell)}: {error.message}", error.hint, rule="reach", cells=(step.cell,)
            ) from error
        told = {
            "clearance_m": round(route.clearance_m, 4),
            "duration_s": round(route.duration_s, 3),
        }
        steps.append(step.model_copy(update=told))
    return plan.model_copy(update={"steps": tuple(steps)})
