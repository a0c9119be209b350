"""The magnetic joints of a structure: where two parts, or a part and the floor, share a face."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Cell

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

FLOOR = -1
"""Stands for the floor where a joint names the number of its lower part."""


class Joint(NamedTuple):
    """Two faces that touch."""

    a: Cell
    b: Cell
    """The neighbour of ``a`` on its lower side along one axis; z is -1 where that is the floor."""

    def describe(self) -> str:
        """Where it is, in words."""
        if self.b.z < 0:
            return f"between {list(self.a)} and the floor"
        return f"between {list(self.a)} and {list(self.b)}"


class Joints(NamedTuple):
    """All joints of a structure, by the numbers of its parts; each array has a row a joint."""

    upper: Ints
    """The part on the higher side along the axis, (m,)."""
    lower: Ints
    """The part on the lower side, or ``FLOOR``, (m,)."""
    axis: Ints
    """0 for x, 1 for y, 2 for z, (m,)."""

    @classmethod
    def among(cls, cells: Ints) -> Joints:
        """Of the cells (n, 3); their rows are their numbers."""
        # A grid with one empty layer around it, so that every neighbour has a place.
        low = cells.min(axis=0) - 1
        size = cells.max(axis=0) - low + 2
        number = np.full(size, FLOOR - 1, dtype=np.int64)
        place = cells - low
        number[tuple(place.T)] = np.arange(len(cells))
        uppers, lowers, axes = [], [], []
        for axis in range(3):
            step = np.zeros(3, dtype=np.int64)
            step[axis] = 1
            beneath = number[tuple((place - step).T)]
            if axis == 2:
                beneath = np.where(cells[:, 2] == 0, FLOOR, beneath)
            upper = np.flatnonzero(beneath >= FLOOR)
            uppers.append(upper)
            lowers.append(beneath[upper])
            axes.append(np.full(len(upper), axis, dtype=np.int64))
        return cls(np.concatenate(uppers), np.concatenate(lowers), np.concatenate(axes))

    def named(self, number: int, cells: Ints) -> Joint:
        """One of them, by its cells."""
        a = Cell(*cells[self.upper[number]].tolist())
        step = [0, 0, 0]
        step[int(self.axis[number])] = 1
        return Joint(a, Cell(a.x - step[0], a.y - step[1], a.z - step[2]))
