"""What comes along with a part that is taken, beside what the planner proves of its plans."""

from __future__ import annotations

import numpy as np
import pytest

from cellctl.assembly import Cell, TakeOff
from cellctl.config import CellConfig
from cellctl.sim.physics import Material, Parting, parting
from cellctl.sim.physics.joints import Floats
from cellctl.validating.changing import plan_removal
from tests.sim.world.hand import emulated_config
from tests.validating.structures import shelf, table

CONFIG = emulated_config()
UP = np.array([0.0, 0.0, 1.0])


def cells(*places: tuple[int, int, int]) -> frozenset[Cell]:
    return frozenset(Cell(*place) for place in places)


def movement(way: TakeOff) -> tuple[Floats, Floats]:
    """The stated way as linear and angular velocity, in half pitches."""
    if way.direction is None or way.hinge_m is None:
        return UP, np.zeros(3)
    ahead = np.array([*way.direction, 0.0]) / np.hypot(*way.direction)
    angular = np.cross(UP, ahead)
    hinge = (way.hinge_m[0] * ahead + way.hinge_m[1] * UP) / (CONFIG.voxel.pitch_m / 2)
    return np.cross(angular, -hinge), angular


def taken(
    standing: frozenset[Cell], cell: Cell, way: TakeOff, config: CellConfig = CONFIG
) -> Parting:
    return parting(standing, cell, *movement(way), Material.of(config))


PULL = TakeOff(how="pull", force_n=30.0)
PEEL_EAST = TakeOff(how="peel", direction=(1, 0), hinge_m=(0.05, -0.05), force_n=15.0)


@pytest.mark.parametrize("standing", [shelf(4, 4, 1, 3), table(3, 3, 3)], ids=["shelf", "table"])
def test_what_the_planner_proves_drags_nothing_along(standing: frozenset[Cell]) -> None:
    now = set(standing)
    for step in plan_removal(standing, CONFIG).steps:
        assert step.take_off is not None
        assert taken(frozenset(now), step.cell, step.take_off) == (None, None), step
        now.discard(step.cell)


def test_a_straight_pull_drags_along_what_a_peel_leaves() -> None:
    standing = shelf(4, 4, 1, 3)
    now, dragged = set(standing), 0
    for step in plan_removal(standing, CONFIG).steps:
        dragged += taken(frozenset(now), step.cell, PULL).dragged is not None
        now.discard(step.cell)
    assert dragged > 0


@pytest.mark.parametrize("way", [PULL, PEEL_EAST])
def test_on_a_bare_floor_a_column_comes_along(way: TakeOff) -> None:
    bare = CONFIG.stability.model_copy(update={"floor": "bare"})
    config = CONFIG.model_copy(update={"stability": bare})
    column = cells((1, 1, 0), (1, 1, 1))
    found = taken(column, Cell(1, 1, 1), way, config).dragged
    assert found is not None
    assert found.moving == (Cell(1, 1, 0),)
    assert taken(column, Cell(1, 1, 1), way).dragged is None


def test_a_part_that_tilts_into_a_neighbour_presses_it() -> None:
    standing = cells((1, 1, 0), (2, 1, 0), (1, 1, 1), (2, 1, 1))
    assert taken(standing, Cell(1, 1, 1), PEEL_EAST).pressed == Cell(2, 1, 1)
    away = PEEL_EAST.model_copy(update={"direction": (-1, 0)})
    assert taken(standing, Cell(1, 1, 1), away).pressed is None


def test_faster_is_not_different() -> None:
    standing = cells((1, 1, 0), (1, 1, 1))
    linear, angular = movement(PEEL_EAST)
    material = Material.of(CONFIG)
    slow = parting(standing, Cell(1, 1, 1), linear, angular, material)
    assert slow == parting(standing, Cell(1, 1, 1), 40.0 * linear, 40.0 * angular, material)
