"""From one object to the next: what can stay stays, and every state on the way stands."""

from __future__ import annotations

import pytest

from cellctl.assembly import Cell, StepKind
from cellctl.errors import PlanError
from cellctl.validating.changing import Belt, ChangeOver, change_over, plan_change_over
from cellctl.validating.changing.alignment import Transform, alignments
from cellctl.validating.checker import verify
from cellctl.validating.rules import Cells
from cellctl.validating.stability import assess
from tests.validating.shapes import CONFIG
from tests.validating.structures import GRID, GRIPPER, PHYSICS, buildable, column, shelf, table


def replay(standing: Cells, wanted: Cells, found: ChangeOver) -> None:
    """Carry a change-over out, and judge every state of it anew."""
    cells = standing
    for step in found.steps:
        assert step.cell not in found.kept
        assert not GRIPPER.blockers(step.cell, cells - {step.cell})
        if step.kind is StepKind.REMOVE:
            assert step.cell in cells
            assert step.removal is not None
            cells -= {step.cell}
            assert assess(cells, PHYSICS).margin >= PHYSICS.least_margin
        else:
            assert step.cell not in cells
            cells |= {step.cell}
            assert assess(cells, PHYSICS, step.cell).margin >= PHYSICS.least_margin - 1e-6
        assert step.margin >= PHYSICS.least_margin
    assert cells == found.wanted_cells == found.transform.applied(wanted)
    assert all(0 <= i < n for c in cells for i, n in zip(c, GRID, strict=True))
    assert found.kept <= standing & cells
    assert (
        found.moves
        == len(found.steps)
        == len(standing ^ cells) + 2 * len((standing & cells) - found.kept)
    )
    assert found.moves + found.moves_saved == len(standing) + len(wanted)


def test_the_same_object_needs_no_move_wherever_it_is_asked_for() -> None:
    cells = table(4, 3, 4)
    asked = Transform(False, 1, (1, 1)).applied(cells)
    found = change_over(cells, asked, GRID, PHYSICS, GRIPPER)
    replay(cells, asked, found)
    assert found.steps == ()
    assert found.kept == cells
    assert found.moves_saved == 2 * len(cells)


def test_a_higher_shelf_keeps_much_of_the_lower() -> None:
    before, after = shelf(5, 5, 2, 4), shelf(6, 6, 2, 5)
    found = change_over(before, after, GRID, PHYSICS, GRIPPER)
    replay(before, after, found)
    assert len(before) + len(after) == 72
    assert found.moves <= 44


def test_building_on_costs_what_is_new() -> None:
    before, after = column(2), column(4)
    found = change_over(before, after, GRID, PHYSICS, GRIPPER)
    replay(before, after, found)
    assert [step.cell.z for step in found.steps] == [2, 3]


def test_an_object_where_nothing_stands_is_built() -> None:
    wanted = table(3, 3, 3)
    found = change_over(frozenset(), wanted, GRID, PHYSICS, GRIPPER)
    replay(frozenset(), wanted, found)
    assert found.moves == len(wanted)


def test_a_mirror_image_serves_only_where_it_may() -> None:
    # Three feet of different heights around a corner: no turn makes it its mirror image.
    left = column(3) | {Cell(1, 0, 0), Cell(1, 0, 1), Cell(0, 1, 0)}
    right = Transform(True, 0, (0, 0)).applied(left)
    assert change_over(left, right, GRID, PHYSICS, GRIPPER).moves > 0
    mirrored = change_over(left, right, GRID, PHYSICS, GRIPPER, mirrors=True)
    assert mirrored.moves == 0
    assert mirrored.transform.mirrored


def test_what_the_arm_cannot_reach_is_no_place() -> None:
    found = change_over(
        frozenset(), column(2), GRID, PHYSICS, GRIPPER, reachable=lambda cell: cell.x == 4
    )
    assert {cell.x for cell in found.wanted_cells} == {4}
    with pytest.raises(PlanError, match="does not fit"):
        change_over(column(1), column(GRID[2] + 1), GRID, PHYSICS, GRIPPER)


def test_kept_parts_are_below_the_first_difference_of_their_column() -> None:
    standing = column(4) | {Cell(1, 0, 0)}
    wanted = column(2) | {Cell(1, 0, 0), Cell(1, 0, 1)}
    best = alignments(standing, wanted, GRID)[0]
    assert best.moves(standing) == 3
    assert best.kept == column(2) | {Cell(1, 0, 0)}


def test_parts_that_are_not_there_are_missed() -> None:
    with pytest.raises(PlanError, match="takes 5 parts; 2 stand and 2 lie on the belt"):
        change_over(column(2), column(5), GRID, PHYSICS, GRIPPER, belt=Belt(2, 40))


def test_an_object_that_cannot_stand_is_refused() -> None:
    beam = column(2) | {Cell(x, 0, 1) for x in range(1, 5)}
    with pytest.raises(PlanError, match="joint between"):
        change_over(column(2), beam, GRID, PHYSICS, GRIPPER)


@pytest.mark.parametrize("seed", [0, 2, 4])
def test_random_change_overs_arrive(seed: int) -> None:
    before, after = buildable(seed, 8 + seed), buildable(50 + seed, 12 - seed)
    found = change_over(before, after, GRID, PHYSICS, GRIPPER)
    replay(before, after, found)
    plan = plan_change_over(before, after, CONFIG)
    assert tuple(step.cell for step in plan.steps) == tuple(step.cell for step in found.steps)
    assert [check.name for check in verify(plan, CONFIG, standing=before) if not check.passed] == []


@pytest.mark.soak
@pytest.mark.timeout(7200)
def test_hundreds_of_random_change_overs_arrive() -> None:
    refused = []
    for seed in range(100, 900):
        before, after = buildable(seed, 6 + seed % 13), buildable(5000 + seed, 6 + seed % 11)
        try:
            found = change_over(before, after, GRID, PHYSICS, GRIPPER)
        except PlanError:
            refused.append(seed)
            continue
        replay(before, after, found)
        judged = verify(plan_change_over(before, after, CONFIG), CONFIG, standing=before)
        assert all(check.passed for check in judged), (seed, judged)
    assert len(refused) <= 40, refused


def test_the_plan_of_a_change_over_says_what_stays() -> None:
    before, after = shelf(4, 3, 2), shelf(4, 4, 3)
    plan = plan_change_over(before, after, CONFIG, title="shelf")
    kinds = [step.kind for step in plan.steps]
    assert StepKind.REMOVE in kinds
    assert StepKind.PLACE in kinds
    stays = len(before) - kinds.count(StepKind.REMOVE)
    assert plan.changes[0].what == (
        f"{stays} of {len(before)} parts stay; {len(kinds)} moves instead of "
        f"{len(before) + len(after)}."
    )
    assert len(plan.assembly.cells) == len(after)
    assert all(step.clearance_m is None and step.duration_s is None for step in plan.steps)


def test_a_full_belt_is_named_where_parts_must_come_off() -> None:
    with pytest.raises(PlanError, match="The belt is full; 2 parts"):
        change_over(column(3), column(1), GRID, PHYSICS, GRIPPER, belt=Belt(40, 40))
