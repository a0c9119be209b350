"""Plans of a few parts, made by hand, for the tests of what is shown of them."""

from __future__ import annotations

from collections.abc import Iterable

from cellctl.assembly import (
    Assembly,
    BuildPlan,
    Cell,
    Change,
    Check,
    Closeness,
    Step,
    StepKind,
    Weakest,
)

BEAM = (Cell(0, 0, 0), Cell(0, 0, 1), Cell(1, 0, 1), Cell(2, 0, 1))
"""A column of two with an arm of two, in the order in which it is placed."""


def placing(cells: Iterable[Cell], margins: Iterable[float | None] = ()) -> tuple[Step, ...]:
    """Steps that place cells in this order; margins and durations as far as they are given."""
    known = list(margins)
    return tuple(
        Step(
            index=index,
            kind=StepKind.PLACE,
            cell=cell,
            clearance_m=0.3,
            duration_s=5.0,
            margin=known[index] if index < len(known) else None,
        )
        for index, cell in enumerate(cells)
    )


def plan_of(
    steps: tuple[Step, ...],
    cells: Iterable[Cell],
    *,
    weakest: Weakest | None = None,
    closeness: Closeness | None = None,
) -> BuildPlan:
    """A plan with these steps for an object of these cells."""
    return BuildPlan(
        plan_id="0123456789abcdef",
        title="beam",
        pitch_m=0.1,
        assembly=Assembly.of(cells, 0.1),
        steps=steps,
        checks=(Check(name="stability", passed=True, message="It stands."),),
        changes=(Change(what="One leg moved in.", why="It would have tipped."),),
        questions=("Shall I build it so?",),
        provenance="by hand",
        weakest=weakest,
        closeness=closeness,
    )


WEAKEST = Weakest(
    step=3,
    margin=1.5,
    cell=Cell(1, 0, 1),
    other=Cell(0, 0, 1),
    description="between [1, 0, 1] and [0, 0, 1]",
)


def beam(closeness: Closeness | None = None) -> BuildPlan:
    """The beam, with margins, its weakest joint being where the arm begins."""
    steps = placing(BEAM, (float("inf"), None, 4.0, 1.5))
    return plan_of(steps, BEAM, weakest=WEAKEST, closeness=closeness)


def changeover() -> BuildPlan:
    """From the beam to a higher column: two parts of the arm go, one comes on top, two stay."""
    steps = (
        Step(index=0, kind=StepKind.REMOVE, cell=Cell(2, 0, 1)),
        Step(index=1, kind=StepKind.REMOVE, cell=Cell(1, 0, 1)),
        Step(index=2, kind=StepKind.PLACE, cell=Cell(0, 0, 2)),
    )
    return plan_of(steps, (Cell(0, 0, 0), Cell(0, 0, 1), Cell(0, 0, 2)))


def standing_already() -> BuildPlan:
    """The beam is wanted where it stands: no step is left."""
    return plan_of((), BEAM)


def taking_apart() -> BuildPlan:
    """Every part of the beam goes, the last one placed first."""
    steps = tuple(
        Step(index=index, kind=StepKind.REMOVE, cell=cell)
        for index, cell in enumerate(reversed(BEAM))
    )
    return plan_of(steps, ())
