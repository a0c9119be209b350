"""A path as the arm will go it: joints, position and orientation of the tool at points along it.

Of a path whose corners are reached on straight lines of the TCP, the joints follow from where the
tool is; of one on which the joints go straight, the tool follows from where the joints are.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cellctl.assembling.arm import JointWaypoint, Waypoint
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import Kinematics
from cellctl.assembling.poses import Floats, Matrix, to_matrix, to_pose
from cellctl.assembling.rounded import Piece, pieces
from cellctl.config import Joints, Pose

TURN_WEIGHT_M_PER_RAD = 0.5
"""Assumed: on a line, a radian of turning takes as long as this many metres."""
LINE_BLEND_ACCELERATION_M_S2 = 10.0
JOINT_BLEND_ACCELERATION_RAD_S2 = 10.0
"""Assumed: what a controller allows across a blend, unless the legs beside it are slower."""

_SPACING_M = 0.04
_SPACING_RAD = 0.05
_SAME_TURN_RAD = 1e-6
_ON_THE_SPOT_M = 1e-9
_REFINEMENTS = 2


@dataclass(frozen=True)
class Course:
    """Samples along a path, piece by piece.

    Args:
        pieces: in metres of the TCP's way, or in radians of the joints' (all six together).
        blend_acceleration: what a controller allows across a blend, per second squared.
        joints_rad: n x 6.
        points: n x 3, the TCP in the base frame, in metres.
        rotations: n x 3 x 3.
    """

    pieces: tuple[Piece, ...]
    blend_acceleration: float
    joints_rad: Floats
    points: Floats
    rotations: Floats

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Where the samples of each piece are."""
        found, begin = [], 0
        for piece in self.pieces:
            found.append(slice(begin, begin + len(piece.shares)))
            begin += len(piece.shares)
        return tuple(found)


def line_course(
    start: Pose, joints_rad: Joints, path: Sequence[Waypoint], frames: Frames, arm: Kinematics
) -> Course:
    """The course of straight lines of the TCP. Where the arm does not reach, joints are NaN."""
    poses = [to_matrix(start), *(to_matrix(waypoint.pose) for waypoint in path)]
    corners = np.array([pose[:3, 3] for pose in poses])
    turns = [_turn(one, other) for one, other in itertools.pairwise(poses)]
    turned_m = TURN_WEIGHT_M_PER_RAD * np.linalg.norm(turns, axis=1)
    straight_m = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    found = [
        _as_long_as_it_turns(piece, turned_m, straight_m)
        for piece in pieces(corners, [w.blend_radius_m for w in path[:-1]], _SPACING_M)
    ]
    points = np.concatenate([piece.values for piece in found])
    shares = np.concatenate([piece.shares for piece in found])
    rotations = _rotations(poses, turns, shares)
    flange = frames.tcp_from_flange
    joints = arm.follow(
        rotations @ flange[:3, :3],
        points + rotations @ flange[:3, 3],
        arm.branch(joints_rad),
        joints_rad,
    )
    return Course(tuple(found), LINE_BLEND_ACCELERATION_M_S2, joints, points, rotations)


def joint_course(
    corners_rad: Floats, path: Sequence[JointWaypoint], frames: Frames, arm: Kinematics
) -> Course:
    """The course on which the joints go straight from corner to corner.

    Args:
        corners_rad: k x 6, the start and the joint position of each waypoint.
        path: k - 1 waypoints.
        frames: the cell's frames.
        arm: its kinematics.
    """

    def tcp(joints: Floats) -> tuple[Floats, Floats]:
        turned, at = arm.forward_many(joints)
        tool = frames.flange_from_tcp
        return turned @ tool[:3, :3], at + turned @ tool[:3, 3]

    blends = _blends_rad(corners_rad, [w.blend_radius_m for w in path], tcp)
    found = pieces(corners_rad, blends, _SPACING_RAD)
    joints = np.concatenate([piece.values for piece in found])
    rotations, points = tcp(joints)
    return Course(found, JOINT_BLEND_ACCELERATION_RAD_S2, joints, points, rotations)


def _blends_rad(corners: Floats, blends_m: Sequence[float], tcp) -> list[float]:  # type: ignore[no-untyped-def]
    """Distance in joint space at which the TCP is a blend's radius away from its corner, on the
    leg on which that is less."""
    inner = [i for i in range(1, len(corners) - 1) if blends_m[i - 1] > 0.0]
    found = [0.0] * (len(corners) - 2)
    if not inner:
        return found
    wanted = np.repeat([blends_m[i - 1] for i in inner], 2)
    at = np.repeat(corners[inner], 2, axis=0)
    ways = np.array([corners[j] - corners[i] for i in inner for j in (i - 1, i + 1)])
    lengths = np.linalg.norm(ways, axis=1)
    _, centres = tcp(at)
    share = np.full(len(ways), 0.1)
    for _ in range(_REFINEMENTS):
        _, points = tcp(at + share[:, None] * ways)
        away = np.linalg.norm(points - centres, axis=1)
        share = np.clip(share * wanted / np.maximum(away, 1e-9), 1e-6, 1.0)
    reach = (share * lengths).reshape(-1, 2).min(axis=1)
    for i, value in zip(inner, reach.tolist(), strict=True):
        found[i - 1] = value
    return found


def _as_long_as_it_turns(piece: Piece, turned_m: Floats, straight_m: Floats) -> Piece:
    """The same piece, longer where turning takes longer than the way; an arc is as slow as the
    slower of the legs beside it."""
    legs = slice(piece.leg, piece.leg + 2 if piece.arc else piece.leg + 1)
    turned, straight = turned_m[legs], straight_m[legs]
    if not (turned > straight).any():
        return piece
    if straight.min() < _ON_THE_SPOT_M:
        return piece._replace(length=float(turned.max()))  # there is no arc beside it
    slower = float((turned / straight).max())
    return piece._replace(length=piece.length * slower, radius=piece.radius * slower**2)


def _turn(a: Matrix, b: Matrix) -> Floats:
    """Rotation vector that carries the axes of ``a`` to those of ``b``, in the frame of ``a``."""
    if float(np.abs(a[:3, :3] - b[:3, :3]).max()) < 1e-12:
        return np.zeros(3)
    between = np.eye(4)
    between[:3, :3] = a[:3, :3].T @ b[:3, :3]
    return np.array(to_pose(between)[3:])


def _rotations(poses: Sequence[Matrix], turns: Sequence[Floats], shares: Floats) -> Floats:
    """Orientations along the legs; a blend passes over from one leg's to the next one's."""
    if max((float(np.linalg.norm(turn)) for turn in turns), default=0.0) < _SAME_TURN_RAD:
        return np.broadcast_to(poses[0][:3, :3], (len(shares), 3, 3))
    found = []
    for value in shares.tolist():
        leg = min(int(value), len(turns) - 1)
        turned = to_matrix((0.0, 0.0, 0.0, *(turns[leg] * (value - leg))))
        found.append(poses[leg][:3, :3] @ turned[:3, :3])
    return np.array(found)


def leg_length_m(start: Pose, end: Pose) -> float:
    """Length of a straight leg as its duration sees it: turning counts as way."""
    turned_rad = float(np.linalg.norm(_turn(to_matrix(start), to_matrix(end))))
    return max(math.dist(start[:3], end[:3]), TURN_WEIGHT_M_PER_RAD * turned_rad)
