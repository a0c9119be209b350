"""The corners of a route: straight up, across, straight down; slow where parts touch."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from cellctl.assembling.arm import JointWaypoint, Path, Waypoint
from cellctl.assembling.frames import Frames
from cellctl.assembling.poses import Floats, Matrix, distance, to_pose
from cellctl.assembling.rounded import turn_rad
from cellctl.assembly import Cell
from cellctl.config import CellConfig

_SAME_PLACE_M = 0.002
_SAME_TURN_RAD = 0.01
_SLOW_BLEND_M = 0.001
_SLOW_TURN_BLEND_M = 0.002
"""Beside a slow stretch: straight on, and where it is come to on a slope."""
_THROUGH_BLEND_M = 0.006
_CORNER_SHARE = 0.7
"""Of a piece of a way up or down that ends at the way across: so much of it is for the curve."""
_LEAST_REST = 0.3
"""What is left of a way up or down beside that piece is one of its own if it is longer than this
share of it."""
_BLEND_SHARE = 0.9
_SHARED_BLEND_SHARE = 0.45
"""Largest share of a leg that one blend may use, so that two never overlap: of a leg that it has
for itself but for a short blend, and of one that it shares."""
_HIGHER = 3
"""Where no low way is free, so many higher ones are tried, a part's height apart."""
_LEAVING_SHARE = 0.5
"""Of the slow stretch on which parts come to touch: so much is slow where they part. A gripper that
is felt to be free touches nothing any more."""
_UPRIGHT_M = 0.045
"""Joints that go straight over this length of a way up or down leave the line by 0.6 mm at most."""
_LEAST_FAST_M = 0.008
"""What is left of a way up or down beyond its slow stretch is faster only if it is this long."""


class Shape(NamedTuple):
    """What a route looks like."""

    first_m: float
    """Height of the TCP above the floor at which the way across begins."""
    last_m: float
    """Height at which it ends."""
    blend_m: float
    between: tuple[Matrix, ...] = ()
    """TCP poses at which the way across changes its slope."""
    upright: bool = True
    """The ways up and down are cut so short that the joints going straight keep to the line."""


class Corner(NamedTuple):
    """Where a leg ends, and whether the leg that leads there is slow."""

    tcp: Matrix
    slow: bool
    through: bool = False
    """It only cuts a way up or down, which goes straight on."""
    across: bool = False
    """It is a corner of the way across, far from anything else: it may be rounder."""


class Shaper:
    """Draws routes of one cell.

    Args:
        config: the cell.
        frames: its frames.
    """

    def __init__(self, config: CellConfig, frames: Frames) -> None:
        self._robot = config.robot
        self._frames = frames
        self._pitch_m = config.voxel.pitch_m
        self._square = config.robot.path == "square"
        # As high as a part that hangs from the gripper must be to pass over whatever may stand.
        tops_m = (
            frames.height_m(frames.place_tcp(Cell(0, 0, config.grid[2] - 1))),
            frames.height_m(frames.pick_tcp()),
        )
        self._plane_m = max(tops_m) + self._pitch_m + config.robot.clearance_m

    def only_shape(self, here: Matrix, there: Matrix) -> Shape | None:
        """The only shape of a way that needs no crossing; None where it needs one.

        A way straight up or down has none; one by the policy ``square`` crosses in its plane.
        """
        if stacked(here, there):
            height_m = max(self._frames.height_m(here), self._frames.height_m(there))
            return Shape(height_m, height_m, 0.0)
        return Shape(self._plane_m, self._plane_m, 0.0) if self._square else None

    def shapes(self, levels: Iterable[Shape], *, carrying: bool) -> Iterator[Shape]:
        """Shapes worth trying, the quick ones first.

        Args:
            levels: ways across, their blends still to be chosen; each is asked for when it is due.
            carrying: a part moves with the gripper.
        """
        # A curve may cut off the clearance that a corner has. Wider ones would ask for a higher
        # way, and were not found to be quicker. What a part that is carried stands beside leaves
        # it no room for joints that go straight all the way up or down.
        blend_m = min(self._robot.blend_radius_m, self._robot.clearance_m)
        known = []
        for level in levels:
            known.append(level)
            yield level._replace(blend_m=blend_m, upright=carrying)
        spare_m = self._robot.clearance_m - self._robot.margin_m
        blend_m = max(0.0, min(self._robot.blend_radius_m, spare_m))
        for level in known:
            yield level._replace(blend_m=blend_m)
        heights = [self._frames.height_m(tcp) for tcp in known[-1].between]
        highest_m = max(known[-1].first_m, known[-1].last_m, *heights)
        for up in range(_HIGHER + 1):
            level_m = highest_m + up * self._pitch_m
            yield Shape(level_m, level_m, blend_m)
        yield known[-1]._replace(blend_m=0.0)

    def corners(self, here: Matrix, there: Matrix, shape: Shape, *, carrying: bool) -> list[Corner]:
        """Corners of a path of this shape, without its start; none where there is no way to go."""
        slow_m = 0.0 if self._square else self._robot.approach_height_m
        free = not carrying and self._robot.touch_depth_m > 0.0
        leaving_m = 0.0 if free else _LEAVING_SHARE * slow_m
        found: list[Corner] = []
        if not stacked(here, there):
            found += self._climb(here, shape.first_m, leaving_m, shape)
            found += [Corner(tcp, slow=False, across=True) for tcp in shape.between]
            found.append(Corner(self._frames.raised(there, shape.last_m), slow=False))
            here = found[-1].tcp
        fall_m = self._frames.height_m(here) - self._frames.height_m(there)
        if fall_m < 0.0:
            return found + self._climb(here, self._frames.height_m(there), leaving_m, shape)
        if fall_m > slow_m + _LEAST_FAST_M > _LEAST_FAST_M:
            near_m = self._frames.height_m(there) + slow_m
            cuts = self._cuts(fall_m - slow_m, shape)
            found += self._upright(here, near_m, [1.0 - cut for cut in reversed(cuts[:-1])] + [1.0])
        if fall_m > _SAME_PLACE_M / 2:
            found.append(Corner(there, slow=not self._square))
        return found

    def path(
        self, start: Matrix, corners: Sequence[Corner], shape: Shape, *, carrying: bool
    ) -> Path:
        """The same corners as the arm is told them, rounded; joint speeds are still to be found."""
        radii_m = self._radii_m(start, corners, shape)
        if self._square:
            return tuple(
                Waypoint(
                    pose=to_pose(corner.tcp),
                    speed_m_s=speed_m_s,
                    acceleration_m_s2=rate_m_s2,
                    blend_radius_m=radius_m,
                )
                for corner, radius_m, (speed_m_s, rate_m_s2) in zip(
                    corners, radii_m, self.tcp_limits(corners, carrying=carrying), strict=True
                )
            )
        return tuple(
            JointWaypoint(
                pose=to_pose(corner.tcp),
                speed_rad_s=1.0,
                acceleration_rad_s2=1.0,
                blend_radius_m=radius_m,
            )
            for corner, radius_m in zip(corners, radii_m, strict=True)
        )

    def tcp_limits(self, corners: Sequence[Corner], *, carrying: bool) -> list[tuple[float, float]]:
        """Greatest speed (m/s) and acceleration (m/s2) of the TCP on each leg. What holds with a
        part in the gripper holds of an empty one too where it comes to touch a part."""
        robot = self._robot
        free = (robot.travel_speed_m_s, robot.travel_acceleration_m_s2)
        careful = (
            min(free[0], robot.carrying_speed_m_s),
            min(free[1], robot.carrying_acceleration_m_s2),
        )
        slow = (
            min(careful[0], robot.approach_speed_m_s),
            min(careful[1], robot.approach_acceleration_m_s2),
        )
        fast = careful if carrying else free
        limits = [slow if corner.slow else fast for corner in corners]
        if self._square and limits:
            limits[-1] = careful  # it has no slow stretch of its own
        return limits

    def _climb(self, here: Matrix, height_m: float, slow_m: float, shape: Shape) -> list[Corner]:
        """Straight up: slowly off whatever is touched, then fast."""
        begun_m = self._frames.height_m(here)
        rise_m = height_m - begun_m
        if not self._square and rise_m > slow_m + _LEAST_FAST_M:
            clear = self._frames.raised(here, begun_m + slow_m)
            cuts = self._cuts(rise_m - slow_m, shape)
            slow = [Corner(clear, slow=True)] if slow_m > 0.0 else []
            return [*slow, *self._upright(clear, height_m, cuts)]
        if rise_m > _SAME_PLACE_M / 2:
            return [Corner(self._frames.raised(here, height_m), slow=slow_m > 0.0)]
        return []

    def _cuts(self, length_m: float, shape: Shape) -> list[float]:
        """Where a way up is cut, as shares of it, the last one 1. A piece of its own at the corner
        to the way across leaves the rest of it to its own speed."""
        if self._square:
            return [1.0]
        corner_m = shape.blend_m / _CORNER_SHARE
        rest_m = length_m - corner_m
        if rest_m < _LEAST_REST * corner_m or corner_m <= 0.0:
            corner_m, rest_m = 0.0, length_m
        steps = max(1, math.ceil(rest_m / _UPRIGHT_M)) if shape.upright else 1
        cuts = [(i + 1) / steps * rest_m / length_m for i in range(steps)]
        return [*cuts, 1.0] if corner_m > 0.0 else cuts

    def _upright(self, here: Matrix, height_m: float, cuts: Sequence[float]) -> list[Corner]:
        """Straight up or down, in pieces."""
        begun_m = self._frames.height_m(here)
        way_m = height_m - begun_m
        tcps = [self._frames.raised(here, begun_m + way_m * cut) for cut in cuts]
        return [Corner(tcp, slow=False, through=i + 1 < len(tcps)) for i, tcp in enumerate(tcps)]

    def _round_m(self, arriving: Floats, leaving: Floats) -> float:
        """How round a corner of the way across may be: its curve cuts off what the clearance leaves
        beyond the margin, and no more."""
        turn = turn_rad(-arriving, np.zeros(3), leaving)
        spare_m = max(0.0, self._robot.clearance_m - self._robot.margin_m)
        return min(self._robot.blend_radius_m, spare_m / max(math.tan(turn / 4.0), 1e-6))

    def _radii_m(self, start: Matrix, corners: Sequence[Corner], shape: Shape) -> list[float]:
        """Radii of the corners, none so wide that it meets the next."""
        radii = [0.0] * len(corners)
        if self._square:
            return radii
        poses = [start, *(corner.tcp for corner in corners)]
        ways = [b[:3, 3] - a[:3, 3] for a, b in itertools.pairwise(poses)]
        lengths_m = [math.sqrt(float(way @ way)) for way in ways]
        # A blend is as slow as the slower of its legs, so it is kept short beside a slow one; but a
        # sharp turn would be slower still.
        small = [
            (_SLOW_BLEND_M if stacked(one.tcp, before) else _SLOW_TURN_BLEND_M)
            if one.slow or other.slow
            else _THROUGH_BLEND_M
            if one.through
            else 0.0
            for before, (one, other) in zip(poses, itertools.pairwise(corners), strict=False)
        ]
        for i in range(len(corners) - 1):
            first, last = i == 0, i + 2 == len(corners)
            room_m = min(
                _room_m(lengths_m[i], 0.0 if first else small[i - 1], shared=not first),
                _room_m(lengths_m[i + 1], 0.0 if last else small[i + 1], shared=not last),
            )
            wanted_m = small[i] or shape.blend_m
            if corners[i].across and shape.blend_m > 0.0:
                wanted_m = self._round_m(ways[i], ways[i + 1])
            radii[i] = round(min(wanted_m, room_m), 6)
        return radii


def _room_m(length_m: float, other_m: float, *, shared: bool) -> float:
    """For a blend on a leg.

    Args:
        length_m: of the leg.
        other_m: the short blend at its other end; 0 for none, or one that is not short.
        shared: there is one.
    """
    if shared and other_m == 0.0:
        return _SHARED_BLEND_SHARE * length_m
    return max(0.0, _BLEND_SHARE * length_m - other_m)


def stacked(here: Matrix, there: Matrix) -> bool:
    """Whether one pose is straight above the other."""
    if aside_m(here, there) >= _SAME_PLACE_M:
        return False
    _, turned_rad = distance(to_pose(here), to_pose(there))
    return turned_rad < _SAME_TURN_RAD


def aside_m(here: Matrix, there: Matrix) -> float:
    """How far one pose is from straight above the other."""
    return math.hypot(here[0, 3] - there[0, 3], here[1, 3] - there[1, 3])
