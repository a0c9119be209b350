"""Routes: paths of the arm that keep clear of everything, checked before anything moves.

Nothing moves but along a route that this module made or checked. A route goes straight up from
where the gripper is, crosses at the lowest height that keeps ``robot.clearance_m`` from everything
below, and goes straight down; the first and last ``robot.approach_height_m`` are slow, because
parts touch there. All of it is checked along its whole length: reach, one arm configuration, joint
speed, and what the gripper and its part sweep.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from cellctl.assembling.arm import Waypoint
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import JOINT_SPEEDS_RAD_S, Kinematics, same_configuration
from cellctl.assembling.obstacles import (
    Body,
    Obstacles,
    Surroundings,
    first_touched,
    gripper_body,
    highest_below,
    part_body,
)
from cellctl.assembling.poses import Floats, Matrix, interpolate, to_matrix, to_pose
from cellctl.assembling.timing import blend_chord, duration_s, leg_length_m
from cellctl.assembly import Cell, Value
from cellctl.config import CellConfig, Joints, Pose
from cellctl.errors import PlanError

_SAMPLE_M = 0.04
"""Spacing of the poses at which reach and configuration are checked."""
_JUMP_RAD = 1.0
"""Joints that differ by more than this between two neighbouring samples change configuration."""
_JOINT_SPEED_SHARE = 0.8
"""How much of the joints' speed a route may use; the rest is for accelerating and blends."""
_SAME_PLACE_M = 0.002
_JOINT_STEP_RAD = math.radians(3.0)
_SLOW_BLEND_M = 0.002
_BLEND_SHARE = 0.45
"""Largest share of a leg that one blend may use, so that two never overlap."""


class Stance(NamedTuple):
    """Where an arm is: what it reports, or what is predicted for it."""

    tcp_pose: Pose
    """In the base frame."""
    joints_rad: Joints


class Route(Value):
    """A checked path from one stance."""

    path: tuple[Waypoint, ...]
    """Empty where the arm is already there."""
    duration_s: float
    """Planned, from rest to rest, in cell time."""
    crossing_height_m: float
    """Height of the TCP above the floor while crossing."""
    end: Stance


class StepRoute(Value):
    """What the placement of one part takes."""

    clearance_m: float
    """Height of the TCP above the floor at which the part crosses."""
    duration_s: float
    """Both movements, without the gripper's own time."""


class _Leg(NamedTuple):
    limit_m_s: float
    """Greatest TCP speed at which every joint stays within its share."""
    joints_rad: Joints
    """Where the leg ends."""


class RoutePlanner:
    """Plans and checks every movement of one cell. Pure: it moves nothing and asks nothing.

    Args:
        config: the cell.
    """

    def __init__(self, config: CellConfig) -> None:
        self._robot = config.robot
        self._pitch_m = config.voxel.pitch_m
        self._grid = config.grid
        self._frames = Frames(config)
        self._kinematics = Kinematics(config.robot.model)
        self._surroundings = Surroundings(config, self._frames)
        self._gripper = gripper_body(config)
        self._part = part_body(config)
        home_rad = config.robot.home_rad
        self.home = Stance(self._tcp_of(home_rad), home_rad)

    def pick_stance(self) -> Stance:
        """Gripping the part at the pick station.

        Raises:
            PlanError: it is out of reach.
        """
        return self._stance(self._frames.pick_tcp(), "the pick station")

    def place_stance(self, cell: Cell) -> Stance:
        """Holding a part in a cell.

        Raises:
            PlanError: the cell is outside the workspace or out of reach.
        """
        if not all(0 <= index < count for index, count in zip(cell, self._grid, strict=True)):
            size = " x ".join(str(count) for count in self._grid)
            raise PlanError(f"{_name(cell)} is outside the workspace of {size} cells.")
        return self._stance(self._frames.place_tcp(cell), _name(cell))

    def to_pick(self, start: Stance, placed: Collection[Cell]) -> Route:
        """With an open gripper from anywhere to the part at the pick station.

        Raises:
            PlanError: there is no such way.
        """
        groups = self._surroundings.around(placed, part_at_station=True)
        return self._route(start, self.pick_stance(), groups, self._bodies(carrying=False))

    def to_cell(self, cell: Cell, placed: Collection[Cell], start: Stance | None = None) -> Route:
        """With a part in the gripper to its cell; from the pick station unless told otherwise.

        Args:
            cell: where the part goes.
            placed: what stands already.
            start: where the arm is.

        Raises:
            PlanError: there is no such way, for instance because the cell is covered.
        """
        if cell in placed:
            raise PlanError(f"{_name(cell)} is already occupied.")
        groups = self._surroundings.around(placed, part_at_station=False)
        goal = self.place_stance(cell)
        return self._route(start or self.pick_stance(), goal, groups, self._bodies(carrying=True))

    def to_home(self, start: Stance, placed: Collection[Cell], *, carrying: bool) -> Route:
        """From anywhere to where the arm rests.

        Raises:
            PlanError: there is no such way; ``check_joint_move`` may still allow turning joints.
        """
        groups = self._surroundings.around(placed, part_at_station=not carrying)
        return self._route(start, self.home, groups, self._bodies(carrying=carrying))

    def retreat(self, start: Stance, placed: Collection[Cell], *, carrying: bool) -> Route:
        """Straight up from anywhere, until nothing that stands is as high.

        Raises:
            PlanError: something is in the way, or it is out of reach.
        """
        groups = self._surroundings.around(placed, part_at_station=not carrying)
        top = max((cell.z + 1 for cell in placed), default=0) * self._pitch_m
        height_m = self._frames.cell_from_workspace[2, 3] + top + self._robot.clearance_m
        height_m += self._pitch_m if carrying else 0.0
        here = to_matrix(start.tcp_pose)
        height_m = max(float(height_m), self._frames.height_m(here))
        up = self._frames.raised(here, height_m)
        goal = self._stance(up, "the place above", near=start.joints_rad)
        return self._route(start, goal, groups, self._bodies(carrying=carrying))

    def step(self, cell: Cell, placed: Collection[Cell], previous: Cell | None = None) -> StepRoute:
        """What one placement takes: from where the arm put the previous part (or home) to the pick
        station, and on to the cell.

        Raises:
            PlanError: there is no such way.
        """
        start = self.home if previous is None else self.place_stance(previous)
        fetch = self.to_pick(start, placed)
        bring = self.to_cell(cell, placed, fetch.end)
        return StepRoute(
            clearance_m=bring.crossing_height_m, duration_s=fetch.duration_s + bring.duration_s
        )

    def reachable(self, cell: Cell) -> bool:
        """Whether a part can be brought to a cell, with its approach, where nothing else stands."""
        try:
            self.to_cell(cell, ())
        except PlanError:
            return False
        return True

    def check(
        self,
        start: Stance,
        path: Sequence[Waypoint],
        placed: Collection[Cell],
        *,
        carrying: bool,
    ) -> Stance:
        """Check a path that somebody else made, such as an operator's command.

        Returns:
            Where it ends.

        Raises:
            PlanError: it leaves the arm's reach or configuration, is too fast for a joint, or
                touches something; the message says where.
        """
        groups = self._surroundings.around(placed, part_at_station=not carrying)
        legs = self._legs(start, [waypoint.pose for waypoint in path])
        for waypoint, leg in zip(path, legs, strict=True):
            if waypoint.speed_m_s > leg.limit_m_s * 1.001:
                raise PlanError(
                    f"{waypoint.speed_m_s:.2f} m/s is too fast for the arm's joints on the way to "
                    f"{self._where(to_matrix(waypoint.pose))} (at most {leg.limit_m_s:.2f} m/s)."
                )
        self._check_sweeps(start.tcp_pose, path, groups, self._bodies(carrying=carrying))
        return Stance(path[-1].pose, legs[-1].joints_rad) if path else start

    def check_joint_move(
        self, start: Stance, target_rad: Joints, placed: Collection[Cell], *, carrying: bool
    ) -> float:
        """Check a movement in joint space, in which all joints start and end together.

        Returns:
            The largest distance that a joint turns, in radians.

        Raises:
            PlanError: it touches something on the way.
        """
        groups = self._surroundings.around(placed, part_at_station=not carrying)
        bodies = self._bodies(carrying=carrying)
        way = np.subtract(target_rad, start.joints_rad)
        largest_rad = float(np.max(np.abs(way)))
        steps = max(1, math.ceil(largest_rad / _JOINT_STEP_RAD))
        poses = [
            self._frames.tcp(self._kinematics.forward(_joints(start.joints_rad, way, i / steps)))
            for i in range(steps + 1)
        ]
        for before, after in itertools.pairwise(poses):
            touched = first_touched(groups, bodies, before, after)
            if touched is not None:
                raise PlanError(f"Turning the joints there would touch {touched}.")
        return largest_rad

    def _route(
        self, start: Stance, goal: Stance, groups: tuple[Obstacles, ...], bodies: tuple[Body, ...]
    ) -> Route:
        """Up, across, down: the largest blends that keep clear, at the lowest height."""
        here, there = to_matrix(start.tcp_pose), to_matrix(goal.tcp_pose)
        height_m = self._crossing_height_m(here, there, groups, bodies)
        corners = self._corners(here, there, height_m)
        if not corners:
            return Route(path=(), duration_s=0.0, crossing_height_m=height_m, end=start)
        square = self._waypoints(corners)
        legs = self._legs(start, [waypoint.pose for waypoint in square])
        slowed = _slowed(square, legs)
        refused: PlanError | None = None
        for blend_m in (self._robot.blend_radius_m, self._robot.clearance_m, 0.0):
            path = _blended(start.tcp_pose, slowed, blend_m, self._robot.approach_speed_m_s)
            try:
                self._check_sweeps(start.tcp_pose, path, groups, bodies)
            except PlanError as error:
                refused = refused or error
                continue
            return Route(
                path=path,
                duration_s=duration_s(start.tcp_pose, path),
                crossing_height_m=height_m,
                end=Stance(path[-1].pose, legs[-1].joints_rad),
            )
        assert refused is not None
        raise refused

    def _crossing_height_m(
        self,
        here: Matrix,
        there: Matrix,
        groups: tuple[Obstacles, ...],
        bodies: tuple[Body, ...],
    ) -> float:
        lowest_m = max(self._frames.height_m(here), self._frames.height_m(there))
        if _sideways_m(here, there) < _SAME_PLACE_M:
            return lowest_m
        top_m = highest_below(
            groups,
            bodies,
            here,
            there,
            margin_m=self._robot.clearance_m,
            cell_from_base=self._frames.cell_from_base,
        )
        hanging_m = max(body.high[2] for body in bodies)
        return max(lowest_m, top_m + self._robot.clearance_m + hanging_m)

    def _corners(self, here: Matrix, there: Matrix, height_m: float) -> list[tuple[Matrix, bool]]:
        """Corners of the path, and whether the leg that leads to each is slow."""
        slow_m = self._robot.approach_height_m
        corners: list[tuple[Matrix, bool]] = []
        if _sideways_m(here, there) >= _SAME_PLACE_M:
            rise_m = height_m - self._frames.height_m(here)
            if rise_m > 2.0 * slow_m:
                rest = self._frames.raised(here, self._frames.height_m(here) + slow_m)
                corners += [(rest, True), (self._frames.raised(here, height_m), False)]
            elif rise_m > _SAME_PLACE_M:
                corners.append((self._frames.raised(here, height_m), True))
            corners.append((self._frames.raised(there, height_m), False))
            here = corners[-1][0]
        fall_m = self._frames.height_m(here) - self._frames.height_m(there)
        if fall_m > 2.0 * slow_m:
            near = self._frames.raised(there, self._frames.height_m(there) + slow_m)
            corners.append((near, False))
        if abs(fall_m) > _SAME_PLACE_M / 2:
            corners.append((there, True))
        return corners

    def _waypoints(self, corners: Sequence[tuple[Matrix, bool]]) -> tuple[Waypoint, ...]:
        robot = self._robot
        return tuple(
            Waypoint(
                pose=to_pose(matrix),
                speed_m_s=robot.approach_speed_m_s if slow else robot.travel_speed_m_s,
                acceleration_m_s2=robot.travel_acceleration_m_s2,
            )
            for matrix, slow in corners
        )

    def _legs(self, start: Stance, poses: Sequence[Pose]) -> list[_Leg]:
        """Follow the straight legs from pose to pose with the joints.

        Raises:
            PlanError: a pose is out of reach, or the arm's configuration would change.
        """
        legs = []
        before, joints_rad = start.tcp_pose, start.joints_rad
        for pose in poses:
            samples = self._leg_joints(before, joints_rad, pose)
            limit_m_s = _speed_limit_m_s(leg_length_m(before, pose), joints_rad, samples)
            legs.append(_Leg(limit_m_s, samples[-1]))
            before, joints_rad = pose, samples[-1]
        return legs

    def _leg_joints(self, start: Pose, joints_rad: Joints, end: Pose) -> list[Joints]:
        """Joint positions along a straight leg, each near the one before."""
        a, b = to_matrix(start), to_matrix(end)
        steps = max(1, math.ceil(leg_length_m(start, end) / _SAMPLE_M))
        samples: list[Joints] = []
        near = joints_rad
        for i in range(1, steps + 1):
            pose = interpolate(a, b, i / steps)
            found = self._kinematics.inverse(self._frames.flange(pose), near)
            if found is None:
                raise PlanError(f"The arm does not reach {self._where(pose)}.")
            jump_rad = max(abs(one - two) for one, two in zip(found, near, strict=True))
            if jump_rad > _JUMP_RAD or not same_configuration(found, joints_rad):
                raise PlanError(
                    f"The arm would have to change its configuration at {self._where(pose)}."
                )
            samples.append(found)
            near = found
        return samples

    def _check_sweeps(
        self,
        start: Pose,
        path: Sequence[Waypoint],
        groups: tuple[Obstacles, ...],
        bodies: tuple[Body, ...],
    ) -> None:
        """Check what the bodies sweep on every leg and across every blend.

        Raises:
            PlanError: they touch something.
        """
        before = start
        for i, waypoint in enumerate(path):
            ways = [(before, waypoint.pose)]
            if waypoint.blend_radius_m > 0.0 and i + 1 < len(path):
                ways.append(blend_chord(before, waypoint, path[i + 1].pose))
            for begin, end in ways:
                touched = first_touched(groups, bodies, to_matrix(begin), to_matrix(end))
                if touched is not None:
                    what = "part it carries" if len(bodies) > 1 else "empty gripper"
                    raise PlanError(f"The {what} would touch {touched}.")
            before = waypoint.pose

    def _where(self, tcp: Matrix) -> str:
        x, y, z = (self._frames.cell_from_base @ tcp)[:3, 3]
        return f"({x:.3f}, {y:.3f}, {z:.3f}) m of the cell"

    def _stance(self, tcp: Matrix, what: str, near: Joints | None = None) -> Stance:
        """The stance of the home configuration at a TCP pose."""
        near = near or self.home.joints_rad
        joints_rad = self._kinematics.inverse(self._frames.flange(tcp), near)
        if joints_rad is None:
            raise PlanError(f"{what[0].upper()}{what[1:]} is out of the arm's reach.")
        if not same_configuration(joints_rad, near):
            raise PlanError(f"The arm would have to change its configuration to reach {what}.")
        return Stance(to_pose(tcp), joints_rad)

    def _tcp_of(self, joints_rad: Joints) -> Pose:
        return to_pose(self._frames.tcp(self._kinematics.forward(joints_rad)))

    def _bodies(self, *, carrying: bool) -> tuple[Body, ...]:
        return (self._gripper, self._part) if carrying else (self._gripper,)


def _speed_limit_m_s(length_m: float, start: Joints, samples: Sequence[Joints]) -> float:
    """Greatest speed along a leg at which no joint is faster than its share."""
    if length_m <= 0.0:
        return math.inf
    stations = np.array([start, *samples])
    per_metre = np.max(np.abs(np.diff(stations, axis=0)), axis=0) * len(samples) / length_m
    limits = _JOINT_SPEED_SHARE * np.array(JOINT_SPEEDS_RAD_S)
    return float(np.min(limits / np.maximum(per_metre, 1e-9)))


def _slowed(path: Sequence[Waypoint], legs: Sequence[_Leg]) -> tuple[Waypoint, ...]:
    """The same path, slow enough on every leg for every joint."""
    return tuple(
        waypoint.model_copy(update={"speed_m_s": min(waypoint.speed_m_s, leg.limit_m_s)})
        for waypoint, leg in zip(path, legs, strict=True)
    )


def _blended(
    start: Pose, path: Sequence[Waypoint], blend_m: float, slow_m_s: float
) -> tuple[Waypoint, ...]:
    """The same path with its corners rounded, none so wide that it meets the next."""
    poses = [start, *(waypoint.pose for waypoint in path)]
    lengths_m = [math.dist(a[:3], b[:3]) for a, b in itertools.pairwise(poses)]
    blended = []
    for i, waypoint in enumerate(path):
        room_m = _BLEND_SHARE * min(lengths_m[i : i + 2]) if i + 1 < len(path) else 0.0
        # A blend is as slow as the slower of its legs, so it is kept short beside a slow one.
        slow = i + 1 < len(path) and min(w.speed_m_s for w in path[i : i + 2]) <= slow_m_s
        radius_m = round(min(blend_m, room_m, _SLOW_BLEND_M if slow else math.inf), 6)
        blended.append(waypoint.model_copy(update={"blend_radius_m": radius_m}))
    return tuple(blended)


def _sideways_m(here: Matrix, there: Matrix) -> float:
    return math.hypot(here[0, 3] - there[0, 3], here[1, 3] - there[1, 3])


def _joints(start: Joints, way: Floats, share: float) -> Joints:
    a, b, c, d, e, f = (float(s + share * w) for s, w in zip(start, way, strict=True))
    return (a, b, c, d, e, f)


def _name(cell: Cell) -> str:
    return f"cell [{cell.x}, {cell.y}, {cell.z}]"
