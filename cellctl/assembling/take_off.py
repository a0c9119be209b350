"""Routes that take a part off what it is joined to: the beginning parts it, the rest lifts it.

A pull goes straight up. A peel turns part and gripper about a level axis first, and a twist about
the vertical; then the part goes up as it is, and upright again once it is off its seat. Around it,
neighbours may touch, so the way is looked at closely, pose by pose, instead of by the hull of each
leg.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Iterable, Iterator, Sequence

import numpy as np

from cellctl.assembling.arm import Waypoint
from cellctl.assembling.course import leg_length_m
from cellctl.assembling.frames import Frames
from cellctl.assembling.obstacles import Body, Obstacles, first_named
from cellctl.assembling.poses import Matrix, distance, interpolate, inverse, to_matrix, to_pose
from cellctl.assembling.route_check import Route, RouteChecker, Scene, Stance
from cellctl.assembly import Cell, TakeOff
from cellctl.config import CellConfig, Pose, Vector
from cellctl.errors import PlanError

PARTING_SPEED_M_S = 0.03
"""Of the TCP while joints part."""
_PEEL_RAD = tuple(math.radians(degrees) for degrees in (0.75, 2.0, 4.0, 6.0))
"""Where a peel passes: the arm goes straight from pose to pose, and the first step is so short that
its chord is as good as the arc. 6 degrees open a joint by a tenth of its edge."""
_TWIST_RAD = math.radians(12.0)
_SAMPLE_M = 0.005
"""Spacing of the poses that are looked at."""
_TURN_WAY_M = 0.15
"""A radian of turning moves no corner of part and gripper farther than about this."""
_NEAR_M = 0.02
_SLICE_M = 0.03
"""What leans is looked at in slices this high, for a whole box around it would be far too wide."""
_BLEND_SHARE = 0.4
_NEAR_SEAT_M = 0.008
_THERE_M = 0.0002
_UPRIGHT_RAD = math.radians(0.2)


class TakeOffRoutes:
    """Plans and checks how parts come off. Pure: it moves nothing and asks nothing.

    Args:
        config: the cell.
        frames: its frames.
        checker: its checks.
    """

    def __init__(self, config: CellConfig, frames: Frames, checker: RouteChecker) -> None:
        self._frames = frames
        self._checker = checker
        self._robot = robot = config.robot
        # A part is in the gripper on all of these ways, or was a moment ago.
        self._speed_m_s = min(robot.travel_speed_m_s, robot.carrying_speed_m_s)
        self._parting_m_s = min(PARTING_SPEED_M_S, self._speed_m_s)
        self._acceleration_m_s2 = min(
            robot.travel_acceleration_m_s2, robot.carrying_acceleration_m_s2
        )
        self._pitch_m = config.voxel.pitch_m
        self._base_from_workspace = frames.base_from_cell @ frames.cell_from_workspace

    def take_off(self, cell: Cell, way: TakeOff, others: Collection[Cell], start: Stance) -> Route:
        """Part and lift; see ``RoutePlanner.take_off``; ``others`` stand, without the part."""
        gripped = self._frames.place_tcp(cell)
        turned = [self._turned(gripped, cell, way, angle) for angle in _angles(way)]
        parted = turned[-1] if turned else gripped
        off_m = self._frames.height_m(parted) + self._robot.approach_height_m
        above_m = self._frames.height_m(gripped) + self._pitch_m + self._robot.clearance_m
        lifted = self._frames.raised(parted, off_m)
        above = self._frames.raised(gripped, above_m)
        slow, fast = self._parting_m_s, self._speed_m_s
        return self._checked(
            start,
            [*((pose, slow) for pose in turned), (lifted, slow), (above, fast)],
            self._checker.scene(others, carrying=True),
        )

    def back(self, cell: Cell, others: Collection[Cell], start: Stance) -> Route:
        """Straight back to where a part is gripped; see ``RoutePlanner.back_to_grip``."""
        gripped = self._frames.place_tcp(cell)
        scene = self._checker.scene(others, carrying=True)
        return self._checked(start, [(gripped, self._parting_m_s)], scene)

    def near_seat(
        self,
        cell: Cell,
        above_m: float,
        placed: Collection[Cell],
        start: Stance,
        *,
        carrying: bool,
    ) -> Route:
        """A fraction of a millimetre up or down; see ``RoutePlanner.near_seat``."""
        seat = self._frames.place_tcp(cell)
        goal = self._frames.raised(seat, self._frames.height_m(seat) + above_m)
        off_m = math.dist(to_pose(goal)[:3], start.tcp_pose[:3])
        if off_m > _NEAR_SEAT_M:
            raise PlanError("The arm is not at the part's seat.")
        if off_m < _THERE_M:
            height_m = self._frames.height_m(goal)
            return Route(path=(), duration_s=0.0, crossing_height_m=height_m, end=start)
        scene = self._checker.scene(placed, carrying=carrying)
        return self._checked(start, [(goal, self._parting_m_s)], scene)

    def upright(self, start: Stance, placed: Collection[Cell]) -> Route:
        """Up and upright; see ``RoutePlanner.upright``."""
        here = to_matrix(start.tcp_pose)
        level = self._level(here)
        if distance(to_pose(level), start.tcp_pose)[1] < _UPRIGHT_RAD:
            height_m = self._frames.height_m(here)
            return Route(path=(), duration_s=0.0, crossing_height_m=height_m, end=start)
        top_m = max((cell.z + 1 for cell in placed), default=0) * self._pitch_m
        top_m += float(self._frames.cell_from_workspace[2, 3])
        # Tilted as far as a peel tilts, its lowest corner hangs a little lower.
        clear_m = top_m + 1.1 * self._pitch_m + self._robot.clearance_m
        clear_m = max(clear_m, self._frames.height_m(here))
        up = [(self._frames.raised(pose, clear_m), self._parting_m_s) for pose in (here, level)]
        return self._checked(start, up, self._checker.scene(placed, carrying=True))

    def _turned(self, gripped: Matrix, cell: Cell, way: TakeOff, angle_rad: float) -> Matrix:
        """TCP pose in the base frame after the part has turned by an angle."""
        centre = (np.array(cell) + 0.5) * self._pitch_m
        up = np.array([0.0, 0.0, 1.0])
        hinge, axis = centre, up
        if way.direction is not None and way.hinge_m is not None:
            ahead = np.array([*way.direction, 0.0]) / math.hypot(*way.direction)
            hinge = centre + way.hinge_m[0] * ahead + way.hinge_m[1] * up
            axis = np.cross(up, ahead)
        about = _about(_vector(hinge), _vector(axis * angle_rad))
        in_base = self._base_from_workspace @ about @ inverse(self._base_from_workspace)
        turned: Matrix = in_base @ gripped
        return turned

    def _level(self, tcp: Matrix) -> Matrix:
        """The same TCP turned the least way until it points straight down."""
        in_cell = self._frames.cell_from_base @ tcp
        pointing, down = in_cell[:3, 2], np.array([0.0, 0.0, -1.0])
        axis = np.cross(pointing, down)
        sine = float(np.linalg.norm(axis))
        if sine > 1e-12:
            angle_rad = math.atan2(sine, float(pointing @ down))
            turn = to_matrix((0.0, 0.0, 0.0, *_vector(axis / sine * angle_rad)))
            in_cell[:3, :3] = turn[:3, :3] @ in_cell[:3, :3]
        level: Matrix = self._frames.base_from_cell @ in_cell
        return level

    def _checked(self, start: Stance, way: Sequence[tuple[Matrix, float]], scene: Scene) -> Route:
        """A path through these poses at these speeds.

        Raises:
            PlanError: it leaves the arm's reach or configuration, or touches something.
        """
        poses = [to_pose(pose) for pose, _ in way]
        legs = self._checker.legs(start, poses)
        self._look(start.tcp_pose, poses, scene)
        lengths_m = [
            math.dist(a[:3], b[:3]) for a, b in zip([start.tcp_pose, *poses], poses, strict=False)
        ]
        path = tuple(
            Waypoint(
                pose=pose,
                speed_m_s=min(speed_m_s, leg.limit_m_s),
                acceleration_m_s2=self._acceleration_m_s2,
                blend_radius_m=round(_BLEND_SHARE * min(lengths_m[i : i + 2]), 6)
                if i + 1 < len(poses) and speed_m_s == way[i + 1][1]
                else 0.0,
            )
            for i, (pose, (_, speed_m_s), leg) in enumerate(zip(poses, way, legs, strict=True))
        )
        self._checker.check_links(np.concatenate([leg.samples for leg in legs]), scene)
        return Route(
            path=path,
            duration_s=self._checker.line_duration_s(start, path),
            crossing_height_m=self._frames.height_m(way[-1][0]),
            end=Stance(poses[-1], legs[-1].joints_rad),
        )

    def _look(self, start: Pose, poses: Iterable[Pose], scene: Scene) -> None:
        """Raises PlanError where something is touched on the way."""
        bodies = [piece for body in scene.bodies for piece in _slices(body)]
        obstacles = _near(scene, [to_matrix(pose) for pose in (start, *poses)])
        samples: list[Matrix] = []
        before = start
        for pose in poses:
            _, turn_rad = distance(before, pose)
            way_m = max(leg_length_m(before, pose), _TURN_WAY_M * turn_rad)
            steps = max(1, math.ceil(way_m / _SAMPLE_M))
            a, b = to_matrix(before), to_matrix(pose)
            samples += [interpolate(a, b, i / steps) for i in range(steps + 1)]
            before = pose
        at = np.array(samples)
        for group in obstacles:
            for body in bodies:
                name = first_named(group, np.logical_or.reduce(group.touched_at(body, at)))
                if name is not None:
                    raise PlanError(f"The part that is taken off would touch {name}.")


def _angles(way: TakeOff) -> tuple[float, ...]:
    """How far the part is turned, pose by pose, before it is lifted."""
    if way.how == "peel":
        return _PEEL_RAD
    return (_TWIST_RAD,) if way.how == "twist" else ()


def _near(scene: Scene, poses: Sequence[Matrix]) -> list[Obstacles]:
    """What may be touched between these poses: all that is within their hull, and some around."""
    found = []
    for group in scene.obstacles:
        flags = np.zeros(len(group.names), dtype=np.bool_)
        for before, after in itertools.pairwise(poses):
            for body in scene.bodies:
                both = np.array([before, after])
                margin = np.array([_NEAR_M])
                flags |= group.touched(body, both[:, :3, 3], both[:, :3, :3], margin)[0]
        if flags.any():
            names = tuple(name for name, near in zip(group.names, flags, strict=True) if near)
            low, high = group.low[flags], group.high[flags]
            found.append(Obstacles(group.frame_from_base, names, low, high))
    return found


def _slices(body: Body) -> Iterator[Body]:
    (x, y, low_m), (to_x, to_y, high_m) = body.low, body.high
    count = math.ceil((high_m - low_m) / _SLICE_M)
    for i in range(count):
        begin_m, end_m = (low_m + (high_m - low_m) * k / count for k in (i, i + 1))
        yield Body((x, y, begin_m), (to_x, to_y, end_m))


def _about(point_m: Vector, turn_rad: Vector) -> Matrix:
    """The transform that turns about an axis through a point."""
    there = to_matrix((*point_m, 0.0, 0.0, 0.0))
    turn: Matrix = there @ to_matrix((0.0, 0.0, 0.0, *turn_rad)) @ inverse(there)
    return turn


def _vector(values: Matrix) -> Vector:
    x, y, z = (float(value) for value in values)
    return (x, y, z)
