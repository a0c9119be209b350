"""The judge passes good plans, and names what is wrong with broken ones."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest

from cellctl.assembly import BuildPlan, Cell, Check, StepKind, TakeOff
from cellctl.config import CellConfig
from cellctl.generating.boxes import Box
from cellctl.validating.changing import plan_removal
from cellctl.validating.changing.breaking import breakings
from cellctl.validating.checker import verify
from cellctl.validating.checker_removal import taking_off
from cellctl.validating.checker_statics import Standing, stands
from cellctl.validating.stability import Physics, assess
from tests.validating.plans import plan_of
from tests.validating.shapes import CONFIG, cells_of
from tests.validating.solids import random_solid
from tests.validating.structures import buildable, seeds, shelf

BENCH = (
    *(Cell(x, 0, z) for z in range(2) for x in (0, 3)),
    *(Cell(x, 0, 2) for x in (0, 1, 3, 2)),
)
"""Two legs of two parts, and a seat of four that is closed in the middle."""


def failed(checks: tuple[Check, ...]) -> dict[str, tuple[Cell, ...]]:
    return {check.name: check.cells for check in checks if not check.passed}


def stability(**options: object) -> CellConfig:
    changed = CONFIG.stability.model_copy(update=options)
    return CONFIG.model_copy(update={"stability": changed})


def test_a_good_plan_passes_every_check() -> None:
    checks = verify(plan_of(BENCH), CONFIG)
    assert failed(checks) == {}
    assert [check.name for check in checks] == [
        "steps",
        "inventory",
        "workspace",
        "grounding",
        "access",
        "stability",
        "end shape",
    ]


def test_swapped_steps_leave_a_part_in_the_air() -> None:
    order = list(BENCH)
    order[4], order[5] = order[5], order[4]  # the seat's second part before its first
    assert failed(verify(plan_of(order), CONFIG))["grounding"] == (Cell(1, 0, 2),)


def test_a_part_beneath_another_cannot_be_placed() -> None:
    order = (Cell(0, 0, 0), Cell(0, 0, 1), Cell(1, 0, 1), Cell(1, 0, 0))
    assert failed(verify(plan_of(order), CONFIG)) == {"access": (Cell(1, 0, 0),)}


def test_a_gripper_wider_than_a_cell_needs_its_neighbours_lower() -> None:
    tool = CONFIG.tool.model_copy(update={"width_m": 0.13})
    wide = CONFIG.model_copy(update={"tool": tool})
    order = (Cell(0, 0, 0), Cell(0, 0, 1), Cell(1, 0, 0))
    assert failed(verify(plan_of(order), CONFIG)) == {}
    assert failed(verify(plan_of(order), wide)) == {"access": (Cell(1, 0, 0),)}


def test_the_wrist_needs_room_above_the_gripper() -> None:
    order = (*(Cell(0, 0, z) for z in range(3)), Cell(1, 0, 0))
    assert failed(verify(plan_of(order), CONFIG)) == {"access": (Cell(1, 0, 0),)}


def test_a_missing_part_and_one_too_many_differ_from_the_end_shape() -> None:
    assert failed(verify(plan_of(BENCH, end=BENCH[:-1]), CONFIG)) == {"end shape": (BENCH[-1],)}
    more = (*BENCH, Cell(5, 4, 0))
    assert failed(verify(plan_of(BENCH, end=more), CONFIG)) == {"end shape": (more[-1],)}


def test_more_parts_than_there_are() -> None:
    assert failed(verify(plan_of(BENCH), CONFIG, parts=7)) == {"inventory": (BENCH[-1],)}


def test_parts_that_are_taken_down_can_be_placed_again() -> None:
    place, remove = StepKind.PLACE, StepKind.REMOVE
    order = (Cell(0, 0, 0), Cell(0, 0, 0), Cell(2, 0, 0))
    moved = plan_of(order, kinds=(place, remove, place), end=order[2:])
    assert failed(verify(moved, CONFIG, parts=1)) == {}


def test_what_stands_before_is_taken_into_account() -> None:
    standing = frozenset(BENCH[:4])
    assert failed(verify(plan_of(BENCH[4:], end=BENCH), CONFIG, standing=standing)) == {}
    assert "grounding" in failed(verify(plan_of(BENCH[4:], end=BENCH), CONFIG))


def test_taking_a_part_that_holds_others_is_refused() -> None:
    standing = frozenset({Cell(0, 0, 0), Cell(0, 0, 1), Cell(1, 0, 1)})
    taken = plan_of((Cell(0, 0, 1),), kinds=(StepKind.REMOVE,), end=standing - {Cell(0, 0, 1)})
    wrong = failed(verify(taken, CONFIG, standing=standing))
    assert wrong["grounding"] == (Cell(1, 0, 1),)
    assert wrong["stability"] == (Cell(0, 0, 1),)


def test_cells_outside_and_steps_on_occupied_cells() -> None:
    order = (Cell(0, 0, 0), Cell(0, 0, 0), Cell(6, 0, 0))
    wrong = failed(verify(plan_of(order), CONFIG))
    assert wrong["workspace"] == (Cell(6, 0, 0),)
    assert wrong["steps"] == (Cell(0, 0, 0),)


def test_steps_are_numbered_without_gaps() -> None:
    assert "steps" in failed(verify(plan_of(BENCH, index_from=1), CONFIG))


def test_a_plan_for_other_parts_is_refused() -> None:
    other = plan_of(BENCH).model_copy(update={"pitch_m": 0.05})
    assert "workspace" in failed(verify(other, CONFIG))


def test_an_overlong_row_over_nothing_is_refused() -> None:
    column = tuple(Cell(0, 0, z) for z in range(3))
    row = tuple(Cell(x, 0, 2) for x in range(1, 5))
    assert failed(verify(plan_of((*column, *row[:3])), CONFIG)) == {}
    assert failed(verify(plan_of((*column, *row)), CONFIG)) == {"stability": (row[3],)}


def test_a_lone_column_of_six_is_refused() -> None:
    column = tuple(Cell(0, 0, z) for z in range(6))
    assert failed(verify(plan_of(column[:5]), CONFIG)) == {}
    assert failed(verify(plan_of(column), CONFIG)) == {"stability": (column[5],)}


def test_a_larger_margin_is_asked_for_as_configured() -> None:
    column = tuple(Cell(0, 0, z) for z in range(5))
    assert "stability" in failed(verify(plan_of(column), stability(least_margin=1.3)))


@pytest.mark.parametrize("contact", ["diamond", "square"])
@pytest.mark.parametrize("floor", ["grips", "bare"])
@pytest.mark.parametrize("seed", seeds(3, 24))
def test_both_formulations_agree_on_any_state(seed: int, contact: str, floor: str) -> None:
    config = stability(contact=contact, floor=floor)
    cells = random_solid(seed, (5, 4, 4))
    pressed = max(cells, key=lambda c: (c.z, c.x, c.y))
    for part in (None, pressed):
        margin = assess(cells, Physics.of(config), part).margin
        for share in (0.98, 1.02):
            # Weaker magnets, down to what the state just needs, and a little less.
            needed_n = config.stability.magnet_force_n / max(min(margin, 1e3), 1e-3)
            other = stability(contact=contact, floor=floor, magnet_force_n=needed_n * share)
            if 0.0 < margin < 1e3:
                assert stands(cells, other, part) is (share > 1.0)
        assert stands(cells, config, part) is (margin >= 1.0)


def test_a_block_stands_without_magnets() -> None:
    assert stands(cells_of(Box(0, 0, 0, 2, 2, 2)), stability(magnet_force_n=0.001))


@pytest.mark.parametrize("contact", ["diamond", "square"])
@pytest.mark.parametrize("floor", ["grips", "bare"])
@pytest.mark.parametrize("seed", seeds(2, 20))
def test_both_formulations_agree_at_every_step(seed: int, contact: str, floor: str) -> None:
    """What is carried over from state to state never passes a state that falls, nor the reverse."""
    config, dice = stability(contact=contact, floor=floor), random.Random(seed)  # noqa: S311
    physics = Physics.of(config)
    shape = buildable(seed, 16)
    now, walk = set[Cell](), Standing(shape, config, frozenset())
    for _ in range(40):
        free = [c for c in sorted(shape - now) if c.z == 0 or any(n in now for n in c.neighbours())]
        if now and (not free or dice.random() < 0.3):
            cell = dice.choice(sorted(now))
            now.discard(cell)
            held, margin = walk.remove(cell), assess(frozenset(now), physics).margin
        else:
            cell = dice.choice(free)
            now.add(cell)
            held, margin = walk.place(cell), assess(frozenset(now), physics, cell).margin
        assert held is (margin >= 1.0)
        if not held:
            break


@pytest.mark.parametrize("contact", ["diamond", "square"])
@pytest.mark.parametrize("floor", ["grips", "bare"])
@pytest.mark.parametrize("seed", seeds(2, 20))
def test_both_work_out_the_same_loads_as_a_part_comes_off(
    seed: int, contact: str, floor: str
) -> None:
    config = stability(contact=contact, floor=floor)
    physics, cells = Physics.of(config), buildable(seed, 14)
    half_m = physics.pitch_m / 2
    units = np.repeat([physics.magnet_force_n, physics.magnet_force_n * half_m], 3)
    for cell in sorted(cells):
        found = breakings(cells, cell, physics)
        for breaking in found:
            hinge = breaking.way.hinge
            stated = TakeOff(
                how=breaking.way.how,
                direction=breaking.way.direction,
                hinge_m=hinge and (hinge.towards * half_m, hinge.up * half_m),
                force_n=breaking.force_n,
            )
            judged = taking_off(cells, cell, stated, config)
            assert judged.wrong == ""
            assert judged.loads.keys() == breaking.loads.keys()
            for beside, load in breaking.loads.items():
                assert judged.loads[beside] * units == pytest.approx(load, abs=1e-6)
            less = stated.model_copy(update={"force_n": breaking.force_n * 0.985})
            assert "takes" in taking_off(cells, cell, less, config).wrong


def taken_apart() -> tuple[BuildPlan, frozenset[Cell]]:
    cells = shelf(4, 4, 2, 3)
    return plan_removal(cells, CONFIG), cells


def with_take_offs(plan: BuildPlan, **options: object) -> BuildPlan:
    steps = []
    for step in plan.steps:
        assert step.take_off is not None
        steps.append(step.model_copy(update={"take_off": step.take_off.model_copy(update=options)}))
    return plan.model_copy(update={"steps": tuple(steps)})


def test_a_stated_way_of_taking_apart_is_judged() -> None:
    plan, cells = taken_apart()
    checks = verify(plan, CONFIG, standing=cells)
    assert failed(checks) == {}
    assert [check.name for check in checks][-2:] == ["removal", "end shape"]


@pytest.mark.parametrize(
    "options",
    [
        {"how": "pull", "force_n": 0.0},
        {"how": "pull", "force_n": 1000.0},
        {"force_n": 1.0},
        {"how": "peel", "hinge_m": None},
        {"how": "peel", "direction": (1, 0), "hinge_m": (-0.05, 0.0), "force_n": 1000.0},
    ],
    ids=["no force", "too hard on the rest", "too weak", "no axis", "into its neighbour"],
)
def test_a_way_that_the_rest_or_the_arm_does_not_bear_is_refused(options: dict[str, Any]) -> None:
    plan, cells = taken_apart()
    assert set(failed(verify(with_take_offs(plan, **options), CONFIG, standing=cells))) == {
        "removal"
    }


def test_a_removal_that_does_not_say_how_is_a_straight_pull() -> None:
    """It draws what hangs beneath after it: a part on the end of a row of three."""
    row = (*(Cell(0, 0, z) for z in range(3)), Cell(1, 0, 2), Cell(2, 0, 2), Cell(2, 0, 3))
    taken = plan_of(row[-1:], kinds=(StepKind.REMOVE,), end=row[:-1])
    assert failed(verify(taken, CONFIG, standing=frozenset(row))) == {"removal": row[-1:]}
    lone = plan_of(row[2:3], kinds=(StepKind.REMOVE,), end=row[:2])
    assert failed(verify(lone, CONFIG, standing=frozenset(row[:3]))) == {}


def test_a_tilt_needs_room_above_its_neighbours() -> None:
    cells = frozenset({Cell(0, 0, 0), *(Cell(1, 0, z) for z in range(2))})
    apart = frozenset(cells - {Cell(1, 0, 0)}) | {Cell(1, 1, 0), Cell(1, 1, 1)}
    tilt = TakeOff(how="peel", direction=(1, 1), hinge_m=(0.0707, -0.05), force_n=100.0)
    for standing in (cells, apart):
        judged = taking_off(standing, Cell(0, 0, 0), tilt, CONFIG)
        assert judged.wrong == "it would tilt or turn into another part"


def test_a_plan_without_steps_is_judged() -> None:
    assert failed(verify(plan_of(()), CONFIG)) == {}
