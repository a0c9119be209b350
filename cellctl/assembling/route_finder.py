"""Finds a quick route that keeps clear of everything, from where the arm is to where it goes.

Shapes of paths are tried in turn, the quick ones first. Each is checked along its whole length; the
first one that is clear is timed, as quick as the joints allow.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Sequence
from typing import cast

import numpy as np

from cellctl.assembling import crossing
from cellctl.assembling.arm import JointWaypoint, Path
from cellctl.assembling.course import Course
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import as_joints
from cellctl.assembling.limits import Use, leading_shares
from cellctl.assembling.obstacles import TOUCH_M
from cellctl.assembling.poses import Floats, Matrix, to_matrix
from cellctl.assembling.route_check import Route, RouteChecker, Scene, Stance
from cellctl.assembling.shaping import Corner, Shape, Shaper, aside_m
from cellctl.assembling.timing import Timing
from cellctl.config import CellConfig, Joints
from cellctl.errors import PlanError

_SAME_JOINTS_RAD = 0.5
_FLUSH_M = 0.0008
"""Joints that go straight all the way may overlap this much with what a part stands beside."""
_STRAIGHT_LIFT_M = 0.032
"""Lifted so far and no way aside, a part comes off one that sticks to it on the belt."""
_LEAVING_SLOPE = 0.5
_COMING_SLOPE = 0.35
"""How steeply an empty gripper leaves a part and comes to one where nothing near that is higher, so
that the base, which has the longest way, turns meanwhile."""
_CUT_M = 0.25
"""A way across that is longer than this is cut, so that each piece has a speed of its own: where
the TCP is far from the base it is as fast as it may be at fewer radians a second."""
_CUTS = (0.25, 0.5, 0.75)


class RouteFinder:
    """Finds routes of one cell. Pure: it moves nothing and asks nothing.

    Args:
        config: the cell.
        frames: its frames.
        checker: its checks.
    """

    def __init__(self, config: CellConfig, frames: Frames, checker: RouteChecker) -> None:
        self._clearance_m = config.robot.clearance_m
        self._slow_m = config.robot.approach_height_m
        self._leaves_free = config.robot.touch_depth_m > 0.0
        curve_m = min(config.robot.blend_radius_m, self._clearance_m)
        self._lift_m = _STRAIGHT_LIFT_M + curve_m
        self._pitch_m = config.voxel.pitch_m
        self._frames = frames
        self._checker = checker
        self._shaper = Shaper(config, frames)
        self._cuts = config.robot.path == "blended"

    def find(self, start: Stance, goal: Stance, scene: Scene, sink_m: float = 0.0) -> Route:
        """The first of the shapes that keeps clear of everything.

        Args:
            start: where the arm is.
            goal: where it goes.
            scene: what moves, and what is in the way.
            sink_m: how far below its seat the goal is.

        Raises:
            PlanError: none does; the message says what is in the way of the plainest one.
        """
        only = self._shaper.only_shape(to_matrix(start.tcp_pose), to_matrix(goal.tcp_pose))
        shapes = (
            iter([only])
            if only is not None
            else self._shaper.shapes(self._levels(start, goal, scene), carrying=scene.carrying)
        )
        refused: PlanError | None = None
        for shape in shapes:
            try:
                return self._shaped(start, goal, shape, scene, sink_m)
            except PlanError as error:
                refused = error  # the last one is the plainest
        assert refused is not None, "some shape was tried"
        raise refused

    def _shaped(
        self, start: Stance, goal: Stance, shape: Shape, scene: Scene, sink_m: float
    ) -> Route:
        """One shape of path, as quick as the joints allow.

        Raises:
            PlanError: the arm does not reach, would have to change its configuration, or something
                is in the way.
        """
        carrying = scene.carrying
        here, there = to_matrix(start.tcp_pose), to_matrix(goal.tcp_pose)
        corners = self._shaper.corners(here, there, shape, carrying=carrying)
        if not corners:
            height_m = self._frames.height_m(here)
            return Route(path=(), duration_s=0.0, crossing_height_m=height_m, end=start)
        if self._cuts:
            corners = self._cut(start, corners)
        path = self._shaper.path(here, corners, shape, carrying=carrying)
        course = self._checker.course(start, path)
        end_rad = as_joints(course.joints_rad[-1])
        if not _same_joints(end_rad, goal.joints_rad):
            raise PlanError("The arm would have to change its configuration on the way.")
        touch_m = TOUCH_M if shape.upright else _FLUSH_M
        self._checker.check_room(course, scene, touch_m, sink_m)
        limits = self._shaper.tcp_limits(corners, carrying=carrying)
        timing = Use(course).fitted(self._checker.limits, limits)
        heights = course.points @ self._frames.cell_from_base[2, :3]
        return Route(
            path=_paced(path, course, timing),
            duration_s=timing.duration_s,
            crossing_height_m=float(heights.max() + self._frames.cell_from_base[2, 3]),
            end=Stance(path[-1].pose, end_rad),
        )

    def _cut(self, start: Stance, corners: Sequence[Corner]) -> list[Corner]:
        """The same corners, with more of them where the joints go straight on a long way across."""
        found: list[Corner] = []
        here = to_matrix(start.tcp_pose)
        for corner in corners:
            if aside_m(here, corner.tcp) > _CUT_M:
                points, rotations = self._checker.tcp_between(start, here, corner.tcp)
                found += [
                    Corner(_pose(points, rotations, share), slow=False, through=True)
                    for share in _CUTS
                ]
            found.append(corner)
            here = corner.tcp
        return found

    def _levels(self, start: Stance, goal: Stance, scene: Scene) -> Iterator[Shape]:
        """Ways across, by their heights; the first ones lead away from what stands beside their
        beginning without passing over it, and an empty gripper leaves and comes on a slope."""
        here, there = to_matrix(start.tcp_pose), to_matrix(goal.tcp_pose)
        from_m, to_m = self._frames.height_m(here), self._frames.height_m(there)
        leaving_m = max(self._clearance_m, self._lift_m if scene.carrying else 0.0)
        points, rotations, level_m = self._across(start, here, there)
        heights = points @ self._frames.cell_from_base[2, :3] + self._frames.cell_from_base[2, 3]
        wanted = crossing.wishes(
            [group for group in scene.obstacles if group.passed_over],
            scene.bodies,
            points,
            rotations,
            clearance_m=self._clearance_m,
            cell_from_base=self._frames.cell_from_base,
        )
        bulge_m = heights - level_m

        def level(wanted_m: Floats, begin_m: float, end_m: float) -> Shape:
            (_, first_m), *between, (_, last_m) = crossing.profile(
                wanted_m, begin_m, end_m, bulge_m
            )
            tcps = [
                self._frames.raised(_pose(points, rotations, share), height_m)
                for share, height_m in between
            ]
            return Shape(first_m, last_m, 0.0, tuple(tcps))

        def sloped(wanted_m: Floats) -> Shape:
            for end, slope, seat_m, begin_m in (
                (0, _LEAVING_SLOPE, from_m, from_m),
                (-1, _COMING_SLOPE, to_m, to_m + self._slow_m),
            ):
                aside = np.linalg.norm((points - points[end])[:, :2], axis=1)
                wanted_m = crossing.sloped(
                    wanted_m, begin_m + slope * aside, seat_m + self._clearance_m + TOUCH_M
                )
            return level(wanted_m, from_m, to_m + self._slow_m)

        ways = [(wanted.strict_m, from_m)]
        if not np.array_equal(wanted.strict_m, wanted.leaving_m):
            ways.insert(0, (wanted.leaving_m, from_m + leaving_m))
        if not scene.carrying and self._leaves_free:
            yield from (sloped(wanted_m) for wanted_m, _ in ways)
        yield from (level(wanted_m, begin_m, to_m) for wanted_m, begin_m in ways)

    def _across(self, start: Stance, here: Matrix, there: Matrix) -> tuple[Floats, Floats, float]:
        """Where the TCP goes while the joints go straight across above both ends, and how high
        both ends are then: as high as the arm reaches at both, if need be.

        Raises:
            PlanError: it does not reach one of them at the other's height.
        """
        low_m, high_m = sorted(self._frames.height_m(pose) for pose in (here, there))

        def across(level_m: float) -> tuple[Floats, Floats, float]:
            ends = [self._frames.raised(pose, level_m) for pose in (here, there)]
            return *self._checker.tcp_between(start, *ends), level_m

        for level_m in (high_m + self._pitch_m, high_m, (low_m + high_m) / 2):
            with contextlib.suppress(PlanError):
                return across(level_m)
        return across(low_m)


def _pose(points: Floats, rotations: Floats, share: float) -> Matrix:
    """TCP pose at a share of evenly spaced samples: the next one's orientation, for they are
    close."""
    at = share * (len(points) - 1)
    before = min(int(at), len(points) - 2)
    pose = np.eye(4)
    pose[:3, :3] = rotations[round(at)]
    pose[:3, 3] = points[before] + (at - before) * (points[before + 1] - points[before])
    return pose


def _paced(path: Path, course: Course, timing: Timing) -> Path:
    """The same path with the speeds and accelerations of a timing."""
    paced = []
    for point, share, speed, rate in zip(
        path, leading_shares(course), timing.speeds, timing.accelerations, strict=True
    ):
        if isinstance(point, JointWaypoint):
            pace = {"speed_rad_s": speed * share, "acceleration_rad_s2": rate * share}
        else:
            pace = {"speed_m_s": speed, "acceleration_m_s2": rate}
        paced.append(point.model_copy(update=pace))
    return cast("Path", tuple(paced))


def _same_joints(a: Joints, b: Joints) -> bool:
    """Whether two joint positions are the same shape of the arm, on the same turns."""
    return max(abs(one - two) for one, two in zip(a, b, strict=True)) < _SAME_JOINTS_RAD
