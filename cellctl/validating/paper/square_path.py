"""Algorithm 5: Path Planning for Automated Assembly, and how long it takes.

The arm moves in straight lines with a rest at every corner: up to a plane above everything, across
it, down. A line of length d from rest to rest at speed v and acceleration a takes d / v + v / a,
or 2 sqrt(d / a) where it is too short to reach v.

The text of section 3.4 has the gripper *close* at the place step and pick a part up there; the
printed algorithm opens it, and so does this. From the last part the arm goes to the plane before it
goes home, as before every crossing.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

from cellctl.assembling.frames import Frames
from cellctl.assembling.poses import Matrix
from cellctl.assembling.route import RoutePlanner
from cellctl.assembly import Cell
from cellctl.config import CellConfig
from cellctl.validating.paper.printed import ACCELERATION, SPEED

PRINTED_M_S = (SPEED, ACCELERATION)
"""The paper's speed and acceleration, read as m/s and m/s2."""

Point = tuple[float, float, float]
"""x, y, z in metres, in the robot's base frame."""


def square_path(order: Sequence[Cell], config: CellConfig) -> tuple[Point, ...]:
    """Every corner of algorithm 5, from home back to home, in which the TCP rests.

    Args:
        order: the cells of the workspace in the order in which they are filled.
        config: where home, the feeder and the workspace are; its clearance above the plane.

    Raises:
        PlanError: the arm's home is none that this cell can have.
    """
    frames = Frames(config)
    home = RoutePlanner(config).home.tcp_pose[:3]
    pick = _place(frames.pick_tcp())
    places = [_place(frames.place_tcp(cell)) for cell in order]
    # One plane for every object: a part that hangs from the gripper passes over whatever may stand
    # in the workspace, and over the feeder.
    highest_m = max(_place(frames.place_tcp(Cell(0, 0, config.grid[2] - 1)))[2], pick[2])
    plane_m = highest_m + config.voxel.pitch_m + config.robot.clearance_m
    path = [home, _above(home, plane_m)]
    for place in places:
        path += [_above(pick, plane_m), pick, _above(pick, plane_m)]
        path += [_above(place, plane_m), place, _above(place, plane_m)]
    return (*path, _above(home, plane_m), home)


def duration_s(path: Sequence[Point], speed_m_s: float, acceleration_m_s2: float) -> float:
    """Time along a path with a rest at each of its points."""
    return sum(
        rest_to_rest_s(math.dist(a, b), speed_m_s, acceleration_m_s2)
        for a, b in itertools.pairwise(path)
    )


def rest_to_rest_s(length_m: float, speed_m_s: float, acceleration_m_s2: float) -> float:
    """Time along a straight line, from rest to rest, with a trapezoid of speed."""
    if length_m >= speed_m_s**2 / acceleration_m_s2:
        return length_m / speed_m_s + speed_m_s / acceleration_m_s2
    return 2.0 * math.sqrt(length_m / acceleration_m_s2)


def _place(tcp: Matrix) -> Point:
    x, y, z = tcp[:3, 3].tolist()
    return (x, y, z)


def _above(point: Point, height_m: float) -> Point:
    return (point[0], point[1], height_m)
