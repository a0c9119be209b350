"""Whether the gripper reaches a cell from above without touching what stands."""

from __future__ import annotations

import math
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import Protocol

from cellctl.assembly import Cell, TakeOff
from cellctl.config import CellConfig

ARM_WIDTH_M = 0.24
"""Edge of the square that flange and wrist of the arm need above the gripper, seen from above: the
wrists of a UR10e reach 12 cm sideways of the flange's axis."""


class Access(Protocol):
    """Says what bars the way to a cell."""

    def blockers(self, cell: Cell, standing: AbstractSet[Cell]) -> tuple[Cell, ...]:
        """The parts that bar it, sorted; none where it is free."""

    def frees(self, cell: Cell, way: TakeOff, standing: AbstractSet[Cell]) -> bool:
        """Whether there is room to take a part off that way; ``standing`` includes it."""


@dataclass(frozen=True, slots=True)
class Gripper:
    """What comes down with a part, in metres; see ``[tool]`` in cell.toml."""

    width_m: float
    """Edge of the square that the gripper's body needs, seen from above."""
    height_m: float
    """From the part's top face up to the flange."""
    pitch_m: float
    """Edge of a cell."""

    @classmethod
    def of(cls, config: CellConfig) -> Gripper:
        """As the cell is configured."""
        return cls(config.tool.width_m, config.tool.height_m, config.voxel.pitch_m)

    def blockers(self, cell: Cell, standing: AbstractSet[Cell]) -> tuple[Cell, ...]:
        """The parts that something would meet on its way straight down to a cell, sorted.

        Those in its column that are as high or higher meet the part itself. Those beside it that
        are higher meet the gripper where it is wider than a cell, and those that are higher than
        the gripper meet the arm. Coming down, the gripper passes all heights above the cell.
        """
        reach = max(_cells_reached(self.width_m, self.pitch_m), self._arm_reach)
        found = []
        for one in standing:
            aside = max(abs(one.x - cell.x), abs(one.y - cell.y))
            if aside <= reach and one.z >= cell.z and self._meets(aside, one.z - cell.z):
                found.append(one)
        return tuple(sorted(found))

    def frees(self, *_: object) -> bool:
        """Every way: what turns with a part keeps to the room above it, but for a few degrees."""
        return True

    @property
    def _arm_reach(self) -> int:
        return _cells_reached(ARM_WIDTH_M, self.pitch_m)

    def _meets(self, aside: int, higher: int) -> bool:
        """Whether a part so many cells aside and higher is met."""
        if aside == 0:
            return True
        if higher >= 1 and aside <= _cells_reached(self.width_m, self.pitch_m):
            return True
        over_gripper = higher * self.pitch_m > self.height_m + 1e-9
        return over_gripper and aside <= self._arm_reach


def _cells_reached(width_m: float, pitch_m: float) -> int:
    """How many cells to each side a square of that width reaches into, centred on a cell."""
    return max(0, math.ceil((width_m - pitch_m) / (2 * pitch_m) - 1e-9))
