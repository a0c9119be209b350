"""Margins are those of statics, for closed forms that can be worked out by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from cellctl.assembly import Cell
from cellctl.config import StabilitySection
from cellctl.errors import PlanError
from cellctl.generating.boxes import Box
from cellctl.validating.stability import (
    Joint,
    Physics,
    Verdict,
    assess,
    assess_order,
)
from cellctl.validating.stability.assess import as_array
from cellctl.validating.stability.hanging import least_pull
from cellctl.validating.stability.joints import FLOOR, Joints
from cellctl.validating.stability.loads import SIDES, push
from cellctl.validating.stability.programme import Programme
from cellctl.validating.stability.springs import spread
from cellctl.validating.stability.strength import needed_pull
from tests.validating.shapes import CONFIG, cells_of
from tests.validating.solids import random_solid

PHYSICS = Physics.of(CONFIG)
WEIGHT_N = PHYSICS.weight_n
FORCE_N = PHYSICS.magnet_force_n


def row_over_nothing(length: int) -> tuple[Cell, ...]:
    """A column of three, and a row that starts beside its top."""
    column = [Cell(0, 0, z) for z in range(3)]
    return (*column, *(Cell(x, 0, 2) for x in range(1, length + 1)))


def column(height: int) -> tuple[Cell, ...]:
    return tuple(Cell(0, 0, z) for z in range(height))


@pytest.mark.parametrize("length", [1, 2, 3, 4, 5])
def test_a_row_over_nothing_needs_the_square_of_its_length(length: int) -> None:
    # Weight n m g at the lever n/2 cells; the joint's lever is half a cell: n^2 m g in all.
    # A single part needs more for friction to carry its weight.
    needed = max(length**2, length / PHYSICS.friction) * WEIGHT_N / FORCE_N
    verdict = assess(frozenset(row_over_nothing(length)), PHYSICS)
    assert 1 / verdict.margin == pytest.approx(needed, rel=1e-6)


@pytest.mark.parametrize(("length", "holds"), [(1, True), (2, True), (3, True), (4, False)])
def test_a_row_of_three_holds_while_it_is_built_and_one_of_four_fails(
    length: int, holds: bool
) -> None:
    order = row_over_nothing(length)
    verdicts = assess_order(order, PHYSICS)
    tilt_n = length**2 * WEIGHT_N + (2 * length - 1) * PHYSICS.placement_down_n
    slide_n = (length * WEIGHT_N + PHYSICS.placement_down_n) / PHYSICS.friction
    needed = max(tilt_n, slide_n) / FORCE_N
    exact = assess(frozenset(order), PHYSICS, order[-1])
    assert 1 / exact.margin == pytest.approx(needed, rel=1e-6)
    assert exact.weakest == Joint(Cell(1, 0, 2), Cell(0, 0, 2))
    assert exact.moving == frozenset(order[3:])
    assert verdicts[-1].margin <= exact.margin * (1 + 1e-6)
    assert all(verdict.margin >= 1 for verdict in verdicts) is holds


@pytest.mark.parametrize("height", [1, 2, 3, 4, 5, 6])
def test_a_lone_column_of_five_stands_while_it_is_built_and_one_of_six_falls(height: int) -> None:
    order = column(height)
    verdict = assess_order(order, PHYSICS)[-1]
    # The push has the lever of the whole height; weight and press hold against it.
    side_n = 2 * height * PHYSICS.placement_side_n
    needed = (side_n - height * WEIGHT_N - PHYSICS.placement_down_n) / FORCE_N
    assert 1 / verdict.margin == pytest.approx(needed, rel=1e-6)
    assert (verdict.margin >= 1) is (height <= 5)
    if height > 1:
        assert verdict.weakest == Joint(Cell(0, 0, 0), Cell(0, 0, -1))
        assert verdict.weakest.describe() == "between [0, 0, 0] and the floor"


@pytest.mark.parametrize("height", [1, 3, 7])
def test_a_bare_floor_lets_any_column_topple_at_half_its_parts_weight(height: int) -> None:
    bare = replace(PHYSICS, floor_grips=False, placement_down_n=0.0, friction=2.0)
    cells = frozenset(column(height))
    top = Cell(0, 0, height - 1)
    less = assess(cells, replace(bare, placement_side_n=0.499 * WEIGHT_N), top)
    more = assess(cells, replace(bare, placement_side_n=0.501 * WEIGHT_N), top)
    assert less.margin > 1
    assert more.margin == 0.0
    assert more.moving == cells


def test_a_row_whose_joint_has_too_little_friction_slides_down() -> None:
    # With a press of N + lambda F, friction carries mu times that; one part weighs m g.
    smooth = replace(PHYSICS, friction=0.01)
    verdict = assess(frozenset(row_over_nothing(1)), smooth)
    assert 1 / verdict.margin == pytest.approx(WEIGHT_N / (0.01 * FORCE_N), rel=1e-6)


def test_a_whole_face_bears_a_diagonal_moment_that_a_diamond_does_not() -> None:
    # A corner piece: the joint at the column bears the moments of both arms.
    cells = frozenset({*column(3), Cell(1, 0, 2), Cell(0, 1, 2)})
    diamond = assess(cells, replace(PHYSICS, floor_grips=False, contact="diamond"))
    square = assess(cells, replace(PHYSICS, floor_grips=False, contact="square"))
    assert square.margin >= diamond.margin


def test_what_stands_on_columns_needs_no_magnets() -> None:
    verdict = assess(cells_of(Box(0, 0, 0, 3, 3, 3)), replace(PHYSICS, floor_grips=False))
    assert verdict == Verdict(math.inf, None, frozenset())


def test_what_touches_no_floor_cannot_stand() -> None:
    loose = frozenset({Cell(0, 0, 0), Cell(5, 0, 1)})
    assert assess(loose, PHYSICS) == Verdict(0.0, None, frozenset({Cell(5, 0, 1)}))


@pytest.mark.parametrize("symmetry", [90, 180])
def test_directed_faces_that_are_alike_are_refused(symmetry: int) -> None:
    stability = StabilitySection.model_validate(
        {"polarity": "directed", "yaw_symmetry_deg": symmetry}
    )
    with pytest.raises(PlanError, match="repel"):
        Physics.of(CONFIG.model_copy(update={"stability": stability}))


def test_directed_faces_attract_where_all_parts_have_one_yaw() -> None:
    stability = StabilitySection(polarity="directed", yaw_symmetry_deg=360)
    assert Physics.of(CONFIG.model_copy(update={"stability": stability})) == PHYSICS


def loads_of(count: int, seed: int) -> NDArray[np.float64]:
    """The weights of parts, and two cases with some push on each beside it."""
    loads = np.random.default_rng(seed).normal(0.0, 2.0, (3, count, 6)) * [1, 1, 1, 0.1, 0.1, 0.1]
    loads[0] = 0.0
    loads[:, :, 2] -= WEIGHT_N
    return loads


@given(seed=st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_springs_balance_whatever_hangs_together_and_need_no_less_than_the_least(seed: int) -> None:
    cells = as_array(sorted(random_solid(seed, (4, 4, 4))))
    joints, loads = Joints.among(cells), loads_of(len(cells), seed)
    borne = spread(joints, loads, PHYSICS)
    assert borne is not None
    left = loads.copy()
    for number, (upper, lower, axis) in enumerate(zip(*joints, strict=True)):
        force, moment = borne[:, number, :3], borne[:, number, 3:]
        arm = np.eye(3)[axis] * PHYSICS.pitch_m / 2
        left[:, upper] += np.hstack([force, moment - np.cross(arm, force)])
        if lower != FLOOR:
            left[:, lower] -= np.hstack([force, moment + np.cross(arm, force)])
    assert np.abs(left).max() < 1e-9
    bare = np.zeros(len(joints.axis), dtype=np.bool_)
    needs = needed_pull(borne, joints.axis, bare, PHYSICS).max(axis=1)
    programme = Programme(cells, PHYSICS)
    least = [programme.solve(case).pull for case in loads]
    assert all(some >= few * (1 - 1e-6) for some, few in zip(needs, least, strict=True))


def test_springs_that_hang_on_nothing_bear_nothing() -> None:
    joints = Joints.among(as_array([Cell(0, 0, 1), Cell(1, 0, 1)]))
    assert spread(joints, loads_of(2, 0), PHYSICS) is None


@pytest.mark.parametrize("contact", ["square", "diamond"])
@pytest.mark.parametrize("cells", [row_over_nothing(3), column(4)])
@pytest.mark.parametrize("side", SIDES)
def test_what_hangs_in_a_row_needs_just_what_its_joints_bear(
    cells: tuple[Cell, ...], side: tuple[float, float], contact: Literal["square", "diamond"]
) -> None:
    physics = replace(PHYSICS, contact=contact)
    programme = Programme(as_array(cells), physics)
    loads = programme.weights()
    loads[-1] += push(physics, side)
    alone = least_pull(cells[-1], push(physics, side), frozenset(cells), physics)
    assert alone == pytest.approx(programme.solve(loads).pull, rel=1e-6)


def test_what_several_joints_hold_may_need_nothing() -> None:
    cells = frozenset({*column(3), *(Cell(1, 0, z) for z in range(3))})
    assert least_pull(Cell(0, 0, 2), push(PHYSICS, SIDES[0]), cells, PHYSICS) == 0.0
