"""Algorithms 2 to 4 on one shape: the policy ``paper``.

The modules run in the order of the paper: component count, overhang, vertical stack, and then the
sequence. Scaling for one may break another, since the shape is voxelised anew, so they run again
until none changes anything; where the printed single pass suffices, this is that pass. It ends,
because each change makes the shape a cell shorter along some axis.

The paper's thresholds are all that this policy looks at. It does not ask whether the parts hold at
every step, and its measure of overhang is blind to some rows: the check says to how many parts.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from cellctl.assembly import Cell, Change, Check
from cellctl.config import LimitsSection
from cellctl.errors import PlanError
from cellctl.validating import words
from cellctl.validating.fit import Shape
from cellctl.validating.paper.counting import within_count
from cellctl.validating.paper.scaling import Rescaled, occupy, to_corner
from cellctl.validating.paper.sequencing import Order, connectivity_order, naive_order
from cellctl.validating.paper.steadying import cantilevers, unseen, within_overhang, within_stack
from cellctl.validating.rules import Cells, check_count, check_stack


class Module(StrEnum):
    """The four modules of the ablation study (section 4.2), in the order in which they run."""

    COUNT = "count"
    OVERHANG = "overhang"
    STACK = "stack"
    CONNECTIVITY = "connectivity"


COMPLETE: Final = frozenset(Module)


@dataclass(frozen=True)
class PaperPlan:
    """What the paper's policy would build, and how."""

    cells: Cells
    """From [0, 0, 0] at the minimum corner of their bounding box."""
    order: tuple[Cell, ...]
    checks: tuple[Check, ...]
    """Always count, overhang, stack, connectivity, access; all passed."""
    changes: tuple[Change, ...]


def plan_paper(shape: Shape, limits: LimitsSection, parts: int) -> PaperPlan:
    """Voxelise a shape, rescale it by the paper's rules, and order its parts.

    Args:
        shape: measured in cells, within the workspace.
        limits: most cells of overhang and of a free-standing column.
        parts: how many parts there are.

    Raises:
        PlanError: there are no parts; or the algorithm would put parts into the air, or beneath
            others. The paper's fallback would do so; nothing would hold them, so it is refused.
    """
    processed = process(shape, limits, parts)
    order = connectivity_order(processed.cells)
    return _accepted(processed.cells, order, limits, parts, processed.changes)


def plan_paper_cells(cells: Iterable[Cell], limits: LimitsSection, parts: int) -> PaperPlan:
    """Check and order cells as they are; only shapes are rescaled.

    Args:
        cells: at least one.
        limits: most cells of overhang and of a free-standing column.
        parts: how many parts there are.

    Raises:
        PlanError: they break one of the paper's rules; the message says which, and where.
    """
    moved = to_corner(cells)
    return _accepted(moved, connectivity_order(moved), limits, parts, ())


def process(
    shape: Shape,
    limits: LimitsSection,
    parts: int,
    modules: frozenset[Module] = COMPLETE,
    occupied: Cells = frozenset(),
) -> Rescaled:
    """The rescaling modules, or some of them, until none changes anything.

    Args:
        shape: measured in cells.
        limits: most cells of overhang and of a free-standing column.
        parts: how many parts there are.
        modules: those that run.
        occupied: its cells, where they are known already.

    Raises:
        PlanError: there are no parts.
    """
    found = Rescaled(shape, to_corner(occupied)) if occupied else occupy(shape)
    while True:
        before = found
        if Module.COUNT in modules:
            found = within_count(found, parts)
        if Module.OVERHANG in modules:
            found = within_overhang(found, limits.overhang_cells)
        if Module.STACK in modules:
            found = within_stack(found, limits.stack_cells)
        if found is before:
            return found


def order_by(cells: Cells, modules: frozenset[Module] = COMPLETE) -> Order:
    """Algorithm 4, or the simple sorting where its module is left out."""
    return connectivity_order(cells) if Module.CONNECTIVITY in modules else naive_order(cells)


def judge(cells: Cells, order: Order, limits: LimitsSection, parts: int) -> tuple[Check, ...]:
    """Every rule of the paper, and whether each part can be lowered into its place."""
    return (
        check_count(cells, parts),
        _check_overhang(cells, limits.overhang_cells),
        check_stack(cells, limits.stack_cells),
        _check_connectivity(order),
        _check_access(order),
    )


def _accepted(
    cells: Cells, order: Order, limits: LimitsSection, parts: int, changes: tuple[Change, ...]
) -> PaperPlan:
    checks = judge(cells, order, limits, parts)
    for check in checks:
        if not check.passed:
            raise PlanError(
                f"It breaks the Speech-to-Reality paper's rule of {check.name}: {check.message} "
                f"Cells: {words.named(check.cells)}.",
                'Ask for another shape, or plan with planning.policy = "cellctl".',
                rule=check.name,
                cells=check.cells,
            )
    return PaperPlan(cells, order.cells, checks, changes)


def _check_overhang(cells: Cells, limit: int) -> Check:
    rows = cantilevers(cells)
    longest = len(rows[0].cells) if rows else 0
    beyond = frozenset(cell for row in rows for cell in row.cells[limit:])
    blind = len(unseen(cells))
    message = (
        f"The longest straight overhang is {words.parts(longest)}; the limit is {limit}."
        if longest
        else "No row hangs out straight from a part that rests."
    )
    if blind:
        message += (
            " The rule does not see rows in which no part rests: "
            f"{blind} of {words.parts(len(cells))}."
        )
    return Check(name="overhang", passed=not beyond, message=message, cells=_by_layer(beyond))


def _check_connectivity(order: Order) -> Check:
    message = (
        f"{len(order.mid_air)} of {words.parts(len(order.cells))} would be put into the air."
        if order.mid_air
        else "Every part is joined to the floor when it is placed."
    )
    return Check(
        name="connectivity",
        passed=not order.mid_air,
        message=message,
        cells=_by_layer(order.mid_air),
    )


def _check_access(order: Order) -> Check:
    beneath = order.beneath
    message = (
        f"{len(beneath)} of {words.parts(len(order.cells))} would be put beneath what stands "
        "already."
        if beneath
        else "Every part can be lowered into its place."
    )
    return Check(name="access", passed=not beneath, message=message, cells=_by_layer(beneath))


def _by_layer(cells: Iterable[Cell]) -> tuple[Cell, ...]:
    return tuple(sorted(cells, key=lambda c: (c.z, c.x, c.y)))
