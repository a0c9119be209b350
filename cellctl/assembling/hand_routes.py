"""Routes for an operator's hand: slow single steps, straight up, and home from wherever the arm is.

Somebody who leads the arm by hand leaves it anywhere: in another configuration, tilted, or closer
to something than a planned route would go. These routes begin there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator

from cellctl.assembling.arm import Waypoint
from cellctl.assembling.course import leg_length_m
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import Kinematics
from cellctl.assembling.poses import Matrix, to_matrix, to_pose
from cellctl.assembling.route_check import Route, RouteChecker, Scene, Stance
from cellctl.assembling.withdrawal import WithdrawalCheck
from cellctl.assembly import Cell
from cellctl.config import CellConfig, Joints, Pose, Vector
from cellctl.errors import PlanError

HAND_SPEED_M_S = 0.05
HAND_ACCELERATION_M_S2 = 0.2
HAND_JOINT_SPEED_RAD_S = 0.2
"""At full reach the TCP is then as fast as 0.26 m/s, what people are let near robots with."""
JOG_M = 0.1
"""Longest step."""
JOG_RAD = math.radians(30.0)
"""Widest turn of a step."""

_STEP_DOWN_M = 0.02
"""Spacing of the heights that are tried where the arm does not reach the one that is wanted."""
_SAME_HEIGHT_M = 0.001
_SAME_JOINTS_RAD = 0.02
_JOINT_ACCELERATION_RAD_S2 = 1.0


class HandRoutes:
    """Plans and checks movements that begin anywhere. Pure: it moves nothing and asks nothing.

    Args:
        config: the cell.
        frames: its frames.
        kinematics: its arm.
        checker: its checks.
    """

    def __init__(
        self, config: CellConfig, frames: Frames, kinematics: Kinematics, checker: RouteChecker
    ) -> None:
        self._frames = frames
        self._kinematics = kinematics
        self._checker = checker
        self._clearance_m = config.robot.clearance_m
        self._withdrawal = WithdrawalCheck(
            frames, kinematics, config.robot.clearance_m, config.robot.margin_m
        )
        self._pitch_m = config.voxel.pitch_m

    def jog(self, start: Stance, scene: Scene, delta_m: Vector, turn_rad: float) -> Route:
        """One step; see ``RoutePlanner.jog``."""
        _refuse_no_step(delta_m, turn_rad)
        in_cell = self._frames.cell_from_base @ to_matrix(start.tcp_pose)
        in_cell[:3, :3] = to_matrix((0.0, 0.0, 0.0, 0.0, 0.0, turn_rad))[:3, :3] @ in_cell[:3, :3]
        in_cell[:3, 3] += delta_m
        return self._slow(start, self._frames.base_from_cell @ in_cell, scene)

    def rise(self, start: Stance, scene: Scene, placed: Collection[Cell]) -> Route:
        """Straight up; see ``RoutePlanner.rise``."""
        here = to_matrix(start.tcp_pose)
        begun_m = self._frames.height_m(here)
        wanted_m = self._clear_height_m(scene, placed)
        if wanted_m - begun_m < _SAME_HEIGHT_M:
            return self._nowhere(start)
        refused: PlanError | None = None
        for height_m in _downward(wanted_m, begun_m):
            try:
                return self._slow(start, self._frames.raised(here, height_m), scene)
            except PlanError as error:
                refused = refused or error
        assert refused is not None, "at least one height was tried"
        raise refused

    def home(
        self,
        start: Stance,
        home: Stance,
        scene: Scene,
        placed: Collection[Cell],
        planned: Callable[[Stance], Route],
    ) -> Route:
        """To ``home`` by the first way that every check lets pass: as planned; straight up and
        then as planned; straight up and then by turning the joints; by turning them at once.

        Args:
            start: where the arm is.
            home: where it goes.
            scene: what moves and what is in the way.
            placed: what stands.
            planned: plans the whole path from a stance.

        Raises:
            PlanError: none does. The message is that of the planned path.
        """

        def risen() -> Route:
            return self.rise(start, scene, placed)

        def risen_and_planned() -> Route:
            first = risen()
            return _joined(first, planned(first.end))

        refused: PlanError | None = None
        ways: tuple[Callable[[], Route], ...] = (
            lambda: planned(start),
            risen_and_planned,
            risen,
            lambda: self._nowhere(start),
        )
        for way in ways:
            try:
                return self._turned(way(), home.joints_rad, scene)
            except PlanError as error:
                refused = refused or error
        assert refused is not None, "some way was tried"
        raise PlanError(
            refused.message,
            "No other way home is open either: jog the arm clear, or lead it by hand.",
        )

    def _turned(self, route: Route, home_rad: Joints, scene: Scene) -> Route:
        """The same route, with the joints turned at its end where they are not at home yet."""
        far_rad = max(abs(a - b) for a, b in zip(route.end.joints_rad, home_rad, strict=True))
        if far_rad < _SAME_JOINTS_RAD:
            return route
        largest_rad = self._checker.check_joint_move(route.end, home_rad, scene)
        tcp = self._frames.tcp(self._kinematics.forward(home_rad))
        turning_s = largest_rad / HAND_JOINT_SPEED_RAD_S
        turning_s += HAND_JOINT_SPEED_RAD_S / _JOINT_ACCELERATION_RAD_S2
        return route.model_copy(
            update={
                "joints": home_rad,
                "joint_speed_rad_s": HAND_JOINT_SPEED_RAD_S,
                "duration_s": route.duration_s + turning_s,
                "end": Stance(to_pose(tcp), home_rad),
            }
        )

    def _slow(self, start: Stance, goal: Matrix, scene: Scene) -> Route:
        """One straight leg at hand speed, that leads away from whatever is too close."""
        pose = to_pose(goal)
        leg = self._checker.legs(start, [pose])[0]
        self._withdrawal.check(start.tcp_pose, pose, leg.samples, scene)
        waypoint = Waypoint(
            pose=pose,
            speed_m_s=min(HAND_SPEED_M_S, leg.limit_m_s),
            acceleration_m_s2=HAND_ACCELERATION_M_S2,
        )
        return Route(
            path=(waypoint,),
            duration_s=_rest_to_rest_s(start.tcp_pose, waypoint),
            crossing_height_m=self._frames.height_m(goal),
            end=Stance(pose, leg.joints_rad),
        )

    def _nowhere(self, start: Stance) -> Route:
        height_m = self._frames.height_m(to_matrix(start.tcp_pose))
        return Route(path=(), duration_s=0.0, crossing_height_m=height_m, end=start)

    def _clear_height_m(self, scene: Scene, placed: Collection[Cell]) -> float:
        """Height of the TCP at which everything hangs clear of parts, standing or waiting."""
        top_m = max((cell.z + 1 for cell in placed), default=0) * self._pitch_m
        top_m += float(self._frames.cell_from_workspace[2, 3])
        top_m = max(top_m, float(self._frames.cell_from_feeder[2, 3]))
        hanging_m = max(body.high[2] for body in scene.bodies)
        return top_m + self._clearance_m + hanging_m


def _rest_to_rest_s(start: Pose, waypoint: Waypoint) -> float:
    length_m, a = leg_length_m(start, waypoint.pose), waypoint.acceleration_m_s2
    peak_m_s = min(waypoint.speed_m_s, math.sqrt(a * length_m))
    return length_m / peak_m_s + peak_m_s / a if peak_m_s > 0.0 else 0.0


def _refuse_no_step(delta_m: Vector, turn_rad: float) -> None:
    """Raises PlanError unless this is one short step along or about one axis."""
    if not all(map(math.isfinite, (*delta_m, turn_rad))):
        raise PlanError("A jog's numbers must be finite.")
    along = [value for value in delta_m if value != 0.0]
    if len(along) + (turn_rad != 0.0) != 1:
        raise PlanError(
            "A jog goes along one axis of the cell, or turns about the vertical, one at a time."
        )
    if along and abs(along[0]) > JOG_M + 1e-9:
        raise PlanError(f"A jog is {JOG_M:g} m at most, not {abs(along[0]):g} m.")
    if abs(turn_rad) > JOG_RAD + 1e-9:
        raise PlanError(
            f"A jog turns by {math.degrees(JOG_RAD):.0f} degrees at most, "
            f"not {math.degrees(abs(turn_rad)):.0f}."
        )


def _downward(highest_m: float, lowest_m: float) -> Iterator[float]:
    """Heights to try, the highest first, down to a step above the lowest; at least one."""
    count = max(1, math.ceil((highest_m - lowest_m) / _STEP_DOWN_M))
    for i in range(count):
        yield highest_m - i * _STEP_DOWN_M


def _joined(first: Route, second: Route) -> Route:
    """One route after the other, with a stop between."""
    return second.model_copy(
        update={
            "path": (*first.path, *second.path),
            "duration_s": first.duration_s + second.duration_s,
        }
    )
