"""Every part comes off by a way that the rest bears: closed forms, and whole orders replayed."""

from __future__ import annotations

import dataclasses
import math
from typing import Literal

import pytest

from cellctl.assembly import Cell, StepKind
from cellctl.errors import PlanError
from cellctl.validating.changing import Removal, assess_removal, plan_removal, removal_order
from cellctl.validating.changing.breaking import PULL, SLIDING, TWIST, breakings
from cellctl.validating.changing.removal import pull_of, while_breaking
from cellctl.validating.checker import verify
from cellctl.validating.rules import Cells
from cellctl.validating.stability import assess
from tests.validating.shapes import CONFIG
from tests.validating.structures import GRIPPER, PHYSICS, buildable, column, shelf, table

F, WEIGHT, MU = PHYSICS.magnet_force_n, PHYSICS.weight_n, PHYSICS.friction
BARE = dataclasses.replace(PHYSICS, floor_grips=False)


def replay(standing: Cells, order: tuple[Removal, ...], keep: Cells = frozenset()) -> None:
    """Carry an order out, and judge every state of it anew."""
    cells = standing
    for removal in order:
        cell = removal.cell
        assert cell in cells - keep
        assert not any(c.x == cell.x and c.y == cell.y and c.z > cell.z for c in cells)
        left = cells - {cell}
        assert not GRIPPER.blockers(cell, left)
        breaking = next(
            b
            for b in breakings(cells, cell, PHYSICS)
            if b.way == (removal.how, removal.direction, removal.hinge)
        )
        assert breaking.force_n == removal.force_n
        margin = min(while_breaking(left, breaking, PHYSICS).margin, assess(left, PHYSICS).margin)
        assert margin == pytest.approx(removal.margin)
        assert margin >= PHYSICS.least_margin
        cells = left
    assert cells == keep


def test_a_straight_pull_takes_the_magnets_the_friction_and_the_weight() -> None:
    def pull_n(*cells: Cell) -> float:
        ways = breakings(frozenset(cells), cells[0], PHYSICS)
        return next(breaking.force_n for breaking in ways if breaking.way == PULL)

    top, under = Cell(0, 0, 1), Cell(0, 0, 0)
    beside = (Cell(1, 0, 1), Cell(1, 0, 0))
    assert pull_n(top, under) == pytest.approx(F + WEIGHT)
    assert pull_n(top, under, *beside) == pytest.approx(F + MU * F + WEIGHT)


@pytest.mark.parametrize(("contact", "nearer"), [("square", 1.0), ("diamond", math.sqrt(2))])
def test_a_peel_takes_half_of_it_and_leaves_the_neighbour_a_couple(
    contact: Literal["square", "diamond"], nearer: float
) -> None:
    peel = breakings(column(2), Cell(0, 0, 1), dataclasses.replace(PHYSICS, contact=contact))[0]
    assert peel.way.how == "peel"
    # The hinge is a side of the contact: of a square on its corner, nearer to its centre.
    assert peel.force_n == pytest.approx((F + WEIGHT) / 2 / nearer)
    load = peel.loads[Cell(0, 0, 0)]
    assert load[:3] == pytest.approx([0.0, 0.0, 0.0])
    assert math.hypot(*load[3:5]) == pytest.approx(F * PHYSICS.pitch_m / 2 / nearer)


@pytest.mark.parametrize("height", [2, 3, 5])
def test_the_joint_beneath_is_spared_by_the_weight_alone(height: int) -> None:
    attempt = pull_of(column(height), Cell(0, 0, height - 1), PHYSICS)
    # The next joint has one part's weight less to bear than the magnets' full pull.
    assert attempt.verdict.margin == pytest.approx(F / (F - WEIGHT))


def test_a_part_that_hangs_out_is_peeled_upward() -> None:
    arm = column(3) | {Cell(x, 0, 2) for x in (1, 2, 3)}
    end = Cell(3, 0, 2)
    assert pull_of(arm, end, PHYSICS).removal is None
    removal = assess_removal(arm, end, PHYSICS).removal
    assert removal is not None
    assert removal.how == "peel"
    assert removal.direction == (-1, 0)
    # The couple works against what the rest of the arm weighs: two parts' lever of its own.
    assert removal.margin >= F / (F - WEIGHT)


def test_a_neighbour_in_the_way_bars_the_tilt() -> None:
    block = column(2) | {Cell(1, 0, 0), Cell(1, 0, 1)}
    found = [b.way for b in breakings(block, Cell(0, 0, 1), PHYSICS)]
    assert TWIST not in found
    assert not any(
        way.direction == (1, 0) and way.hinge is not None and way.hinge.up < 0 for way in found
    )
    higher = column(2) | {Cell(1, 0, z) for z in range(4)}
    assert not any(
        b.way.direction is not None and b.way.direction[0] > 0
        for b in breakings(higher, Cell(0, 0, 1), PHYSICS)
    )


def test_on_a_bare_floor_a_column_comes_along() -> None:
    attempt = assess_removal(column(3), Cell(0, 0, 2), BARE)
    assert attempt.removal is None
    assert attempt.verdict.margin == 0.0
    with pytest.raises(PlanError, match=r"cannot be taken away.*\[0, 0, 2\]"):
        removal_order(column(3), BARE, GRIPPER)


def test_a_part_whose_loss_drops_others_stays() -> None:
    arm = column(2) | {Cell(1, 0, 1), Cell(2, 0, 1)}
    attempt = assess_removal(arm, Cell(1, 0, 1), PHYSICS)
    assert attempt.removal is None
    assert attempt.verdict.moving == {Cell(2, 0, 1)}


@pytest.mark.parametrize(
    "cells",
    [shelf(5, 5, 2, 4), shelf(6, 6, 2, 5), table(4, 4, 4), column(5)],
    ids=["shelf of 32", "shelf of 40", "table", "column"],
)
def test_furniture_comes_apart(cells: Cells) -> None:
    order = removal_order(cells, PHYSICS, GRIPPER)
    replay(cells, order)


def test_what_is_kept_is_not_touched() -> None:
    cells = shelf(5, 5, 2, 4)
    keep = frozenset(cell for cell in cells if cell.z < 3)
    order = removal_order(cells, PHYSICS, GRIPPER, keep)
    replay(cells, order, keep)
    with pytest.raises(PlanError, match="nothing stands there"):
        removal_order(cells, PHYSICS, GRIPPER, frozenset({Cell(2, 0, 0)}))


def test_a_part_beneath_a_kept_one_is_refused_with_the_reason() -> None:
    with pytest.raises(PlanError, match=r"\[0, 0, 1\] in the way of the gripper"):
        removal_order(column(2), PHYSICS, GRIPPER, frozenset({Cell(0, 0, 1)}))


@pytest.mark.parametrize("seed", [0, 3, 6])
def test_random_structures_come_apart(seed: int) -> None:
    cells = buildable(seed, 8 + seed)
    order = removal_order(cells, PHYSICS, GRIPPER)
    replay(cells, order)
    plan = plan_removal(cells, CONFIG)
    assert tuple(step.cell for step in plan.steps) == tuple(step.cell for step in order)
    assert [check.name for check in verify(plan, CONFIG, standing=cells) if not check.passed] == []


def test_what_cannot_be_turned_away_from_its_neighbours_is_turned_along_them() -> None:
    cells = buildable(110, 16)
    order = removal_order(cells, PHYSICS, GRIPPER)
    replay(cells, order)
    assert any(removal.hinge in SLIDING for removal in order)
    plan = plan_removal(cells, CONFIG)
    assert all(check.passed for check in verify(plan, CONFIG, standing=cells))


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_thousands_of_random_structures_come_apart() -> None:
    refused = []
    for seed in range(100, 2100):
        cells = buildable(seed, 8 + seed % 17)
        try:
            order = removal_order(cells, PHYSICS, GRIPPER)
        except PlanError:
            refused.append(seed)
            continue
        replay(cells, order)
        judged = verify(plan_removal(cells, CONFIG), CONFIG, standing=cells)
        assert all(check.passed for check in judged), (seed, judged)
    # Some structures can be built and not be taken apart: pressing a part on loads the rest
    # less than breaking its joints does. 41 were refused when this was last looked at.
    assert len(refused) <= 45, refused


def test_the_plan_of_a_removal_is_complete_and_says_what_was_proven() -> None:
    cells = table(3, 3, 3)
    plan = plan_removal(cells, CONFIG, title="table")
    assert [step.index for step in plan.steps] == list(range(len(cells)))
    assert {step.cell for step in plan.steps} == cells
    assert all(step.kind is StepKind.REMOVE for step in plan.steps)
    assert plan.assembly.cells == ()
    assert plan.parts == 0
    assert [check.name for check in plan.checks] == ["stability", "removal"]
    assert all(check.passed for check in plan.checks)
    assert all(check.passed for check in verify(plan, CONFIG, standing=cells))
    assert plan.plan_id == plan_removal(cells, CONFIG).plan_id


def test_a_full_belt_takes_no_parts_back() -> None:
    with pytest.raises(PlanError, match="has room for 3 more"):
        plan_removal(table(3, 3, 3), CONFIG, parts_on_belt=CONFIG.feeder.capacity_parts - 3)
    with pytest.raises(PlanError, match="Nothing stands"):
        plan_removal(frozenset(), CONFIG)
