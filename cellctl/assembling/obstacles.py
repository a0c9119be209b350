"""What the gripper and its part must not touch, as boxes, and what they sweep on a straight way.

A box that moves on a straight line without turning touches a fixed box exactly when the moving
box's centre enters the fixed box grown by the moving one's half edges. So each obstacle keeps the
frame in which it is a plain box, and the line is tested there.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cellctl.assembling.frames import Frames
from cellctl.assembling.poses import Floats, Matrix, inverse
from cellctl.assembly import Cell
from cellctl.config import CellConfig, Vector

Flags = npt.NDArray[np.bool_]

TOUCH_M = 0.002
"""Boxes that overlap by less than this only touch: parts lie face to face."""

_ALIGNED = 1e-9
"""Frames whose axes differ by less are aligned: a micrometre over a kilometre."""
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
    def middle(self) -> Floats:
        """Its centre in the TCP frame."""
        middle: Floats = (np.array(self.low) + np.array(self.high)) / 2.0
        return middle

    @cached_property
    def half(self) -> Floats:
        """Its half edges."""
        half: Floats = (np.array(self.high) - np.array(self.low)) / 2.0
        return half

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
        passed_over: routes may pass over them; else they only keep clear.
    """

    frame_from_base: Matrix
    names: tuple[str, ...]
    low: Floats
    high: Floats
    passed_over: bool = True

    def touched(
        self,
        body: Body,
        points: Floats,
        rotations: Floats,
        margins_m: Floats,
        *,
        touch_m: float = TOUCH_M,
        sink_m: float = 0.0,
    ) -> Flags:
        """Which boxes the body touches on each straight way from one point to the next.

        Args:
            body: what moves.
            points: n x 3 positions of the TCP in the base frame.
            rotations: n x 3 x 3, the TCP's orientation there; it turns little from one to the next.
            margins_m: n - 1 distances to keep; with 0, what overlaps by ``touch_m`` only touches.
            touch_m: see there.
            sink_m: and by so much more where the body is above a box.

        Returns:
            (n - 1) x boxes.
        """
        low, high = self._extents(body, rotations)
        frame = self.frame_from_base
        origins = points @ frame[:3, :3].T + frame[:3, 3]
        flags: Flags = np.zeros((len(points) - 1, len(self.names)), dtype=np.bool_)
        # Only boxes that meet a box around all that is swept can be touched.
        widest_m = float(margins_m.max(initial=0.0))
        low, high = np.minimum(low[:-1], low[1:]), np.maximum(high[:-1], high[1:])
        swept_low = (np.minimum(origins[:-1], origins[1:]) + low).min(axis=0) - widest_m
        swept_high = (np.maximum(origins[:-1], origins[1:]) + high).max(axis=0) + widest_m
        near = np.flatnonzero(((self.high > swept_low) & (self.low < swept_high)).all(axis=1))
        if near.size == 0:
            return flags
        face_to_face = margins_m <= touch_m
        keep = np.where(face_to_face, margins_m - touch_m, margins_m)[:, None, None]
        grown_low = self.low[near] - high[:, None, :] - keep
        grown_high = self.high[near] - low[:, None, :] + keep
        grown_high[:, :, 2] -= np.where(face_to_face, sink_m, 0.0)[:, None]
        ways = np.diff(origins, axis=0)[:, None, :]
        begin, finish = _entered(origins[:-1, None, :], ways, grown_low, grown_high)
        flags[:, near] = begin < finish
        return flags

    def touched_at(self, body: Body, poses: Floats) -> Flags:
        """Which boxes the body touches at each of n poses of the TCP (n x 4 x 4): n x boxes."""
        low, high = self._extents(body, poses[:, :3, :3])
        frame = self.frame_from_base
        at = poses[:, :3, 3] @ frame[:3, :3].T + frame[:3, 3]
        before = (at + high)[:, None, :] > self.low + TOUCH_M
        behind = (at + low)[:, None, :] < self.high - TOUCH_M
        flags: Flags = np.all(before & behind, axis=2)
        return flags

    def sideways_all_m(self, body: Body, points: Floats, rotations: Floats) -> Floats:
        """How far the body is from each box sideways, however high both are: points x boxes;
        negative where one is above the other."""
        low, high = self._extents(body, rotations)
        at = (points @ self.frame_from_base[:3, :3].T + self.frame_from_base[:3, 3])[:, None, :2]
        before = self.low[:, :2] - (at + high[:, None, :2])
        behind = at + low[:, None, :2] - self.high[:, :2]
        apart: Floats = np.maximum(before, behind).max(axis=2)
        return apart

    def _extents(self, body: Body, rotations: Floats) -> tuple[Floats, Floats]:
        """Minimum and maximum corner of the body about the TCP along this frame's axes, n x 3."""
        turned = self.frame_from_base[:3, :3] @ rotations
        middle, reach = turned @ body.middle, np.abs(turned) @ body.half
        return middle - reach, middle + reach

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


def _entered(origin: Floats, way: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Shares of a segment at which it enters and leaves boxes; not inside where the first is not
    less. A segment of no length that begins inside is inside from 0 to 1."""
    moving = np.abs(way) > 1e-12
    divisor = np.where(moving, way, 1.0)
    first, second = (low - origin) / divisor, (high - origin) / divisor
    # An axis along which nothing moves bars the box for ever or not at all.
    inside = (low < origin) & (origin < high)
    enter = np.where(moving, np.minimum(first, second), np.where(inside, -np.inf, np.inf))
    leave = np.where(moving, np.maximum(first, second), np.where(inside, np.inf, -np.inf))
    return np.maximum(enter.max(axis=-1), 0.0), np.minimum(leave.min(axis=-1), 1.0)


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
        # Boxes of one alignment are looked at together: few large questions are quicker than many.
        self._fixed = joined(
            (
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
        )
        walls: dict[str, tuple[Vector, Vector]] = {
            f"the wall {number}": (box[:3], box[3:])
            for number, box in enumerate(config.walls.boxes_m, start=1)
        }
        if walls:
            # As high as a wall is no arm goes, and a beam has room below.
            boxes = replace(_boxes(inverse(base), walls), passed_over=False)
            self._fixed = (*self._fixed, boxes)
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
            groups.append(self.parts(sorted(placed)))
        return joined(groups)

    def parts(self, cells: Sequence[Cell]) -> Obstacles:
        """Parts in these cells, one box each, in their order."""
        low = np.array(cells, dtype=np.float64) * self._pitch_m
        names = tuple(f"the part at [{c.x}, {c.y}, {c.z}]" for c in cells)
        return Obstacles(self._workspace_from_base, names, low, low + self._pitch_m)


def joined(groups: Iterable[Obstacles]) -> tuple[Obstacles, ...]:
    """The same boxes, those of one alignment in one group."""
    found: list[Obstacles] = []
    for group in groups:
        for i, other in enumerate(found):
            shift = other.frame_from_base @ inverse(group.frame_from_base)
            alike = other.passed_over is group.passed_over
            if alike and np.abs(shift[:3, :3] - np.eye(3)).max() < _ALIGNED:
                found[i] = Obstacles(
                    other.frame_from_base,
                    (*other.names, *group.names),
                    np.concatenate([other.low, group.low + shift[:3, 3]]),
                    np.concatenate([other.high, group.high + shift[:3, 3]]),
                    group.passed_over,
                )
                break
        else:
            found.append(group)
    return tuple(found)


def first_named(group: Obstacles, flags: Flags) -> str | None:
    """Name of the first flagged obstacle of a group, or None."""
    hits = np.flatnonzero(flags)
    return group.names[int(hits[0])] if hits.size else None


def _boxes(frame_from_base: Matrix, boxes: dict[str, tuple[Vector, Vector]]) -> Obstacles:
    corners = list(boxes.values())
    return Obstacles(
        frame_from_base,
        tuple(boxes),
        np.array([low for low, _ in corners]),
        np.array([high for _, high in corners]),
    )
