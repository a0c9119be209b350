"""A job step by step, as the journal has it: what stood after each, and how it went."""

from __future__ import annotations

from dataclasses import dataclass

from cellctl.assembly import Cell, StepKind
from cellctl.messages import JobRecordData


@dataclass(frozen=True)
class Moment:
    """The object after some of a job's steps."""

    standing: tuple[Cell, ...]
    planned: tuple[Cell, ...]
    """What is still to come."""
    kind: StepKind | None
    """What was done last; None before the first step."""
    cell: Cell | None
    seconds: float
    """Cell time from the job's first step to here."""
    took_s: float
    retries: int


def moments(record: JobRecordData) -> tuple[Moment, ...]:
    """What stood before the first step of a job and after each that was done.

    A plan takes off what stood before it; what its object has without a step for it, stood before.
    """
    plan = record.plan
    if plan is None:
        return ()
    wanted = frozenset(plan.assembly.cells)
    touched: dict[Cell, StepKind] = {}
    for step in plan.steps:
        touched.setdefault(step.cell, step.kind)
    taken_first = {cell for cell, kind in touched.items() if kind is StepKind.REMOVE}
    standing = (wanted - touched.keys()) | taken_first
    told = [Moment(_sorted(standing), _sorted(wanted - standing), None, None, 0.0, 0.0, 0)]
    seconds = 0.0
    for part in record.parts:
        placed = part.kind is StepKind.PLACE
        standing = standing | {part.cell} if placed else standing - {part.cell}
        seconds += part.seconds
        told.append(
            Moment(
                _sorted(standing),
                _sorted(wanted - standing),
                part.kind,
                part.cell,
                seconds,
                part.seconds,
                part.retries,
            )
        )
    return tuple(told)


def _sorted(cells: frozenset[Cell]) -> tuple[Cell, ...]:
    return tuple(sorted(cells))
