"""The world judges the links of the arm, and the planner keeps them off everything."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from cellctl.assembling.route import RoutePlanner
from cellctl.assembly import Cell
from cellctl.config import CellConfig, load_config
from cellctl.errors import PlanError
from cellctl.sim.plant import Floats
from cellctl.sim.ur.kinematics import Kinematics
from cellctl.sim.world import World
from cellctl.sim.world_links import tubes
from cellctl.sim.world_values import ViolationKind
from tests.assembling.executed import Bench
from tests.leaks import REPOSITORY

CONFIG = load_config(REPOSITORY / "config" / "sim.toml")
HOME = CONFIG.robot.home_rad
LIMITS = (6.3,) * 6


def walled(*boxes_m: tuple[float, ...]) -> CellConfig:
    """The emulated cell with walls."""
    data = CONFIG.model_dump(exclude_none=True) | {"walls": {"boxes_m": boxes_m}}
    return CellConfig.model_validate(data)


def turn(world: World, start: tuple[float, ...], end: tuple[float, ...], steps: int = 400) -> None:
    """All joints go straight, in small steps."""
    kinematics = Kinematics(CONFIG.robot.model, LIMITS)
    for share in np.linspace(0.0, 1.0, steps + 1):
        joints = np.array(start) + share * (np.array(end) - np.array(start))
        world.robot_moved(kinematics.flange(joints.tolist()), joints, 0.002)


def collisions(world: World) -> list[str]:
    return [v.message for v in world.violations if v.kind is ViolationKind.COLLISION]


@pytest.mark.parametrize("model", ["ur10", "ur10e"])
def test_the_last_link_ends_before_the_flange(model: Literal["ur10", "ur10e"]) -> None:
    kinematics = Kinematics(model, LIMITS)
    for seed in range(50):
        joints = np.random.default_rng(seed).uniform(-3.0, 3.0, 6).tolist()
        *_, last = tubes(joints, model)
        flange: Floats = kinematics.flange(joints)
        way = flange[:3, 3] - last.begin
        along = last.end - last.begin
        assert np.linalg.norm(np.cross(way, along)) == pytest.approx(0.0, abs=1e-9)
        assert np.linalg.norm(along) == pytest.approx(0.4 * np.linalg.norm(way))


BEAM = (0.0, -0.5, 1.4, 0.15, -0.2, 1.8)
"""Where the forearm comes when the elbow stretches."""


@pytest.mark.parametrize(
    ("joint", "by_rad", "told"),
    [(1, 2.8, "The elbow ran into the floor."), (2, 1.1, "The forearm ran into the wall.")],
)
def test_a_link_that_goes_where_something_stands_is_a_collision(
    joint: int, by_rad: float, told: str
) -> None:
    world = World(walled(BEAM))
    end = list(HOME)
    end[joint] += by_rad
    turn(world, HOME, tuple(end))
    assert told in collisions(world)


def test_a_fast_arm_does_not_slip_through_a_thin_wall() -> None:
    # Where the wrist passes when the base turns: 5 mm thick, and the arm seen 20 times on its way.
    end = (HOME[0] - 3.0, *HOME[1:])
    world, free = World(walled((0.30, 0.05, 1.04, 0.305, 1.0, 1.2))), World(CONFIG)
    for each in (world, free):
        turn(each, HOME, end, steps=20)
    assert any("wrist ran into the wall" in message for message in collisions(world))
    assert collisions(free) == []


def test_the_planner_keeps_the_whole_arm_off_a_wall_and_refuses_what_it_cannot() -> None:
    # A ceiling beam above the workspace that leaves room for the lower layers only.
    low = walled((-0.5, 0.0, 1.15, 1.2, 0.5, 1.25))
    bench = Bench(low)
    order = [Cell(1, 1, 0), Cell(4, 3, 0)]
    assert bench.build(order).violations == []
    assert bench.world.built == frozenset(order)
    with pytest.raises(PlanError, match="wall 1"):
        RoutePlanner(walled((-0.5, -0.1, 0.0, 1.2, 0.0, 2.0))).to_cell(Cell(2, 2, 0), ())


def test_a_wall_inside_out_is_refused() -> None:
    with pytest.raises(ValueError, match="first the smallest"):
        walled((0.0, 0.0, 0.0, -1.0, 1.0, 1.0))
