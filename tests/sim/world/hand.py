"""Moves the world's tool by hand: down a straight line in steps of a few millimetres."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numpy as np
import numpy.typing as npt

from cellctl.config import CellConfig, load_config
from cellctl.sim.latch import TRAVEL_S, Latch
from cellctl.sim.world import World
from cellctl.sim.world_geometry import inverse, pose_matrix, rotation
from cellctl.sim.world_values import ViolationKind

Floats = npt.NDArray[np.float64]
DOWN = np.diag([1.0, -1.0, -1.0])
JOINTS = np.zeros(6)
STEP_M = 0.004
PARTS = 60


def emulated_config() -> CellConfig:
    """The emulated cell as it is shipped, with ``PARTS`` parts."""
    config = load_config(Path(__file__).parents[3] / "config" / "sim.toml")
    feeder = config.feeder.model_copy(update={"capacity_parts": PARTS})
    limits = config.limits.model_copy(update={"inventory_parts": PARTS})
    return config.model_copy(update={"feeder": feeder, "limits": limits})


class Gripper(Protocol):
    """Whatever turns the latch."""

    def command(self, high: bool) -> None:
        """Level of the command line: high unlatches."""

    def advance(self, dt_s: float) -> None:
        """Let cell time pass."""


class Hand:
    """The arm of a test: it can be anywhere, and works the latch.

    Positions are the TCP's in the workspace frame, in metres; the tool points down.

    Args:
        world: where the parts are.
        gripper: what turns the latch; a plain one of the hand's own by default.
        travel_s: how long to wait for it.
    """

    def __init__(
        self, world: World, gripper: Gripper | None = None, travel_s: float = TRAVEL_S
    ) -> None:
        self.world = world
        self.latch = Latch(world)
        self._gripper = self.latch if gripper is None else gripper
        self._travel_s = travel_s
        self.pitch_m = world.config.voxel.pitch_m
        self._base = pose_matrix(world.config.base.frame)
        self._workspace = pose_matrix(world.config.workspace.frame)
        self._tool = pose_matrix(world.config.tool.frame)
        station = inverse(self._workspace) @ pose_matrix(world.config.feeder.frame)
        self.station_m = station[:3, 3]
        self.tcp = np.eye(4)
        self.jump((0.3, 0.25, 0.9))

    def jump(self, to_m: tuple[float, ...] | Floats, turn: Floats = DOWN) -> None:
        """Tell one new pose of the arm, however far away."""
        self.tcp[:3, :3] = turn
        self.tcp[:3, 3] = to_m
        flange = inverse(self._base) @ self._workspace @ self.tcp @ inverse(self._tool)
        self.world.robot_moved(flange, JOINTS, 0.002)

    def go(self, *to_m: float) -> None:
        """Move along a straight line; the tool keeps its orientation."""
        start = self.tcp[:3, 3].copy()
        way = np.array(to_m) - start
        steps = max(1, int(np.ceil(np.linalg.norm(way) / STEP_M)))
        turn = self.tcp[:3, :3].copy()
        for index in range(1, steps + 1):
            self.jump(start + way * index / steps, turn)
            self.world.advance(0.004)

    def turn(self, yaw_rad: float = 0.0, tilt_rad: float = 0.0) -> None:
        """Turn the tool where it is."""
        turn = rotation(np.array([0.0, 0.0, yaw_rad])) @ rotation(np.array([tilt_rad, 0.0, 0.0]))
        self.jump(self.tcp[:3, 3].copy(), turn @ DOWN)

    def open(self) -> None:
        """Unlatch, and wait for it."""
        self._gripper.command(True)
        self._gripper.advance(self._travel_s)

    def close(self) -> None:
        """Latch, and wait for it."""
        self._gripper.command(False)
        self._gripper.advance(self._travel_s)

    def over(self, x_m: float, y_m: float, height_m: float = 0.8) -> None:
        """Go up, across and down to a height, straight."""
        here = self.tcp[:3, 3]
        self.go(here[0], here[1], max(0.8, height_m))
        self.go(x_m, y_m, 0.8)
        self.go(x_m, y_m, height_m)

    def index_belt(self) -> None:
        """Turn the belt until a part lies at the pick station."""
        for _ in range(5000):
            if self.world.part_at_pick():
                return
            self.world.belt_move(0.002)
        raise AssertionError("no part came to the pick station")

    def pick(self) -> None:
        """Bring a part to the station, take it and lift it."""
        self.index_belt()
        self.open()
        x_m, y_m, z_m = self.station_m
        self.over(x_m, y_m, z_m)
        self.close()
        self.go(x_m, y_m, 0.8)

    def carry(self, *cell: int, off_m: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        """Take the held part to a cell, off by a little if told so."""
        x_m = (cell[0] + 0.5) * self.pitch_m + off_m[0]
        y_m = (cell[1] + 0.5) * self.pitch_m + off_m[1]
        self.over(x_m, y_m, (cell[2] + 1) * self.pitch_m + off_m[2])

    def place(self, *cell: int, off_m: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> None:
        """Pick a part, let it go at a cell and back off."""
        self.pick()
        self.carry(*cell, off_m=off_m)
        self.open()
        x_m, y_m, _ = self.tcp[:3, 3]
        self.go(x_m, y_m, 0.8)

    def kinds(self) -> list[ViolationKind]:
        """What the world holds against this hand, in order."""
        return [violation.kind for violation in self.world.violations]
