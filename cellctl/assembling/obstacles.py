"""What the gripper and its part must not touch, as boxes, and what they sweep on a straight way.

A box that moves on a straight line without turning touches a fixed box exactly when the moving
box's centre enters the fixed box grown by the moving one's half edges. So each obstacle keeps the
frame in which it is a plain box, and the line is tested there.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cellctl.assembling.frames import Frames
from cellctl.assembling.poses import Floats, Matrix, interpolate, inverse
from cellctl.assembly import Cell
from cellctl.config import CellConfig, Vector

Flags = npt.NDArray[np.bool_]

TOUCH_M = 0.002
"""Boxes that overlap by less than this only touch: parts lie face to face."""

_TURNING = 1e-9
"""Rotation matrices that differ by more than this belong to a movement that turns."""
_FAR_M = 3.0
"""Beyond the arm's reach in any direction."""
_COLUMN_M = (0.24, 0.24, 0.30)
"""The arm's own base and shoulder, above its foot: no place for the gripper (UR10: 0.19 m across
the foot, shoulder at 0.18 m)."""


@dataclass(frozen=True)
class Body:
    """A box that moves with the TCP: the gripper, or the part in it.

    Args:
        low: minimum corner in the TCP frame, in metres.
        high: maximum corner.
    """

    low: Vector
    high: Vector

    @cached_property
    def corners(self) -> Floats:
        """The eight corners in the TCP frame, as rows."""
        return np.array(list(itertools.product(*zip(self.low, self.high, strict=True))))


@dataclass(frozen=True)
class Obstacles:
    """Boxes that are aligned with one frame.

    Args:
        frame_from_base: 4x4 transform from the robot's base frame.
        names: one for each box.
        low: n x 3 minimum corners in the frame, in metres.
        high: n x 3 maximum corners.
    """

    frame_from_base: Matrix
    names: tuple[str, ...]
    low: Floats
    high: Floats

    def touched(
        self, body: Body, start: Matrix, end: Matrix, margin_m: Vector = (0.0, 0.0, 0.0)
    ) -> Flags:
        """Which boxes the body touches on its way.

        Args:
            body: what moves.
            start: TCP pose in the base frame where the way begins.
            end: where it ends.
            margin_m: grows the boxes along the frame's axes; infinity takes that axis out.

        Returns:
            n booleans.
        """
        turning = float(np.abs(start[:3, :3] - end[:3, :3]).max()) > _TURNING
        poses = [interpolate(start, end, i / 4) for i in range(5)] if turning else [start]
        corners = body.corners.T
        extent = np.concatenate(
            [((self.frame_from_base @ pose)[:3, :3] @ corners).T for pose in poses]
        )
        grown_low = self.low - extent.max(axis=0) - margin_m + TOUCH_M
        grown_high = self.high - extent.min(axis=0) + margin_m - TOUCH_M
        origin = (self.frame_from_base @ start)[:3, 3]
        way = (self.frame_from_base @ end)[:3, 3] - origin
        return _line_enters(origin, way, grown_low, grown_high)

    def gaps_m(self, body: Body, pose: Matrix) -> Floats:
        """How far the body is from each box, in metres; negative by how deep it is in one.

        Args:
            body: what moves.
            pose: TCP pose in the base frame.

        Returns:
            n distances.
        """
        apart = self._apart_m(body, pose)
        outside = np.linalg.norm(np.maximum(apart, 0.0), axis=1)
        gaps: Floats = np.where(outside > 0.0, outside, apart.max(axis=1))
        return gaps

    def sideways_m(self, body: Body, pose: Matrix) -> Floats:
        """The same, sideways only, however high body and boxes are."""
        sideways: Floats = self._apart_m(body, pose)[:, :2].max(axis=1)
        return sideways

    def _apart_m(self, body: Body, pose: Matrix) -> Floats:
        """n x 3 distances along the frame's axes; negative where the extents overlap."""
        frame = self.frame_from_base @ pose
        corners = body.corners @ frame[:3, :3].T + frame[:3, 3]
        apart: Floats = np.maximum(self.low - corners.max(axis=0), corners.min(axis=0) - self.high)
        return apart


def _line_enters(origin: Floats, way: Floats, low: Floats, high: Floats) -> Flags:
    """Whether the segment from ``origin`` along ``way`` enters each box (n x 3 corners)."""
    moving = np.abs(way) > 1e-12
    divisor = np.where(moving, way, 1.0)
    first, second = (low - origin) / divisor, (high - origin) / divisor
    # An axis along which nothing moves bars the box for ever or not at all.
    inside = (low < origin) & (origin < high)
    enter = np.where(moving, np.minimum(first, second), np.where(inside, -np.inf, np.inf))
    leave = np.where(moving, np.maximum(first, second), np.where(inside, np.inf, -np.inf))
    begin = np.maximum(enter.max(axis=1), 0.0)
    finish = np.minimum(leave.min(axis=1), 1.0)
    flags: Flags = (begin < finish) | inside.all(axis=1)
    return flags


def gripper_body(config: CellConfig) -> Body:
    """The latch gripper, from the part's top face up to the flange."""
    half_m = config.tool.width_m / 2
    return Body((-half_m, -half_m, -config.tool.height_m), (half_m, half_m, 0.0))


def part_body(config: CellConfig) -> Body:
    """A gripped voxel."""
    half_m = config.voxel.pitch_m / 2
    return Body((-half_m, -half_m, 0.0), (half_m, half_m, config.voxel.pitch_m))


class Surroundings:
    """The obstacles of one cell: what never moves, and what was placed.

    Args:
        config: the cell.
        frames: its frames.
    """

    def __init__(self, config: CellConfig, frames: Frames) -> None:
        self._pitch_m = config.voxel.pitch_m
        base = frames.base_from_cell
        self._workspace_from_base = inverse(base @ frames.cell_from_workspace)
        feeder_from_base = inverse(base @ frames.cell_from_feeder)
        half_belt_m, pitch_m = config.feeder.width_m / 2, self._pitch_m
        feeder_height_m = float(frames.cell_from_feeder[2, 3])
        below_belt_m = min(-pitch_m - TOUCH_M, -feeder_height_m)
        width_m, depth_m, height_m = config.pedestal.size_m
        column_x_m, column_y_m, column_z_m = _COLUMN_M
        self._fixed = (
            _boxes(inverse(base), {"the floor": ((-_FAR_M,) * 3, (_FAR_M, _FAR_M, 0.0))}),
            _boxes(
                inverse(base @ frames.cell_from_pedestal),
                {
                    "the pedestal": (
                        (-width_m / 2, -depth_m / 2, -height_m),
                        (width_m / 2, depth_m / 2, 0.0),
                    )
                },
            ),
            _boxes(
                np.eye(4),
                {
                    "the arm's own foot": (
                        (-column_x_m / 2, -column_y_m / 2, 0.0),
                        (column_x_m / 2, column_y_m / 2, column_z_m),
                    )
                },
            ),
            _boxes(
                feeder_from_base,
                {
                    "the belt": (
                        (-_FAR_M, -half_belt_m, below_belt_m),
                        (pitch_m / 2, half_belt_m, -pitch_m),
                    ),
                    "the parts that wait on the belt": (
                        (-_FAR_M, -pitch_m / 2, -pitch_m),
                        (-pitch_m / 2, pitch_m / 2, 0.0),
                    ),
                },
            ),
        )
        self._station = _boxes(
            feeder_from_base,
            {
                "the part at the pick station": (
                    (-pitch_m / 2, -pitch_m / 2, -pitch_m),
                    (pitch_m / 2, pitch_m / 2, 0.0),
                )
            },
        )

    def around(self, placed: Collection[Cell], *, part_at_station: bool) -> tuple[Obstacles, ...]:
        """Everything that the gripper and its part must not touch."""
        groups = list(self._fixed)
        if part_at_station:
            groups.append(self._station)
        if placed:
            cells = sorted(placed)
            low = np.array(cells, dtype=np.float64) * self._pitch_m
            names = tuple(f"the part at [{c.x}, {c.y}, {c.z}]" for c in cells)
            groups.append(Obstacles(self._workspace_from_base, names, low, low + self._pitch_m))
        return tuple(groups)


def first_named(group: Obstacles, flags: Flags) -> str | None:
    """Name of the first flagged obstacle of a group, or None."""
    hits = np.flatnonzero(flags)
    return group.names[int(hits[0])] if hits.size else None


def first_touched(
    groups: Sequence[Obstacles], bodies: Sequence[Body], start: Matrix, end: Matrix
) -> str | None:
    """Name of an obstacle that a body touches on the straight way, or None."""
    for group in groups:
        for body in bodies:
            name = first_named(group, group.touched(body, start, end))
            if name is not None:
                return name
    return None


def highest_below(
    groups: Sequence[Obstacles],
    bodies: Sequence[Body],
    start: Matrix,
    end: Matrix,
    *,
    margin_m: float,
    cell_from_base: Matrix,
) -> float:
    """Height above the floor of the tallest thing that the bodies pass over, or would pass
    through, on the way: 0 where there is nothing but floor.

    Args:
        groups: the obstacles.
        bodies: what moves.
        start: TCP pose in the base frame.
        end: the same.
        margin_m: sideways distance within which an obstacle counts.
        cell_from_base: to measure heights.
    """
    height_m = 0.0
    for group in groups:
        top_from_frame = cell_from_base @ inverse(group.frame_from_base)
        for body in bodies:
            hits = group.touched(body, start, end, (margin_m, margin_m, np.inf))
            tops_m = top_from_frame[2, 3] + group.high[hits, 2]
            height_m = max(height_m, float(tops_m.max(initial=0.0)))
    return height_m


def _boxes(frame_from_base: Matrix, boxes: dict[str, tuple[Vector, Vector]]) -> Obstacles:
    corners = list(boxes.values())
    return Obstacles(
        frame_from_base,
        tuple(boxes),
        np.array([low for low, _ in corners]),
        np.array([high for _, high in corners]),
    )
