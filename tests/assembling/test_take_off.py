"""Routes that take parts off: what they part, what they keep clear of, and where they end."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from cellctl.assembling.arm import Waypoint
from cellctl.assembling.poses import distance, to_matrix
from cellctl.assembling.route import Route, RoutePlanner, Stance
from cellctl.assembly import Cell, TakeOff
from cellctl.config import load_config
from cellctl.errors import PlanError

CONFIG = load_config(Path(__file__).parents[2] / "config" / "sim.toml")
PLANNER = RoutePlanner(CONFIG)
PITCH_M = CONFIG.voxel.pitch_m
PULL = TakeOff(how="pull", force_n=25.0)
TWIST = TakeOff(how="twist", force_n=10.0)
EAST = TakeOff(how="peel", direction=(1, 0), hinge_m=(0.05, -0.05), force_n=15.0)
COLUMN = frozenset(Cell(2, 2, z) for z in range(2))
TOP = Cell(2, 2, 1)


def tilts_rad(route: Route) -> Iterator[float]:
    """How far each waypoint leans from straight down."""
    for waypoint in route.path:
        yield math.acos(min(1.0, -float(to_matrix(waypoint.pose)[2, 2])))


@pytest.mark.parametrize("way", [PULL, TWIST, EAST], ids=["pull", "twist", "peel"])
def test_every_way_ends_upright_above_the_place_and_clear_of_it(way: TakeOff) -> None:
    grip = PLANNER.place_stance(TOP)
    route = PLANNER.take_off(TOP, way, COLUMN)
    rise_m = route.end.tcp_pose[2] - grip.tcp_pose[2]
    assert rise_m == pytest.approx(PITCH_M + CONFIG.robot.clearance_m)
    assert math.dist(route.end.tcp_pose[:2], grip.tcp_pose[:2]) < 1e-9
    assert distance(route.end.tcp_pose, grip.tcp_pose)[1] < 1e-9
    assert (max(tilts_rad(route)) > math.radians(5.0)) is (way is EAST)


def test_a_peel_keeps_its_hinge_in_place_while_it_tilts() -> None:
    route = PLANNER.take_off(TOP, EAST, COLUMN)
    hinge_in_tcp = np.array([PITCH_M / 2, 0.0, PITCH_M, 1.0])
    before = to_matrix(PLANNER.place_stance(TOP).tcp_pose) @ hinge_in_tcp
    tilting = [w for w, tilt in zip(route.path, tilts_rad(route), strict=True) if tilt > 1e-3][:-1]
    assert len(tilting) >= 3
    for waypoint in tilting:
        assert np.allclose(to_matrix(waypoint.pose) @ hinge_in_tcp, before, atol=1e-6)


def test_a_part_is_not_tilted_into_what_stands_higher_beside_it() -> None:
    beside = COLUMN | {Cell(3, 2, z) for z in range(3)}
    with pytest.raises(PlanError, match=r"would touch the part at \[3, 2, "):
        PLANNER.take_off(TOP, EAST, beside)
    west = EAST.model_copy(update={"direction": (-1, 0)})
    assert PLANNER.take_off(TOP, west, beside).path


@pytest.mark.parametrize("cell", [Cell(2, 0, 1), Cell(4, 3, 0)])
def test_a_part_in_a_hindering_cell_leaves_the_arm_no_room(cell: Cell) -> None:
    hindering = PLANNER.hindering(cell)
    assert hindering
    for other in sorted(hindering)[::5]:
        with pytest.raises(PlanError, match=r"too close to the part|would touch the part"):
            PLANNER.take_off(cell, PULL, {cell, other})
    assert not any(other.z <= cell.z for other in hindering)


def test_from_a_tilt_it_goes_up_before_it_comes_upright() -> None:
    route = PLANNER.take_off(TOP, EAST, COLUMN)
    tilted = next(w.pose for w, t in zip(route.path, tilts_rad(route), strict=True) if t > 0.1)
    start = Stance(tilted, PLANNER.place_stance(TOP).joints_rad)
    up = PLANNER.upright(start, COLUMN - {TOP})
    leans = list(tilts_rad(up))
    assert leans[0] > 0.1
    assert leans[-1] < 1e-6
    assert up.path[0].pose[2] > tilted[2] + CONFIG.robot.clearance_m
    assert PLANNER.upright(up.end, COLUMN - {TOP}).path == ()


def test_what_stands_is_gripped_and_brought_to_the_station() -> None:
    there = PLANNER.to_grip(TOP, COLUMN, PLANNER.home)
    assert there.end.tcp_pose == PLANNER.place_stance(TOP).tcp_pose
    with pytest.raises(PlanError, match="No part stands"):
        PLANNER.to_grip(Cell(0, 0, 0), COLUMN, PLANNER.home)
    off = PLANNER.take_off(TOP, EAST, COLUMN, there.end)
    back = PLANNER.to_station(COLUMN - {TOP}, off.end)
    assert back.end.tcp_pose == PLANNER.pick_stance().tcp_pose


def test_a_part_that_is_taken_off_is_carried_no_faster_than_any_part() -> None:
    limits = {"carrying_speed_m_s": 0.2, "carrying_acceleration_m_s2": 0.5}
    robot = CONFIG.robot.model_copy(update=limits)
    route = RoutePlanner(CONFIG.model_copy(update={"robot": robot})).take_off(TOP, EAST, COLUMN)
    lines = [waypoint for waypoint in route.path if isinstance(waypoint, Waypoint)]
    assert len(lines) == len(route.path)
    assert max(line.speed_m_s for line in lines) == pytest.approx(0.2)
    assert max(line.acceleration_m_s2 for line in lines) == pytest.approx(0.5)
