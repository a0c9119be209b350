"""What the emulated robot controller and the physical world know of each other."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


class Plant(Protocol):
    """The physical cell, as the robot's controller meets it: metal that moves, and wires."""

    def robot_moved(self, flange: Floats, joints_rad: Floats, dt_s: float) -> None:
        """The arm has moved for ``dt_s`` of cell time (at most 8 ms).

        Args:
            flange: 4x4 pose of the flange in the robot's base frame.
            joints_rad: the six joint positions.
        """
        ...

    def commanded(self, speed_m_s: float, acceleration_m_s2: float) -> None:
        """What the robot's program asks of the movement that is under way, whether it gets as fast
        or not; a movement of the joints counts as if the arm were 1 m long."""
        ...

    def tcp_force_n(self) -> Floats:
        """What acts on the tool from outside, (3,) in the base frame, in N."""
        ...

    def outputs_changed(self, bits: int) -> None:
        """The controller's digital outputs: bits 0-7 standard, 8-15 configurable, 16-17 tool."""
        ...

    def inputs(self) -> int:
        """Levels on the controller's digital inputs, same bits."""
        ...
