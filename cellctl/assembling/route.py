"""Routes: paths of the arm that keep clear of everything, checked before anything moves.

Nothing moves but along a route that this module made or checked. A route goes straight up from
where the gripper is, crosses at the lowest heights that keep ``robot.clearance_m`` from everything
below, and goes straight down, its corners rounded; it is slow where parts touch. An empty gripper
leaves and comes on a slope where nothing near is higher. All of it is checked along its whole
length: reach, one arm configuration, joint speed and acceleration, and what
the arm, the gripper and its part sweep.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection

from cellctl.assembling.arm import Path
from cellctl.assembling.frames import Frames
from cellctl.assembling.hand_routes import HandRoutes
from cellctl.assembling.kinematics import Kinematics, same_configuration
from cellctl.assembling.latch_gripper import STEADY_S
from cellctl.assembling.poses import Matrix, to_matrix, to_pose
from cellctl.assembling.route_check import Route, RouteChecker, Scene, Stance
from cellctl.assembling.route_finder import RouteFinder
from cellctl.assembling.take_off import TakeOffRoutes
from cellctl.assembling.told_route import ToldRoutes
from cellctl.assembly import Cell, Pace, TakeOff, Value
from cellctl.config import CellConfig, Joints, Pose, Vector
from cellctl.errors import PlanError

__all__ = ["Route", "RoutePlanner", "Stance", "StepRoute"]


SETTING_OUT_S = 0.05
"""Between an act of the gripper and a movement: what was done is written down, the gate of the path
opens, and its end is seen; measured in the emulated cell at its own speed."""


OPEN_TOLD_S = 0.02
"""Until the gripper's board, which is asked now and then, has told that the latch is open."""
SEATING_S = 0.04
"""To feel the seat; measured in the emulated cell at its own speed, as is the next."""
FREEING_S = 0.15
"""To rise by a fraction of a millimetre and feel, with the next way made ready beside it."""

_RISING = 3
"""In so many steps it is looked at how a part rises off its neighbours."""


class StepRoute(Value):
    """What the placement of one part takes."""

    clearance_m: float
    """Height of the TCP above the floor at which the part crosses."""
    duration_s: float
    """Both movements, and what the arm stands meanwhile."""


class RoutePlanner:
    """Plans and checks every movement of one cell. Pure: it moves nothing and asks nothing.

    Args:
        config: the cell.
    """

    def __init__(self, config: CellConfig) -> None:
        self._robot = config.robot
        self._pitch_m = config.voxel.pitch_m
        self._grid = config.grid
        self._workspace = [Cell(*at) for at in itertools.product(*map(range, config.grid))]
        self._frames = Frames(config)
        self._kinematics = Kinematics(config.robot.model)
        self._checker = RouteChecker(config, self._frames, self._kinematics)
        home_rad = config.robot.home_rad
        self.home = Stance(self._tcp_of(home_rad), home_rad)
        self._finder = RouteFinder(config, self._frames, self._checker)
        lines = config.gripper
        self.closing_s = SETTING_OUT_S + lines.latch_s
        """What a movement to a part costs beside its way: being set out for, and the latch, which
        is proven while the part rises."""
        self.gripping_s = self.closing_s + STEADY_S
        """The same of a part that stands: the latch is proven before it is parted from others."""
        # Its board tells when the latch is open, which takes it as long as closing.
        told_s = lines.release_s if lines.port is None else lines.latch_s + OPEN_TOLD_S
        self.opening_s = SETTING_OUT_S + max(min(lines.release_s, told_s), STEADY_S)
        """The same of a movement with a part to where it is let go."""
        self._depth_m = config.robot.touch_depth_m
        self._hand = HandRoutes(config, self._frames, self._kinematics, self._checker)
        self._taking = TakeOffRoutes(config, self._frames, self._checker)
        self._told = ToldRoutes(config, self._frames, self._checker)
        self._stances: dict[Cell | None, Stance] = {}
        """Of cells, and of the pick station by None: every step asks for them again."""

    def pick_stance(self) -> Stance:
        """Gripping the part at the pick station.

        Raises:
            PlanError: it is out of reach.
        """
        if None not in self._stances:
            self._stances[None] = self._stance(self._frames.pick_tcp(), "the pick station")
        return self._stances[None]

    def place_stance(self, cell: Cell) -> Stance:
        """Holding a part in a cell.

        Raises:
            PlanError: the cell is outside the workspace or out of reach.
        """
        if cell not in self._stances:
            if not all(0 <= index < count for index, count in zip(cell, self._grid, strict=True)):
                size = " x ".join(str(count) for count in self._grid)
                raise PlanError(f"{_name(cell)} is outside the workspace of {size} cells.")
            self._stances[cell] = self._stance(self._frames.place_tcp(cell), _name(cell))
        return self._stances[cell]

    def to_pick(self, start: Stance, placed: Collection[Cell]) -> Route:
        """With an open gripper from anywhere to the part at the pick station.

        Raises:
            PlanError: there is no such way.
        """
        scene = self._checker.scene(placed, carrying=False)
        return self._route(start, self.pick_stance(), scene)

    def to_cell(self, cell: Cell, placed: Collection[Cell], start: Stance | None = None) -> Route:
        """With a part in the gripper to its cell; from the pick station unless told otherwise.

        Args:
            cell: where the part goes.
            placed: what stands already.
            start: where the arm is.

        Raises:
            PlanError: there is no such way, for instance because the cell is covered.
        """
        if cell in placed:
            raise PlanError(f"{_name(cell)} is already occupied.")
        scene = self._checker.scene(placed, carrying=True)
        return self._route(start or self.pick_stance(), self.place_stance(cell), scene)

    def to_seat(
        self, cell: Cell, start: Stance, placed: Collection[Cell], pace: Pace | None = None
    ) -> Route:
        """The same from anywhere, pressed on what carries the part where that bears it: its end is
        ``robot.touch_depth_m`` below the seat.

        Args:
            cell: where the part goes.
            start: where the arm is.
            placed: what stands already.
            pace: what the movement is told, for a trial of it: it is on the square path then.

        Raises:
            PlanError: there is no such way, or the arm does not bear that pace.
        """
        if cell in placed:
            raise PlanError(f"{_name(cell)} is already occupied.")
        goal, sink_m = self.place_stance(cell), 0.0
        if self.presses(cell, placed):
            sink_m = self._depth_m
            tcp = to_matrix(goal.tcp_pose)
            below = self._frames.raised(tcp, self._frames.height_m(tcp) - sink_m)
            goal = self._stance(below, _name(cell), near=goal.joints_rad)
        scene = self._checker.scene(placed, carrying=True)
        if pace is None:
            return self._finder.find(start, goal, scene, sink_m=sink_m)
        return self._told.find(start, goal, scene, pace, top_m=self._top_m(placed), sink_m=sink_m)

    def _top_m(self, placed: Collection[Cell]) -> float:
        """Height above the floor of what stands, or waits on the belt."""
        top_m = self._frames.cell_from_workspace[2, 3] + self._pitch_m * max(
            (cell.z + 1 for cell in placed), default=0
        )
        return max(float(top_m), self._frames.height_m(self._frames.pick_tcp()))

    def presses(self, cell: Cell, placed: Collection[Cell]) -> bool:
        """Whether a part is pressed on what carries it: where a column down to the floor does, for
        no other joints bear being pressed on."""
        if self._depth_m == 0.0:
            return False
        return all(Cell(cell.x, cell.y, z) in placed for z in range(cell.z))

    def to_grip(self, cell: Cell, placed: Collection[Cell], start: Stance) -> Route:
        """With an open gripper from anywhere to a part that stands.

        Raises:
            PlanError: there is no such way, or no part stands there.
        """
        if cell not in placed:
            raise PlanError(f"No part stands at {_name(cell)}.")
        scene = self._checker.scene(placed, carrying=False)
        return self._route(start, self.place_stance(cell), scene)

    def take_off(
        self, cell: Cell, way: TakeOff, placed: Collection[Cell], start: Stance | None = None
    ) -> Route:
        """With the latch closed on a part that stands: part it from its neighbours as stated, and
        lift it clear of them, upright again.

        Args:
            cell: where the part stands.
            way: how it comes off.
            placed: what stands, the part included.
            start: where the arm is, near the part; gripping it unless told otherwise.

        Raises:
            PlanError: there is no room for it.
        """
        start = start or self.place_stance(cell)
        return self._taking.take_off(cell, way, frozenset(placed) - {cell}, start)

    def back_to_grip(self, cell: Cell, placed: Collection[Cell], start: Stance) -> Route:
        """With a part in the latch that is hardly off its place straight back to it.

        Raises:
            PlanError: there is no such way.
        """
        return self._taking.back(cell, frozenset(placed) - {cell}, start)

    def near_seat(
        self,
        cell: Cell,
        above_m: float,
        placed: Collection[Cell],
        start: Stance,
        *,
        carrying: bool,
    ) -> Route:
        """From a part's seat, or a millimetre off it, to a fraction of a millimetre above or below,
        slowly.

        Raises:
            PlanError: it is farther than that, or out of reach.
        """
        return self._taking.near_seat(cell, above_m, placed, start, carrying=carrying)

    def upright(self, start: Stance, placed: Collection[Cell]) -> Route:
        """With a tilted part in the gripper straight up, until nothing that stands is as high, and
        then upright; no movement where it is upright.

        Raises:
            PlanError: something is in the way, or it is out of reach.
        """
        return self._taking.upright(start, placed)

    def to_station(self, placed: Collection[Cell], start: Stance) -> Route:
        """With a part in the gripper to the pick station, where the belt has room for it.

        Raises:
            PlanError: there is no such way.
        """
        scene = self._checker.scene(placed, carrying=True)
        return self._route(start, self.pick_stance(), scene)

    def to_home(self, start: Stance, placed: Collection[Cell], *, carrying: bool) -> Route:
        """From anywhere to where the arm rests.

        Where no path leads there, because somebody moved the arm by hand into another
        configuration or too close to something, it goes straight up first, and turns the joints at
        the end: then ``Route.joints`` is set.

        Raises:
            PlanError: there is no such way; the message says what is in the way.
        """
        scene = self._checker.scene(placed, carrying=carrying)
        return self._hand.home(
            start, self.home, scene, placed, lambda begin: self._route(begin, self.home, scene)
        )

    def jog(
        self,
        start: Stance,
        placed: frozenset[Cell],
        delta_m: Vector,
        turn_rad: float,
        *,
        carrying: bool,
    ) -> Route:
        """One slow step by an operator's hand: straight along one axis of the cell frame, or a
        turn about the vertical through the TCP. It keeps the clearance to everything, or, where
        the arm is too close already, leads away.

        Args:
            start: where the arm is.
            placed: what stands.
            delta_m: at most ``hand_routes.JOG_M`` along one axis.
            turn_rad: at most ``hand_routes.JOG_RAD``, counter-clockwise seen from above.
            carrying: whether a part is in the gripper.

        Raises:
            PlanError: it is no such step, out of reach, or something is in the way.
        """
        scene = self._checker.scene(placed, carrying=carrying)
        return self._hand.jog(start, scene, delta_m, turn_rad)

    def rise(self, start: Stance, placed: frozenset[Cell], *, carrying: bool) -> Route:
        """Slowly straight up from anywhere, above everything that stands or waits on the belt, or
        as high as the arm reaches; no movement where it is as high already.

        Raises:
            PlanError: something is above it, or it is at the end of its reach.
        """
        scene = self._checker.scene(placed, carrying=carrying)
        return self._hand.rise(start, scene, placed)

    def to_above_station(self, start: Stance, placed: Collection[Cell], *, carrying: bool) -> Route:
        """To one pitch above where the part at the pick station is gripped, to look at it.

        Raises:
            PlanError: there is no such way.
        """
        goal = self._above(self._frames.pick_tcp(), "the place above the pick station")
        return self._route(start, goal, self._checker.scene(placed, carrying=carrying))

    def to_above_cell(
        self, cell: Cell, start: Stance, placed: Collection[Cell], *, carrying: bool
    ) -> Route:
        """To one pitch above where a part would be put into a cell, to look at it.

        Raises:
            PlanError: there is no such way, or no such cell.
        """
        self.place_stance(cell)
        goal = self._above(self._frames.place_tcp(cell), f"the place above {_name(cell)}")
        return self._route(start, goal, self._checker.scene(placed, carrying=carrying))

    def retreat(self, start: Stance, placed: Collection[Cell], *, carrying: bool) -> Route:
        """Straight up from anywhere, until nothing that stands is as high.

        Raises:
            PlanError: something is in the way, or it is out of reach.
        """
        top = max((cell.z + 1 for cell in placed), default=0) * self._pitch_m
        height_m = self._frames.cell_from_workspace[2, 3] + top + self._robot.clearance_m
        height_m += self._pitch_m if carrying else 0.0
        here = to_matrix(start.tcp_pose)
        height_m = max(float(height_m), self._frames.height_m(here))
        up = self._frames.raised(here, height_m)
        goal = self._stance(up, "the place above", near=start.joints_rad)
        return self._route(start, goal, self._checker.scene(placed, carrying=carrying))

    def step(
        self,
        cell: Cell,
        placed: Collection[Cell],
        previous: Cell | None = None,
        pace: Pace | None = None,
    ) -> StepRoute:
        """What one placement takes: from where the arm put the previous part (or home) to the pick
        station, and on to the cell.

        Args:
            cell: where the part goes.
            placed: what stands already.
            previous: the cell of the part before.
            pace: what the way with the part is told, for a trial of it.

        Raises:
            PlanError: there is no such way.
        """
        start = self.home if previous is None else self.freed(previous)
        fetch = self.to_pick(start, placed)
        bring = self.to_seat(cell, fetch.end, placed, pace)
        standing_s = self.closing_s + self.placing_s(cell, placed)
        if pace is not None:
            standing_s += self.finding_s(cell, placed)
        return StepRoute(
            clearance_m=bring.crossing_height_m,
            duration_s=fetch.duration_s + bring.duration_s + standing_s,
        )

    def freed(self, cell: Cell) -> Stance:
        """Where the gripper was felt to be free of a part that it let go.

        Raises:
            PlanError: as for ``place_stance``.
        """
        seat = self.place_stance(cell)
        tcp = to_matrix(seat.tcp_pose)
        free = self._frames.raised(tcp, self._frames.height_m(tcp) + self._depth_m)
        return self._stance(free, _name(cell), near=seat.joints_rad)

    def placing_s(self, cell: Cell, placed: Collection[Cell]) -> float:
        """What bringing a part to a cell costs beside its way: being set out for, the latch, and
        what is felt there."""
        freeing_s = FREEING_S if self._depth_m > 0.0 else 0.0
        return self.opening_s + freeing_s + (SEATING_S if self.presses(cell, placed) else 0.0)

    def finding_s(self, cell: Cell, placed: Collection[Cell]) -> float:
        """What it costs in a trial to find out whether a part stands on which nothing may press."""
        return 0.0 if self.presses(cell, placed) else self.gripping_s + self.opening_s

    def away_s(self, cell: Cell) -> float:
        """How far a cell is from the pick station: what the arm takes at least, were nothing in the
        way. Infinite where it does not reach."""
        try:
            there = self.place_stance(cell)
        except PlanError:
            return math.inf
        pick = self.pick_stance()
        way_m = math.dist(pick.tcp_pose[:3], there.tcp_pose[:3])
        turning_s = self._checker.limits.direct_s(pick.joints_rad, there.joints_rad)
        return max(turning_s, way_m / self._robot.travel_speed_m_s)

    def reachable(self, cell: Cell) -> bool:
        """Whether a part can be brought to a cell, with its approach, where nothing else stands."""
        try:
            self.to_cell(cell, ())
        except PlanError:
            return False
        return True

    def hindering(self, cell: Cell) -> frozenset[Cell]:
        """Cells of the workspace in which a part would come too close to the arm's links while it
        grips a part in a cell, or lifts it off its neighbours.

        Raises:
            PlanError: the arm does not reach that cell.
        """
        gripped = self.place_stance(cell)
        tcp = to_matrix(gripped.tcp_pose)
        rise_m = (self._pitch_m + self._robot.clearance_m) / _RISING
        rising = [
            self._frames.raised(tcp, self._frames.height_m(tcp) + step * rise_m)
            for step in range(1, _RISING + 1)
        ]
        others = [one for one in self._workspace if one != cell]
        return self._checker.near_links(self._checker.corners_rad(gripped, rising), others)

    def check(
        self,
        start: Stance,
        path: Path,
        placed: Collection[Cell],
        *,
        carrying: bool,
    ) -> Stance:
        """Check a path that somebody else made, such as an operator's command.

        Returns:
            Where it ends.

        Raises:
            PlanError: it leaves the arm's reach or configuration, is too fast for a joint, or
                touches something; the message says where.
        """
        return self._checker.check(start, path, self._checker.scene(placed, carrying=carrying))

    def check_joint_move(
        self, start: Stance, target_rad: Joints, placed: Collection[Cell], *, carrying: bool
    ) -> float:
        """Check a movement in joint space, in which all joints start and end together.

        Returns:
            The largest angle that a joint turns, in radians.

        Raises:
            PlanError: it touches something on the way.
        """
        scene = self._checker.scene(placed, carrying=carrying)
        return self._checker.check_joint_move(start, target_rad, scene)

    def _route(self, start: Stance, goal: Stance, scene: Scene) -> Route:
        return self._finder.find(start, goal, scene)

    def _stance(self, tcp: Matrix, what: str, near: Joints | None = None) -> Stance:
        """The stance of the home configuration at a TCP pose."""
        near = near or self.home.joints_rad
        joints_rad = self._kinematics.inverse(self._frames.flange(tcp), near)
        if joints_rad is None:
            raise PlanError(f"{what[0].upper()}{what[1:]} is out of the arm's reach.")
        if not same_configuration(joints_rad, near):
            raise PlanError(f"The arm would have to change its configuration to reach {what}.")
        return Stance(to_pose(tcp), joints_rad)

    def _above(self, tcp: Matrix, what: str) -> Stance:
        return self._stance(
            self._frames.raised(tcp, self._frames.height_m(tcp) + self._pitch_m), what
        )

    def _tcp_of(self, joints_rad: Joints) -> Pose:
        return to_pose(self._frames.tcp(self._kinematics.forward(joints_rad)))


def _name(cell: Cell) -> str:
    return f"cell [{cell.x}, {cell.y}, {cell.z}]"
