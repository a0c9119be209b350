"""Builds carried out in process: the emulated controller's motion, followed by the judging world.

No sockets and no clocks: the path of every route goes to the emulator's own planner as the client
would send it, its joints are advanced step by step, and the world sees each step.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from cellctl.assembling.arm import JointWaypoint, Path
from cellctl.assembling.route import Route, RoutePlanner, Stance
from cellctl.assembly import Cell, Step
from cellctl.config import CellConfig
from cellctl.sim.ur.arm import Arm
from cellctl.sim.ur.kinematics import inverse_matrix, pose_matrix
from cellctl.sim.ur.options import Six, UrOptions
from cellctl.sim.ur.trajectory import Waypoint
from cellctl.sim.world import World
from cellctl.sim.world_values import Violation

STEP_S = 0.008


@dataclass
class Executed:
    """What a build came to."""

    duration_s: float = 0.0
    predicted_s: float = 0.0
    fastest: float = 0.0
    """Largest share of its greatest speed that a joint had."""
    hardest: float = 0.0
    """Largest share of its greatest acceleration; of the median over neighbouring steps, for where
    a trapezoid begins the difference of two steps is none."""
    tcp_m_s: float = 0.0
    violations: list[Violation] = field(default_factory=list)


class Bench:
    """One arm and one world.

    Args:
        config: the cell.
    """

    def __init__(self, config: CellConfig) -> None:
        self.config = config
        self.routes = RoutePlanner(config)
        options = UrOptions(
            model=config.robot.model,
            initial_joints_rad=config.robot.home_rad,
            tcp_speed_limit_m_s=3.0,
        )
        self.options = options
        self.arm = Arm(options)
        self.arm.set_tcp(config.tool.frame)
        self.world = World(config)
        self.seen = Executed()
        self.step_s = STEP_S
        self.building_s = 0.0
        """From the first fetch to the last part."""
        self.parts_s: list[float] = []
        """Of each part, its two movements."""
        self.rising_s = 0.0
        """Of that, how long it took to rise a little from the parts that were let go."""
        self.trace: list[list[float]] = []
        """Joint positions after each step."""
        self._show(0.0)

    def stance(self) -> Stance:
        """Where the arm is."""
        return Stance(self.arm.tcp_pose, self.arm.joints_rad)

    def follow(self, route: Route) -> float:
        """Carry out a route; returns how long it took.

        Raises:
            MotionError: the emulated controller would stop.
        """
        if not route.path:
            return 0.0
        motion = self.arm.planner.plan(self.arm.joints_rad, self.arm.tcp, self._moves(route.path))
        self.arm.start(motion)
        joints, took_s = [self.arm.joints_rad], 0.0
        while self.arm.busy:
            if (commanded := self.arm.commanded) is not None:
                self.world.commanded(*commanded)
            self.arm.advance(STEP_S)
            self._show(STEP_S)
            self.seen.tcp_m_s = max(self.seen.tcp_m_s, self.arm.tcp_speed_m_s)
            joints.append(self.arm.joints_rad)
            self.trace.append(list(self.arm.joints_rad))
            took_s += STEP_S
        self._measure(np.array(joints))
        self.seen.duration_s += took_s
        self.seen.predicted_s += route.duration_s
        self.seen.violations = list(self.world.violations)
        return took_s

    def build(self, order: Iterable[Cell]) -> Executed:
        """Place parts in an order, from home and back, and say what it came to."""
        placed: list[Cell] = []
        for cell in order:
            self.world.belt_move(2.0 * self.config.voxel.pitch_m)
            fetching_s = self.follow(self.routes.to_pick(self.stance(), placed))
            self.world.latch_closed()
            bringing_s = self.follow(self.routes.to_seat(cell, self.stance(), placed))
            self.parts_s.append(fetching_s + bringing_s)
            self.world.latch_opened()
            self.rising_s += self._rise(cell, placed)
            placed.append(cell)
        self.building_s = self.seen.duration_s
        up = self.routes.retreat(self.stance(), placed, carrying=False)
        self.follow(up)
        self.follow(self.routes.to_home(self.stance(), placed, carrying=False))
        return self.seen

    def take_apart(self, steps: Iterable[Step], standing: Iterable[Cell]) -> Executed:
        """Bring parts back to the belt, from where the arm is, and say what it came to."""
        now = set(standing)
        self.seen = Executed()
        for step in steps:
            assert step.take_off is not None, "it takes parts away"
            self.world.belt_move(-self.config.voxel.pitch_m)
            self.follow(self.routes.to_grip(step.cell, now, self.stance()))
            self.world.latch_closed()
            self.follow(self.routes.take_off(step.cell, step.take_off, now, self.stance()))
            now.discard(step.cell)
            self.follow(self.routes.to_station(now, self.stance()))
            self.world.latch_opened()
        return self.seen

    def _rise(self, cell: Cell, placed: list[Cell]) -> float:
        depth_m = self.config.robot.touch_depth_m
        near = self.routes.near_seat(cell, depth_m, placed, self.stance(), carrying=False)
        return self.follow(near)

    def _moves(self, path: Path) -> list[Waypoint]:
        """The path as the client's script has it, poses made joints as the controller does."""
        near: Six = self.arm.joints_rad
        moves = []
        for number, point in enumerate(path):
            kind: Literal["joint", "line"] = "line"
            target: Six = point.pose
            if isinstance(point, JointWaypoint):
                speed, rate, kind = point.speed_rad_s, point.acceleration_rad_s2, "joint"
                found = self.arm.kinematics.joints(_flange(self.arm, point.pose), near)
                assert found is not None, "a checked route is within reach"
                target = near = found
            else:
                speed, rate = point.speed_m_s, point.acceleration_m_s2
            moves.append(Waypoint(kind, target, speed, rate, point.blend_radius_m, number))
        return moves

    def _show(self, dt_s: float) -> None:
        self.world.robot_moved(self.arm.flange, self.arm.joints_array, dt_s)

    def _measure(self, joints: np.ndarray) -> None:
        robot = self.config.robot
        speeds = np.diff(joints, axis=0) / STEP_S
        share = np.abs(speeds) / np.array(self.options.joint_speed_limit_rad_s)
        self.seen.fastest = max(self.seen.fastest, float(share.max(initial=0.0)))
        rates = np.abs(np.diff(speeds, axis=0)) / STEP_S
        if len(rates) >= 3:
            windows = np.array([rates[i : i + len(rates) - 2] for i in range(3)])
            middle = np.median(windows, axis=0) / robot.joint_acceleration_rad_s2
            self.seen.hardest = max(self.seen.hardest, float(middle.max()))


def _flange(arm: Arm, pose: Six) -> np.ndarray:
    return pose_matrix(pose) @ inverse_matrix(arm.tcp)


def slab(nx: int, ny: int, layers: int) -> list[Cell]:
    """Full layers, from the corner nearest to the origin."""
    return [Cell(x, y, z) for z, x, y in itertools.product(range(layers), range(nx), range(ny))]
