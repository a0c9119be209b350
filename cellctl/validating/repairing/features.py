"""What people see in a set of cells: legs, a top, tiers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from cellctl.assembly import Cell
from cellctl.validating.repairing.score import Size
from cellctl.validating.rules import Cells, pieces

_PLATE = 0.6
"""A layer that fills this part of the object's footprint, or more, is a plate."""

_LEG = 0.5
"""A part of the lowest layer that is one cell, or less than this of the footprint's edge, wide and
deep is a leg; a longer one is a panel."""


@dataclass(frozen=True)
class Leg:
    """A place at which an object stands."""

    x: float
    """Its centre from 0 to 1 across the object's width."""
    y: float
    """Likewise across its depth."""
    area: int
    """In cells."""


@dataclass(frozen=True)
class Features:
    """An object from [0, 0, 0] as people see it."""

    cells: Cells
    size: Size

    def layer(self, z: int) -> Cells:
        """The cells of one layer."""
        return frozenset(cell for cell in self.cells if cell.z == z)

    @cached_property
    def plates(self) -> tuple[int, ...]:
        """The layers that cover most of the footprint, from below."""
        area = self.size[0] * self.size[1]
        return tuple(z for z in range(self.size[2]) if len(self.layer(z)) >= _PLATE * area)

    @cached_property
    def legs(self) -> tuple[Leg, ...]:
        """What it stands on, from left to right; none if that is broad, or there is no more."""
        found = pieces(self.layer(0))
        if self.size[2] == 1 or not all(map(self._slender, found)):
            return ()
        return tuple(sorted(map(self._leg, found), key=lambda leg: (leg.x, leg.y)))

    def _slender(self, piece: Cells) -> bool:
        for axis in range(2):
            spread = max(cell[axis] for cell in piece) - min(cell[axis] for cell in piece) + 1
            if spread > max(1.0, _LEG * self.size[axis]):
                return False
        return True

    def _leg(self, piece: Cells) -> Leg:
        return Leg(
            sum(cell.x + 0.5 for cell in piece) / len(piece) / self.size[0],
            sum(cell.y + 0.5 for cell in piece) / len(piece) / self.size[1],
            len(piece),
        )

    @cached_property
    def top(self) -> tuple[int, int]:
        """How wide and how deep the highest layer is."""
        highest = self.layer(self.size[2] - 1)
        width = max(c.x for c in highest) - min(c.x for c in highest) + 1
        depth = max(c.y for c in highest) - min(c.y for c in highest) + 1
        return (width, depth)

    def place(self, cell: Cell) -> str:
        """Where a cell is: ``the top``, ``a tier``, ``the legs``, ``the back`` and the like."""
        if cell.z == self.size[2] - 1:
            return "the top"
        if cell.z in self.plates:
            return "the base" if cell.z == 0 else "a tier"
        if self.legs and (not self.plates or cell.z < self.plates[0]):
            return "the legs"
        if self.plates and cell.z > self.plates[-1]:
            return "what stands on its highest tier"
        return "its sides"
