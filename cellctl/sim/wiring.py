"""What hangs on the robot: the tool that moves with the flange, and wires to the gripper."""

from __future__ import annotations

from typing import Protocol

from cellctl.config import GripperSection
from cellctl.sim.plant import Floats
from cellctl.sim.world import World


class WiredLatch(Protocol):
    """The gripper, as two wires."""

    deaf_s: float
    """A level of the command line that lasts less than this it does not hear of at all."""

    @property
    def status(self) -> bool:
        """Level of the status line."""
        ...

    def command(self, high: bool) -> None:
        """Level of the command line: high asks for an open latch."""


class CellPlant:
    """The ``Plant`` that the emulated robot controller meets.

    Args:
        world: takes the arm's movements.
        latch: is wired to the lines that ``gripper`` names.
    """

    def __init__(self, world: World, latch: WiredLatch, gripper: GripperSection) -> None:
        self._world = world
        self._latch = latch
        self._gripper = gripper
        self._commanded = False
        """What the controller puts on the command line."""
        self._glitch_s = 0.0
        """How long the line still has the opposite level."""

    def advance(self, dt_s: float) -> None:
        """Let cell time pass."""
        if self._glitch_s > 0.0:
            # Half a microsecond less: sums of time steps fall short of their target by rounding.
            self._glitch_s -= dt_s
            if self._glitch_s < 5e-7:
                self._glitch_s = 0.0
                self._tell()

    def glitch(self, duration_s: float) -> None:
        """Give the command line the opposite level for a while (cell time)."""
        if duration_s >= self._latch.deaf_s:
            self._glitch_s = duration_s
            self._tell()

    def robot_moved(self, flange: Floats, joints_rad: Floats, dt_s: float) -> None:
        self._world.robot_moved(flange, joints_rad, dt_s)

    def commanded(self, speed_m_s: float, acceleration_m_s2: float) -> None:
        self._world.commanded(speed_m_s, acceleration_m_s2)

    def tcp_force_n(self) -> Floats:
        return self._world.tcp_force_n()

    def outputs_changed(self, bits: int) -> None:
        self._commanded = bool(bits >> self._gripper.command_output & 1)
        self._tell()

    def inputs(self) -> int:
        return int(self._latch.status) << self._gripper.status_input

    def _tell(self) -> None:
        self._latch.command(self._commanded != (self._glitch_s > 0.0))
