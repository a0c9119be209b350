"""A known equilibrium of a structure, which proves how little its joints need to pull.

By the lower-bound theorem any distribution of forces that balances the loads is a proof: the
structure needs at most the pull that the most strained joint of that distribution needs. The
distribution is kept from state to state, and changed only where something changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np

from cellctl.assembly import Cell
from cellctl.validating.stability.joints import Floats, Ints, Joint, Joints
from cellctl.validating.stability.physics import Physics
from cellctl.validating.stability.programme import Programme, Solution
from cellctl.validating.stability.springs import spread
from cellctl.validating.stability.strength import needed_pull

_STEPS = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


class Witness:
    """Cells and what each of their joints bears at rest."""

    def __init__(self, physics: Physics) -> None:
        self.physics = physics
        self.cells: set[Cell] = set()
        self.number: dict[tuple[Cell, int], int] = {}
        """Rows of the joints, by the upper cell and the axis."""
        self._axis = np.zeros(64, dtype=np.int64)
        self._bare = np.zeros(64, dtype=np.bool_)
        self._wrench = np.zeros((64, 6))
        self._need = np.zeros(64)

    def copy(self) -> Self:
        """An independent one."""
        other = type(self)(self.physics)
        other.cells = set(self.cells)
        other.number = dict(self.number)
        other._axis, other._bare = self._axis.copy(), self._bare.copy()
        other._wrench, other._need = self._wrench.copy(), self._need.copy()
        return other

    @property
    def need(self) -> float:
        """The pull that the most strained joint needs."""
        return float(self._need[: len(self.number)].max(initial=0.0))

    def need_outside(self, rows: Ints) -> float:
        """The pull that the most strained of all other joints needs."""
        needs = self._need[: len(self.number)].copy()
        needs[rows] = 0.0
        return float(needs.max(initial=0.0))

    def most_strained(self) -> Joint | None:
        """The joint that needs the largest pull; None if none needs any."""
        needs = self._need[: len(self.number)]
        if not len(needs) or needs.max() <= 0.0:
            return None
        return self.joint(int(needs.argmax()))

    def joint(self, row: int) -> Joint:
        """The joint of a row."""
        cell, axis = next(key for key, number in self.number.items() if number == row)
        step = _STEPS[axis]
        return Joint(cell, Cell(cell.x - step[0], cell.y - step[1], cell.z - step[2]))

    def add(self, cell: Cell) -> None:
        """One more cell, whose joints bear nothing yet: the caller balances its weight."""
        self.cells.add(cell)
        for axis, step in enumerate(_STEPS):
            lower = Cell(cell.x - step[0], cell.y - step[1], cell.z - step[2])
            if lower in self.cells or (axis == 2 and cell.z == 0):
                self._add_joint(cell, axis)
            upper = Cell(cell.x + step[0], cell.y + step[1], cell.z + step[2])
            if upper in self.cells:
                self._add_joint(upper, axis)

    def _add_joint(self, upper: Cell, axis: int) -> None:
        row = len(self.number)
        if row == len(self._axis):
            self._axis = np.concatenate([self._axis, np.zeros_like(self._axis)])
            self._bare = np.concatenate([self._bare, np.zeros_like(self._bare)])
            self._wrench = np.concatenate([self._wrench, np.zeros_like(self._wrench)])
            self._need = np.concatenate([self._need, np.zeros_like(self._need)])
        self.number[upper, axis] = row
        self._axis[row] = axis
        self._bare[row] = axis == 2 and upper.z == 0 and not self.physics.floor_grips

    def column(self, top: Cell) -> Ints:
        """Rows of the joints under a cell and under those beneath it, down to the floor, (h,)."""
        return np.array([self.number[Cell(top.x, top.y, z), 2] for z in range(top.z, -1, -1)])

    def wrenches(self, rows: Ints) -> Floats:
        """What those joints bear, (m, 6)."""
        found: Floats = self._wrench[rows]
        return found

    def needs_with(self, rows: Ints, wrenches: Floats) -> Floats:
        """What those joints would need if they bore wrenches (..., m, 6) instead."""
        return needed_pull(wrenches, self._axis[rows], self._bare[rows], self.physics)

    def bear(self, rows: Ints, wrenches: Floats) -> None:
        """Let those joints bear wrenches (m, 6); the caller keeps the balance."""
        self._wrench[rows] = wrenches
        self._need[rows] = self.needs_with(rows, wrenches)

    def region(self, cells: Iterable[Cell]) -> Region:
        """Some of the cells, whose joints among each other may bear something else; all joints
        outside of them bear what they bear now."""
        numbered = sorted(cells)
        inside = {c: i for i, c in enumerate(numbered)}
        array = np.array(numbered, dtype=np.int64)
        joints = Joints.among(array)
        loads = np.zeros((len(numbered), 6))
        loads[:, 2] = -self.physics.weight_n
        for one, index in inside.items():
            for axis, step in enumerate(_STEPS):
                lower = Cell(one.x - step[0], one.y - step[1], one.z - step[2])
                if lower not in inside and lower in self.cells:
                    loads[index] += self._at_centre(one, axis, -1.0)
                upper = Cell(one.x + step[0], one.y + step[1], one.z + step[2])
                if upper not in inside and upper in self.cells:
                    loads[index] -= self._at_centre(upper, axis, 1.0)
        rows = [
            self.number[numbered[part], axis]
            for part, axis in zip(joints.upper.tolist(), joints.axis.tolist(), strict=True)
        ]
        return Region(inside, np.array(rows, dtype=np.int64), joints, array, loads, self.physics)

    def _at_centre(self, upper: Cell, axis: int, side: float) -> Floats:
        """A joint's wrench about the centre of a part; the joint lies on that side of it."""
        found: Floats = self._wrench[self.number[upper, axis]].copy()
        arm_m = side * self.physics.pitch_m / 2
        one, two = (axis + 1) % 3, (axis + 2) % 3
        found[3 + one] -= arm_m * found[two]
        found[3 + two] += arm_m * found[one]
        return found


@dataclass(frozen=True)
class Region:
    """A part of a structure that is balanced anew."""

    cells: Mapping[Cell, int]
    """The cells, and their numbers in the programme."""
    rows: Ints
    """Of the joints that may change, in the programme's order, (m,)."""
    _joints: Joints
    _array: Ints
    """The cells, (n, 3)."""
    _loads: Floats
    """At rest, and what the joints outside of it bear, (n, 6)."""
    _physics: Physics

    @cached_property
    def _programme(self) -> Programme:
        return Programme(self._array, self._physics, self._joints)

    def solve(self, cell: Cell, push: Floats, enough: float = 0.0, thrift: float = 0.0) -> Solution:
        """Balance it while a cell is pushed.

        Args:
            cell: one of its cells.
            push: the load on it besides its weight, (6,).
            enough: a pull that is not to be improved on.
            thrift: as the programme takes it.
        """
        loads = self._loads.copy()
        loads[self.cells[cell]] += push
        return self._programme.solve(loads, enough, thrift)

    def spread(self, cell: Cell, pushes: Sequence[Floats]) -> Floats | None:
        """What its joints would bear as springs while a cell is pushed, (pushes, m, 6); None where
        some parts of it are held by nothing."""
        loads = np.repeat(self._loads[None], len(pushes), axis=0)
        loads[:, self.cells[cell]] += pushes
        return spread(self._joints, loads, self._physics)

    @property
    def determinate(self) -> bool:
        """Whether there is only one way in which its joints can bear a load, if there is any."""
        return len(self.rows) <= len(self.cells)
