"""The checks that every movement passes, a planned route and an operator's command alike: reach,
one arm configuration, joint speed, and what the gripper and its part sweep on their way.
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
from cellctl.assembling.links import links_touch
from cellctl.assembling.obstacles import (
    TOUCH_M,
    Body,
    Flags,
    Obstacles,
    Surroundings,
    first_named,
    first_touched,
    gripper_body,
    part_body,
)
from cellctl.assembling.poses import Floats, Matrix, interpolate, to_matrix
from cellctl.assembling.timing import blend_chord, leg_length_m
from cellctl.assembly import Cell, Value
from cellctl.config import CellConfig, Joints, Pose
from cellctl.errors import PlanError

_SAMPLE_M = 0.04
"""Spacing of the poses at which reach and configuration are checked."""
_JUMP_RAD = 1.0
"""Joints that differ by more than this between two neighbouring samples change configuration."""
_JOINT_SPEED_SHARE = 0.8
"""How much of the joints' speed a route may use; the rest is for accelerating and blends."""
_JOINT_STEP_RAD = math.radians(3.0)
_WITHDRAWAL_STEP_M = 0.002
_CLOSER_M = 1e-4
"""Nothing comes closer by more than this, which is rounding."""
_DEEPEST_M = 0.02
"""An arm that is deeper in something than this is let up past nothing else as deeply."""
_LEAVING_SHARE = 0.1
"""What touches is left by at least this share of the way."""


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
    joints: Joints | None = None
    """Where the path alone does not lead there, the joint position to turn to at its end."""
    joint_speed_rad_s: float = 0.0
    """Speed of the joint that turns farthest."""

    def slowed(self, fraction: float) -> Route:
        """The same route at a fraction (0 to 1) of its speeds. Blends and checks hold as well."""
        assert 0.0 < fraction <= 1.0, "a route is slowed by a fraction"
        path = tuple(
            waypoint.model_copy(update={"speed_m_s": waypoint.speed_m_s * fraction})
            for waypoint in self.path
        )
        return self.model_copy(
            update={
                "path": path,
                "duration_s": self.duration_s / fraction,
                "joint_speed_rad_s": self.joint_speed_rad_s * fraction,
            }
        )


class Leg(NamedTuple):
    """One straight leg of a path, as the joints see it."""

    limit_m_s: float
    """Greatest TCP speed at which every joint stays within its share."""
    joints_rad: Joints
    """Where the leg ends."""


class Scene(NamedTuple):
    """What moves, and what it must not touch."""

    bodies: tuple[Body, ...]
    obstacles: tuple[Obstacles, ...]


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

    def scene(self, placed: Collection[Cell], *, carrying: bool) -> Scene:
        """The gripper, with or without a part, among what stands; without one in the gripper, the
        next part lies at the pick station."""
        bodies = (self._gripper, self._part) if carrying else (self._gripper,)
        return Scene(bodies, self._surroundings.around(placed, part_at_station=not carrying))

    def check(self, start: Stance, path: Sequence[Waypoint], scene: Scene) -> Stance:
        """Check a whole path.

        Returns:
            Where it ends.

        Raises:
            PlanError: it leaves the arm's reach or configuration, is too fast for a joint, or
                touches something; the message says where.
        """
        legs = self.legs(start, [waypoint.pose for waypoint in path])
        for waypoint, leg in zip(path, legs, strict=True):
            if waypoint.speed_m_s > leg.limit_m_s * 1.001:
                raise PlanError(
                    f"{waypoint.speed_m_s:.2f} m/s is too fast for the arm's joints on the way to "
                    f"{self._where(to_matrix(waypoint.pose))} (at most {leg.limit_m_s:.2f} m/s)."
                )
        self.check_sweeps(start.tcp_pose, path, scene)
        return Stance(path[-1].pose, legs[-1].joints_rad) if path else start

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
        poses = [
            self._frames.tcp(self._kinematics.forward(_joints(start.joints_rad, way, i / steps)))
            for i in range(steps + 1)
        ]
        for before, after in itertools.pairwise(poses):
            touched = first_touched(scene.obstacles, scene.bodies, before, after)
            if touched is not None:
                raise PlanError(f"Turning the joints there would touch {touched}.")
        for i in range(steps + 1):
            joints_rad = _joints(start.joints_rad, way, i / steps)
            touched = links_touch(joints_rad, self._kinematics.model, scene.obstacles)
            if touched is not None:
                raise PlanError(f"Turning the joints there would bring the elbow to {touched}.")
        return largest_rad

    def check_withdrawal(self, start: Pose, end: Pose, scene: Scene, margin_m: float) -> None:
        """Check a short straight way from wherever the arm stands, too close to something or not.

        What is farther away than the margin stays so. What is nearer never comes nearer, so that
        an arm can always leave; straight up it may pass beside what is no nearer sideways than
        what is touched already. What touches is left behind and not dragged along sideways.

        Raises:
            PlanError: something is in the way; the message names it.
        """
        a, b = to_matrix(start), to_matrix(end)
        length_m = leg_length_m(start, end)
        steps = max(1, math.ceil(length_m / _WITHDRAWAL_STEP_M))
        poses = [interpolate(a, b, i / steps) for i in range(steps + 1)]
        rising_m = (self._frames.cell_from_base @ (b - a))[:3, 3]
        lifting = math.hypot(rising_m[0], rising_m[1]) < 1e-6 < rising_m[2]
        what = "part it carries" if len(scene.bodies) > 1 else "empty gripper"
        pairs = [(group, body) for group in scene.obstacles for body in scene.bodies]
        touched_m = min(float(group.gaps_m(body, a).min()) for group, body in pairs)
        for group, body in pairs:
            near_m = np.minimum([group.gaps_m(body, pose) for pose in poses], margin_m)
            nearest_yet_m = np.maximum.accumulate(near_m, axis=0)
            closer: Flags = np.any(near_m < nearest_yet_m - _CLOSER_M, axis=0)
            if lifting:
                beside_m = max(min(touched_m, -TOUCH_M), -_DEEPEST_M) - _CLOSER_M
                closer = np.logical_and(closer, group.sideways_m(body, a) < beside_m)
            if (name := first_named(group, closer)) is not None:
                raise PlanError(
                    f"The {what} would come closer to {name} than {margin_m * 100:.0f} cm, or "
                    "than it is; only a way that leads off is open."
                )
            # Of all that is touched, what is touched most: a corner between two parts is left
            # along the face of the one and away from the other.
            deepest_m = near_m.min(axis=1)
            dragged = np.diff(deepest_m) < _LEAVING_SHARE * length_m / steps
            dragged &= deepest_m[:-1] < TOUCH_M
            if dragged.any() and not lifting:
                name = group.names[int(near_m[int(np.argmax(dragged))].argmin())]
                raise PlanError(
                    f"The {what} touches {name} and would drag along it; go straight up first."
                )

    def legs(self, start: Stance, poses: Sequence[Pose]) -> list[Leg]:
        """Follow the straight legs from pose to pose with the joints.

        Raises:
            PlanError: a pose is out of reach, or the arm's configuration would change.
        """
        legs = []
        before, joints_rad = start.tcp_pose, start.joints_rad
        for pose in poses:
            samples = self._leg_joints(before, joints_rad, pose)
            limit_m_s = _speed_limit_m_s(leg_length_m(before, pose), joints_rad, samples)
            legs.append(Leg(limit_m_s, samples[-1]))
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

    def check_sweeps(self, start: Pose, path: Sequence[Waypoint], scene: Scene) -> None:
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
                touched = first_touched(
                    scene.obstacles, scene.bodies, to_matrix(begin), to_matrix(end)
                )
                if touched is not None:
                    what = "part it carries" if len(scene.bodies) > 1 else "empty gripper"
                    raise PlanError(f"The {what} would touch {touched}.")
            before = waypoint.pose

    def _where(self, tcp: Matrix) -> str:
        x, y, z = (self._frames.cell_from_base @ tcp)[:3, 3]
        return f"({x:.3f}, {y:.3f}, {z:.3f}) m of the cell"


def _speed_limit_m_s(length_m: float, start: Joints, samples: Sequence[Joints]) -> float:
    """Greatest speed along a leg at which no joint is faster than its share."""
    if length_m <= 0.0:
        return math.inf
    stations = np.array([start, *samples])
    per_metre = np.max(np.abs(np.diff(stations, axis=0)), axis=0) * len(samples) / length_m
    limits = _JOINT_SPEED_SHARE * np.array(JOINT_SPEEDS_RAD_S)
    return float(np.min(limits / np.maximum(per_metre, 1e-9)))


def _joints(start: Joints, way: Floats, share: float) -> Joints:
    a, b, c, d, e, f = (float(s + share * w) for s, w in zip(start, way, strict=True))
    return (a, b, c, d, e, f)
