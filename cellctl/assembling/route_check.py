"""The checks that every movement passes, a planned route and an operator's command alike: reach,
one arm configuration away from its singular places, joint speed, and what the arm, the gripper and
its part sweep on their way, blends included.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import NamedTuple

import numpy as np

from cellctl.assembling import links
from cellctl.assembling.arm import JointWaypoint, Path, Waypoint
from cellctl.assembling.course import Course, joint_course, leg_length_m, line_course
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import (
    JOINT_LIMIT_RAD,
    JOINT_SPEEDS_RAD_S,
    Kinematics,
    as_joints,
    same_configuration,
)
from cellctl.assembling.limits import JointLimits, Use, timing_of
from cellctl.assembling.obstacles import (
    TOUCH_M,
    Body,
    Flags,
    Obstacles,
    Surroundings,
    gripper_body,
    part_body,
)
from cellctl.assembling.poses import Floats, Matrix, interpolate, to_matrix
from cellctl.assembly import Cell, Value
from cellctl.config import CellConfig, Joints, Pose
from cellctl.errors import PlanError

_SAMPLE_M = 0.04
"""Spacing of the poses at which a hand's step is checked."""
_JUMP_RAD = 1.0
"""Joints that differ by more than this between two neighbouring samples change configuration."""
_LIMIT_MARGIN_RAD = math.radians(5.0)
"""A planned route keeps this far from every joint's limit."""
_STRAIGHT_ELBOW = math.sin(math.radians(6.0))
_STRAIGHT_WRIST = math.sin(math.radians(10.0))
_NEAR_AXIS_M = 0.05
"""A planned route keeps the wrist this far outside the cylinder about the base's axis in which a
UR arm cannot work."""
_BEYOND = "does not reach"
_CROSSING_SAMPLES = 33
_JOINT_STEP_RAD = math.radians(3.0)
_PLANNED_SHARE = 0.94
"""Of the joints' greatest acceleration; the rest is for what lies between a curve's samples."""
_SIDEWAYS_M = 1e-4
_MARGIN_SHARE = 0.25
"""Of the distance from an end of a path sideways: so much of it is margin, up to all of it. A way
that leads off a face at 15 degrees or more keeps it."""


class Stance(NamedTuple):
    """Where an arm is: what it reports, or what is predicted for it."""

    tcp_pose: Pose
    """In the base frame."""
    joints_rad: Joints


class Route(Value):
    """A checked path from one stance."""

    path: Path
    """Empty where the arm is already there."""
    duration_s: float
    """Planned, from rest to rest, in cell time."""
    crossing_height_m: float
    """Greatest height of the TCP above the floor."""
    end: Stance
    joints: Joints | None = None
    """Where the path alone does not lead there, the joint position to turn to at its end."""
    joint_speed_rad_s: float = 0.0
    """Speed of the joint that turns farthest."""

    def slowed(self, fraction: float) -> Route:
        """The same route at a fraction (0 to 1) of its speeds. Blends and checks hold as well."""
        assert 0.0 < fraction <= 1.0, "a route is slowed by a fraction"
        path = tuple(_slowed(waypoint, fraction) for waypoint in self.path)
        return self.model_copy(
            update={
                "path": path,
                "duration_s": self.duration_s / fraction,
                "joint_speed_rad_s": self.joint_speed_rad_s * fraction,
            }
        )


def _slowed(waypoint: Waypoint | JointWaypoint, fraction: float) -> Waypoint | JointWaypoint:
    name = "speed_rad_s" if isinstance(waypoint, JointWaypoint) else "speed_m_s"
    return waypoint.model_copy(update={name: getattr(waypoint, name) * fraction})


class Leg(NamedTuple):
    """One straight leg of a path, as the joints see it."""

    limit_m_s: float
    """Greatest TCP speed at which every joint stays within its share."""
    joints_rad: Joints
    """Where the leg ends."""
    samples: Floats
    """n x 6 joint positions along it, its start included."""


class Scene(NamedTuple):
    """What moves, and what it must not touch."""

    bodies: tuple[Body, ...]
    obstacles: tuple[Obstacles, ...]

    @property
    def carrying(self) -> bool:
        """Whether a part moves with the gripper."""
        return len(self.bodies) > 1

    @property
    def what(self) -> str:
        """What moves, in words."""
        return "part it carries" if self.carrying else "empty gripper"


class RouteChecker:
    """Checks movements of one cell. Pure: it moves nothing and asks nothing.

    Args:
        config: the cell.
        frames: its frames.
        kinematics: its arm.
    """

    def __init__(self, config: CellConfig, frames: Frames, kinematics: Kinematics) -> None:
        self._frames = frames
        self._kinematics = kinematics
        self._surroundings = Surroundings(config, frames)
        self._gripper = gripper_body(config)
        self._part = part_body(config)
        self._margin_m = config.robot.margin_m
        self._half_tool_m = config.tool.width_m / 2
        self._tool_m = config.tool.height_m
        self.limits = JointLimits(
            config.robot.joint_speed_fraction * np.array(JOINT_SPEEDS_RAD_S),
            np.full(6, _PLANNED_SHARE * config.robot.joint_acceleration_rad_s2),
        )

    def scene(self, placed: Collection[Cell], *, carrying: bool) -> Scene:
        """The gripper, with or without a part, among what stands; without one in the gripper, the
        next part lies at the pick station."""
        bodies = (self._gripper, self._part) if carrying else (self._gripper,)
        return Scene(bodies, self._surroundings.around(placed, part_at_station=not carrying))

    def course(self, start: Stance, path: Path) -> Course:
        """How the arm goes a path, on the branch on which it starts.

        Raises:
            PlanError: it leaves the arm's reach, or comes too near to a joint's limit or to a place
                where the arm would change its configuration.
        """
        if isinstance(path[0], JointWaypoint):
            turning = [point for point in path if isinstance(point, JointWaypoint)]
            corners = self.corners_rad(start, [to_matrix(point.pose) for point in turning])
            course = joint_course(corners, turning, self._frames, self._kinematics)
        else:
            straight = [point for point in path if isinstance(point, Waypoint)]
            course = line_course(
                start.tcp_pose, start.joints_rad, straight, self._frames, self._kinematics
            )
        self._check_reach(start.joints_rad, course)
        return course

    def corners_rad(self, start: Stance, corners: Sequence[Matrix]) -> Floats:
        """Joint positions of a start and of TCP poses, n + 1 x 6, each near the one before.

        Raises:
            PlanError: one is out of reach.
        """
        flanges = np.array(corners) @ self._frames.tcp_from_flange
        joints = self._kinematics.follow(
            flanges[:, :3, :3],
            flanges[:, :3, 3],
            self._kinematics.branch(start.joints_rad),
            start.joints_rad,
        )
        self._refuse(np.array(corners)[:, :3, 3], np.isnan(joints.sum(axis=1)), _BEYOND)
        return np.concatenate([np.array(start.joints_rad)[None, :], joints])

    def tcp_between(self, start: Stance, here: Matrix, there: Matrix) -> tuple[Floats, Floats]:
        """Where the TCP is, n x 3 and n x 3 x 3, while the joints go straight from pose to pose.

        Raises:
            PlanError: one of them is out of reach.
        """
        _, first, last = self.corners_rad(start, [here, there])
        joints = first + np.linspace(0.0, 1.0, _CROSSING_SAMPLES)[:, None] * (last - first)
        turned, at = self._kinematics.forward_many(joints)
        tool = self._frames.flange_from_tcp
        return at + turned @ tool[:3, 3], turned @ tool[:3, :3]

    def _check_reach(self, start_rad: Joints, course: Course) -> None:
        joints, points = course.joints_rad, course.points
        self._refuse(points, np.isnan(joints.sum(axis=1)), _BEYOND)
        self._refuse(
            points,
            np.abs(joints).max(axis=1) > JOINT_LIMIT_RAD - _LIMIT_MARGIN_RAD,
            "would come to the end of a joint at",
        )
        flange = course.rotations @ self._frames.tcp_from_flange[:3, :3]
        at = points + course.rotations @ self._frames.tcp_from_flange[:3, 3]
        wrist = at[:, :2] - self._kinematics.lengths.d6 * flange[:, :2, 2]
        tight = (
            (np.abs(np.sin(joints[:, 2])) < _STRAIGHT_ELBOW)
            | (np.abs(np.sin(joints[:, 4])) < _STRAIGHT_WRIST)
            | (np.hypot(wrist[:, 0], wrist[:, 1]) < self._kinematics.lengths.d4 + _NEAR_AXIS_M)
        )
        self._refuse(points, tight, "would come to a place where it must change its configuration,")
        jumps = np.abs(np.diff(joints, axis=0, prepend=np.array(start_rad)[None, :]))
        self._refuse(
            points, jumps.max(axis=1) > _JUMP_RAD, "would have to change its configuration at"
        )

    def check_room(
        self, course: Course, scene: Scene, touch_m: float = TOUCH_M, sink_m: float = 0.0
    ) -> None:
        """Check what everything that moves sweeps on a path.

        The gripper and its part keep the margin, but where they go straight up or down at one end
        of the path: there parts stand face to face. Sideways they get the margin by and by: it
        grows with the distance from the end.

        Args:
            course: the path.
            scene: what moves, and what is in the way.
            touch_m: what overlaps by this, where no margin is kept, only touches.
            sink_m: there, what comes from above may sink in by so much more.

        Raises:
            PlanError: they touch something.
        """
        points = course.points
        margins = np.minimum(self._margin_m, _MARGIN_SHARE * self._aside_m(points))
        for group in scene.obstacles:
            for body in scene.bodies:
                touched = group.touched(
                    body, points, course.rotations, margins, touch_m=touch_m, sink_m=sink_m
                )
                if touched.any():
                    name = group.names[int(np.argmax(touched.any(axis=0)))]
                    raise PlanError(f"The {scene.what} would touch {name}.")
        arm = self.check_links(course.joints_rad, scene)
        if self._own_gap_m(arm, points, course.rotations, scene) < self._margin_m:
            raise PlanError(f"The {scene.what} would come too close to the arm itself.")

    def check_links(self, joints_rad: Floats, scene: Scene) -> links.Links:
        """The same for the arm's links alone.

        Args:
            joints_rad: n x 6.
            scene: what is in the way.

        Raises:
            PlanError: one comes too close to something.
        """
        arm = links.links(joints_rad, self._kinematics.model)
        near = links.nearest(arm, scene.obstacles, self._margin_m)
        if near.gap_m < self._margin_m:
            raise PlanError(f"The arm's {near.link} would come too close to {near.other}.")
        return arm

    def near_links(self, joints_rad: Floats, cells: Sequence[Cell]) -> frozenset[Cell]:
        """Those cells in which a part would come too close to one of the arm's links.

        Args:
            joints_rad: n x 6.
            cells: which are looked at, at least one.
        """
        arm = links.links(joints_rad, self._kinematics.model)
        gaps = links.gaps_m(arm, self._surroundings.parts(cells))
        near = gaps.min(axis=(0, 1)) < self._margin_m
        return frozenset(cell for cell, close in zip(cells, near, strict=True) if close)

    def line_duration_s(self, start: Stance, path: Sequence[Waypoint]) -> float:
        """How long straight lines of the TCP take, from rest to rest."""
        course = line_course(start.tcp_pose, start.joints_rad, path, self._frames, self._kinematics)
        return timing_of(course, tuple(path)).duration_s

    def check(self, start: Stance, path: Path, scene: Scene) -> Stance:
        """Check a whole path.

        Returns:
            Where it ends.

        Raises:
            PlanError: it leaves the arm's reach or configuration, is too fast for a joint, or
                touches something; the message says where.
        """
        if not path:
            return start
        course = self.course(start, path)
        used = np.abs(Use(course).joint_speeds_rad_s(timing_of(course, path)))
        share = (used / np.array(JOINT_SPEEDS_RAD_S)).max(axis=1)
        if float(share.max()) > 1.001:
            where = np.eye(4)
            where[:3, 3] = course.points[int(np.argmax(share))]
            raise PlanError(
                f"The path is too fast for the arm's joints at {self._where(where)}: "
                f"they bear {1.0 / float(share.max()):.0%} of its speed."
            )
        self.check_room(course, scene)
        return Stance(path[-1].pose, as_joints(course.joints_rad[-1]))

    def check_joint_move(self, start: Stance, target_rad: Joints, scene: Scene) -> float:
        """Check a movement in joint space, in which all joints start and end together.

        Returns:
            The largest angle that a joint turns, in radians.

        Raises:
            PlanError: it touches something on the way.
        """
        way = np.subtract(target_rad, start.joints_rad)
        largest_rad = float(np.max(np.abs(way)))
        steps = max(1, math.ceil(largest_rad / _JOINT_STEP_RAD))
        shares = np.linspace(0.0, 1.0, steps + 1)[:, None]
        joints = np.array(start.joints_rad) + shares * way
        poses = [self._frames.tcp(self._kinematics.forward(as_joints(row))) for row in joints]
        points = np.array([pose[:3, 3] for pose in poses])
        rotations = np.array([pose[:3, :3] for pose in poses])
        for group in scene.obstacles:
            for body in scene.bodies:
                touched = group.touched(body, points, rotations, np.zeros(steps)).any(axis=0)
                if touched.any():
                    name = group.names[int(np.argmax(touched))]
                    raise PlanError(f"Turning the joints there would touch {name}.")
        arm = links.links(joints, self._kinematics.model)
        near = links.nearest(arm, scene.obstacles, 0.0)
        if near.gap_m < 0.0:
            raise PlanError(
                f"Turning the joints there would bring the {near.link} to {near.other}."
            )
        if self._own_gap_m(arm, points, rotations, scene) < 0.0:
            raise PlanError("Turning the joints there would bring the gripper to the arm itself.")
        return largest_rad

    def legs(self, start: Stance, poses: Sequence[Pose]) -> list[Leg]:
        """Follow straight legs from pose to pose with the joints, from any configuration.

        Raises:
            PlanError: a pose is out of reach, or the arm's configuration would change.
        """
        legs = []
        before, joints_rad = start.tcp_pose, start.joints_rad
        for pose in poses:
            samples = np.array([joints_rad, *self._leg_joints(before, joints_rad, pose)])
            limit_m_s = self._speed_limit_m_s(leg_length_m(before, pose), samples)
            legs.append(Leg(limit_m_s, as_joints(samples[-1]), samples))
            before, joints_rad = pose, legs[-1].joints_rad
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

    def _speed_limit_m_s(self, length_m: float, samples: Floats) -> float:
        """Greatest speed along a leg at which no joint is faster than its share."""
        if length_m <= 0.0:
            return math.inf
        per_metre = np.abs(np.diff(samples, axis=0)).max(axis=0) * (len(samples) - 1) / length_m
        return float(np.min(self.limits.speed_rad_s / np.maximum(per_metre, 1e-9)))

    def _own_gap_m(
        self, arm: links.Links, points: Floats, rotations: Floats, scene: Scene
    ) -> float:
        """Between the upper arm or forearm and what hangs from the flange."""
        lowest_m = max(body.high[2] for body in scene.bodies)
        depths = np.linspace(-self._tool_m, lowest_m, 4)
        tool = points[:, None, :] + rotations[:, None, :, 2] * depths[None, :, None]
        return links.own_gap_m(arm, tool, math.sqrt(2.0) * self._half_tool_m)

    def _aside_m(self, points: Floats) -> Floats:
        """How far each way from point to point is from straight above either end of the path."""
        level = points @ self._frames.cell_from_base[:3, :3].T
        ends = [np.hypot(*(level - end)[:, :2].T) for end in (level[0], level[-1])]
        off = np.minimum(*ends)
        aside: Floats = np.minimum(off[1:], off[:-1])
        return np.where(aside > _SIDEWAYS_M, aside, 0.0)

    def _refuse(self, points: Floats, bad: Flags, why: str) -> None:
        """Raises PlanError where any point is flagged."""
        if bad.any():
            where = np.eye(4)
            where[:3, 3] = points[int(np.argmax(bad))]
            raise PlanError(f"The arm {why} {self._where(where)}.")

    def _where(self, tcp: Matrix) -> str:
        x, y, z = (self._frames.cell_from_base @ tcp)[:3, 3]
        return f"({x:.3f}, {y:.3f}, {z:.3f}) m of the cell"
