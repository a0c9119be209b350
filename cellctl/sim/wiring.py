"""What hangs on the robot: the tool that moves with the flange, and wires to the gripper."""

from __future__ import annotations

from cellctl.config import GripperSection
from cellctl.sim.latch import Latch
from cellctl.sim.plant import Floats
from cellctl.sim.world import World


class CellPlant:
    """The ``Plant`` that the emulated robot controller meets.

    Args:
        world: takes the arm's movements.
        latch: is wired to the lines that ``gripper`` names.
    """

    def __init__(self, world: World, latch: Latch, gripper: GripperSection) -> None:
        self._world = world
        self._latch = latch
        self._gripper = gripper

    def robot_moved(self, flange: Floats, joints_rad: Floats, dt_s: float) -> None:
        self._world.robot_moved(flange, joints_rad, dt_s)

    def outputs_changed(self, bits: int) -> None:
        self._latch.command(bool(bits >> self._gripper.command_output & 1))

    def inputs(self) -> int:
        return int(self._latch.status) << self._gripper.status_input
