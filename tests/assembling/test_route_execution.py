"""Routes carried out by the emulated controller's motion and judged by the emulated world."""

from __future__ import annotations

import pytest

from cellctl.assembly import BuildPlan, Cell
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.validating.plan import plan_cells, take_apart
from tests.assembling.executed import Bench, slab
from tests.validating.solids import random_solid

TOWERS = [Cell(x, y, z) for z in range(2) for x, y in ((1, 1), (4, 3))]
BRIDGE = [*(Cell(x, 2, z) for z in range(3) for x in (1, 4)), Cell(2, 2, 2), Cell(3, 2, 2)]


@pytest.mark.parametrize(
    ("order", "pace"), [(BRIDGE, "blended"), (slab(2, 2, 2), "quickest"), (TOWERS, "square")]
)
def test_touches_nothing_keeps_every_limit_and_takes_as_long_as_told(
    either_cell: CellConfig, order: list[Cell], pace: str
) -> None:
    changes: dict[str, dict[str, object]] = {
        "blended": {},
        "quickest": {"travel_speed_m_s": 3.0, "travel_acceleration_m_s2": 20.0},
        "square": {"path": "square", "travel_speed_m_s": 2.0, "travel_acceleration_m_s2": 1.0},
    }
    robot = either_cell.robot.model_copy(update=changes[pace])
    bench = Bench(either_cell.model_copy(update={"robot": robot}))
    seen = bench.build(order)
    assert seen.violations == []
    assert bench.world.built == frozenset(order)
    assert seen.fastest <= 1.0
    assert seen.tcp_m_s <= 1.01 * robot.travel_speed_m_s
    if pace != "square":
        assert seen.hardest <= 1.03
    assert seen.duration_s == pytest.approx(seen.predicted_s, rel=0.02)


def test_taking_apart_touches_nothing_and_takes_as_long_as_told(either_cell: CellConfig) -> None:
    column = [Cell(1, 0, z) for z in range(3)]
    order = [*column, Cell(0, 0, 2), Cell(2, 0, 2)]
    bench = Bench(either_cell)
    bench.build(order)
    plan = take_apart(frozenset(order), either_cell, title="T", parts_on_belt=0)
    seen = bench.take_apart(plan.steps, order)
    assert seen.violations == []
    assert bench.world.built == frozenset()
    assert seen.fastest <= 1.0
    assert seen.duration_s == pytest.approx(seen.predicted_s, rel=0.02)


@pytest.mark.parametrize("cell", [Cell(0, 0, 0), Cell(5, 0, 0), Cell(0, 4, 0), Cell(5, 4, 0)])
def test_a_part_comes_off_one_that_sticks_to_it_on_the_belt(
    either_cell: CellConfig, cell: Cell
) -> None:
    bench = Bench(either_cell)
    bench.world.stick_next_part()
    assert bench.build([cell]).violations == []


def _plan(seed: int, config: CellConfig) -> BuildPlan | None:
    """A verified plan of a random solid; None where the solid cannot be built as it is."""
    try:
        return plan_cells(random_solid(seed), config)
    except PlanError:
        return None


def carry_out(seeds: range, config: CellConfig) -> int:
    """Carry out the plans of random solids; returns how many there were.

    Raises:
        AssertionError: one touches something, exceeds a limit or takes longer than told; its seed
            is in the message.
    """
    count = 0
    for seed in seeds:
        plan = _plan(seed, config)
        if plan is None:
            continue
        count += 1
        bench = Bench(config)
        seen = bench.build(step.cell for step in plan.steps)
        assert seen.violations == [], seed
        assert bench.world.built == frozenset(plan.assembly.cells), seed
        assert seen.fastest <= 1.0, seed
        assert seen.hardest <= 1.05, seed
        assert seen.duration_s == pytest.approx(seen.predicted_s, rel=0.05), seed
    return count


def test_plans_of_random_solids_are_carried_out(config: CellConfig) -> None:
    assert carry_out(range(6), config) >= 2


@pytest.mark.soak
def test_2000_plans_of_random_solids_are_carried_out(config: CellConfig) -> None:
    done, seed = 0, 0
    while done < 2000:
        done += carry_out(range(seed, seed + 50), config)
        seed += 50
