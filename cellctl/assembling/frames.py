"""Where things are for the robot: the configuration's frames, met in the robot's base frame.

The TCP is the centre of the top face of a gripped voxel, its z axis into the voxel. Gripping and
placing therefore mean the same TCP pose: the centre of the part's top face, z straight down. The
TCP's x axis follows the x axis of what it works on, the workspace or the feeder.
"""

from __future__ import annotations

import math

import numpy as np

from cellctl.assembling.poses import Matrix, inverse, to_matrix
from cellctl.assembly import Cell
from cellctl.config import CellConfig

_TOOL_DOWN = to_matrix((0.0, 0.0, 0.0, math.pi, 0.0, 0.0))


class Frames:
    """The cell's frames as 4x4 matrices.

    Args:
        config: the cell.
    """

    def __init__(self, config: CellConfig) -> None:
        self._pitch_m = config.voxel.pitch_m
        self.cell_from_base: Matrix = to_matrix(config.base.frame)
        self.cell_from_workspace: Matrix = to_matrix(config.workspace.frame)
        self.cell_from_feeder: Matrix = to_matrix(config.feeder.frame)
        self.cell_from_pedestal: Matrix = to_matrix(config.pedestal.frame)
        self.flange_from_tcp: Matrix = to_matrix(config.tool.frame)
        self.base_from_cell: Matrix = inverse(self.cell_from_base)
        self.tcp_from_flange = inverse(self.flange_from_tcp)

    def place_tcp(self, cell: Cell) -> Matrix:
        """TCP pose in the base frame for a part in, or about to be put into, a workspace cell."""
        pitch_m = self._pitch_m
        top = np.eye(4)
        top[:3, 3] = ((cell.x + 0.5) * pitch_m, (cell.y + 0.5) * pitch_m, (cell.z + 1) * pitch_m)
        return self.base_from_cell @ self.cell_from_workspace @ top @ _TOOL_DOWN

    def pick_tcp(self) -> Matrix:
        """TCP pose in the base frame for the part at the pick station."""
        return self.base_from_cell @ self.cell_from_feeder @ _TOOL_DOWN

    def raised(self, tcp: Matrix, height_m: float) -> Matrix:
        """The same TCP pose with its z in the cell frame at a height above the floor."""
        in_cell = self.cell_from_base @ tcp
        in_cell[2, 3] = height_m
        return self.base_from_cell @ in_cell

    def height_m(self, tcp: Matrix) -> float:
        """Height of a TCP pose of the base frame above the floor."""
        return float((self.cell_from_base @ tcp)[2, 3])

    def flange(self, tcp: Matrix) -> Matrix:
        """Flange pose for a TCP pose, both in the base frame."""
        return tcp @ self.tcp_from_flange

    def tcp(self, flange: Matrix) -> Matrix:
        """TCP pose for a flange pose, both in the base frame."""
        return flange @ self.flange_from_tcp
