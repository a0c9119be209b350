"""The paper's square path at a speed and an acceleration that are told, for trials of them.

A route of a build is as quick as the configuration and the arm's joints allow, which is not what a
trial asks: there every leg is told the pace under trial, as the paper told its arm. Acceleration is
what is tried, so the one that the configuration assumes of the joints does not count; their
greatest speeds, which the makers publish, do.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np

from cellctl.assembling.arm import Waypoint
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import as_joints
from cellctl.assembling.limits import Use
from cellctl.assembling.poses import Floats, Matrix, to_matrix, to_pose
from cellctl.assembling.route_check import Route, RouteChecker, Scene, Stance
from cellctl.assembling.timing import Timing
from cellctl.assembly import Pace
from cellctl.config import CellConfig
from cellctl.errors import PlanError

_SAME_PLACE_M = 0.002


class ToldRoutes:
    """Finds such routes of one cell. Pure: it moves nothing and asks nothing.

    Args:
        config: the cell.
        frames: its frames.
        checker: its checks.
    """

    def __init__(self, config: CellConfig, frames: Frames, checker: RouteChecker) -> None:
        self._frames = frames
        self._checker = checker
        self._over_m = config.voxel.pitch_m + config.robot.clearance_m

    def find(
        self, start: Stance, goal: Stance, scene: Scene, pace: Pace, *, top_m: float, sink_m: float
    ) -> Route:
        """With a part up to one plane, across and down, with a rest at every corner.

        Args:
            start: where the arm is.
            goal: where it goes.
            scene: what moves, and what is in the way.
            pace: what every leg is told. A leg on which a joint would turn too fast is told less
                speed, but for the last one, which brings the part down: that is never lowered.
            top_m: height above the floor of the highest thing that is passed over.
            sink_m: how far below its seat the goal is.

        Raises:
            PlanError: something is in the way, the arm does not reach, or its joints do not bear
                that pace on the way down.
        """
        here, there = to_matrix(start.tcp_pose), to_matrix(goal.tcp_pose)
        corners = self._corners(here, there, top_m + self._over_m)
        course = self._checker.course(start, _path(corners, [pace] * len(corners)))
        self._checker.check_room(course, scene, sink_m=sink_m)
        use = Use(course)
        rate = pace.acceleration_m_s2

        def timed(speeds: Sequence[float]) -> Timing:
            legs = len(corners)
            return Timing(course.pieces, course.blend_acceleration, tuple(speeds), (rate,) * legs)

        speeds = [pace.speed_m_s] * len(corners)
        shares = self._shares(use, timed(speeds))
        borne = 1.0 / np.maximum(np.abs(use.turning) / self._checker.limits.speed_rad_s, 1e-9)
        for leg, part in enumerate(course.slices):
            if shares[part].max() <= 1.0:
                continue
            if leg + 1 == len(corners):
                raise PlanError(
                    f"At {pace} the way down is too fast for the arm's joints: they bear "
                    f"{1.0 / float(shares[part].max()):.0%} of the speed that it reaches there.",
                    "Build it elsewhere, away from the arm's base, or leave that pace out.",
                )
            speeds[leg] = min(speeds[leg], float(borne[part].min()))
        heights = course.points @ self._frames.cell_from_base[2, :3]
        return Route(
            path=_path(
                corners, [Pace(speed_m_s=speed, acceleration_m_s2=rate) for speed in speeds]
            ),
            duration_s=timed(speeds).duration_s,
            crossing_height_m=float(heights.max() + self._frames.cell_from_base[2, 3]),
            end=Stance(to_pose(there), as_joints(course.joints_rad[-1])),
        )

    def _shares(self, use: Use, timing: Timing) -> Floats:
        """Which share of its greatest speed the fastest joint turns with, at each sample."""
        turned = np.abs(use.joint_speeds_rad_s(timing))
        shares: Floats = (turned / self._checker.limits.speed_rad_s).max(axis=1)
        return shares

    def _corners(self, here: Matrix, there: Matrix, plane_m: float) -> list[Matrix]:
        """The ends of the legs: straight above the start, straight above the goal, and the goal."""
        plane_m = max(plane_m, self._frames.height_m(here))
        poses = [self._frames.raised(pose, plane_m) for pose in (here, there)]
        found: list[Matrix] = []
        for before, pose in itertools.pairwise([here, *poses]):
            if np.linalg.norm(pose[:3, 3] - before[:3, 3]) > _SAME_PLACE_M:
                found.append(pose)
        return [*found, there]


def _path(corners: Sequence[Matrix], paces: Sequence[Pace]) -> tuple[Waypoint, ...]:
    return tuple(
        Waypoint(
            pose=to_pose(corner),
            speed_m_s=pace.speed_m_s,
            acceleration_m_s2=pace.acceleration_m_s2,
        )
        for corner, pace in zip(corners, paces, strict=True)
    )
