"""A structure as arrays: parts in slices, joints, and the maps between their motions and forces."""

from __future__ import annotations

import numpy as np

from cellctl.assembly import Cell
from cellctl.sim.physics.joints import (
    INERTIA,
    Floats,
    Indices,
    Joint,
    Material,
    joints_of,
    relative_motion,
)


class Structure:
    """Parts at some cells, each with six degrees of freedom: three velocities, three turnings.

    Parts are ordered in slices of the same distance, counted in joints, from the corner where each
    connected piece begins; joints tie a slice to the next one only. Arrays are cases x parts x 6
    for motions and forces of parts, cases x joints x 6 for relative motions and wrenches of joints.

    Args:
        cells: at least one; all are joined to the floor.
        material: what holds them together.
    """

    def __init__(self, cells: frozenset[Cell], material: Material) -> None:
        self.material = material
        slices = _slices(cells)
        self.cells = tuple(cell for level in slices for cell in level)
        self.joints: tuple[Joint, ...] = joints_of(cells)
        self.inertia: Floats = np.repeat([1.0, INERTIA], 3)
        index = {cell: at for at, cell in enumerate(self.cells)}
        self._upper: Indices = np.array([index[joint.upper] for joint in self.joints])
        # The floor is one part more, which never moves.
        floor = len(self.cells)
        self._lower: Indices = np.array([index.get(joint.lower, floor) for joint in self.joints])
        axes = [joint.axis for joint in self.joints]
        self._from_upper = np.array([relative_motion(along, -1) for along in range(3)])[axes]
        self._from_lower = -np.array([relative_motion(along, 1) for along in range(3)])[axes]
        self._joints_at = self._joint_slots()
        ends = np.cumsum([len(level) for level in slices])
        self._ends: list[int] = ends.tolist()
        self._slice_of: Indices = np.searchsorted(ends, np.arange(floor + 1), side="right")

    def weights(self) -> Floats:
        """Parts x 6: gravity, and the pull of every magnet on both of its parts."""
        loads = np.zeros((len(self.cells), 6))
        loads[:, 2] = -1.0
        pull = np.zeros((1, len(self.joints), 6))
        pull[0, :, 0] = [-self.magnet(joint) for joint in self.joints]
        return np.asarray(loads + self.forces(pull)[0])

    def magnet(self, joint: Joint) -> float:
        """How hard a joint is drawn together."""
        return self.material.magnet if joint.lower.z >= 0 else self.material.floor_magnet

    def relative(self, motion: Floats) -> Floats:
        """Motions of parts to relative motions at joints."""
        grounded = np.pad(motion, ((0, 0), (0, 1), (0, 0)))
        return np.asarray(
            np.einsum("jkl,cjl->cjk", self._from_upper, grounded[:, self._upper])
            + np.einsum("jkl,cjl->cjk", self._from_lower, grounded[:, self._lower])
        )

    def forces(self, wrenches: Floats) -> Floats:
        """Wrenches at joints to forces and moments on parts."""
        on_upper = np.einsum("jkl,cjk->cjl", self._from_upper, wrenches)
        on_lower = np.einsum("jkl,cjk->cjl", self._from_lower, wrenches)
        return self._gather(on_upper, on_lower)

    def stiffness(self, of_joints: Floats) -> tuple[list[Floats], list[Floats]]:
        """What resists the motion of parts: their inertia, and 6 x 6 matrices of the joints.

        Args:
            of_joints: cases x joints x 6 x 6, symmetric.

        Returns:
            The blocks of a block tridiagonal matrix, as ``Factors.of`` takes them.
        """
        upper = self._from_upper.swapaxes(1, 2) @ of_joints
        at_upper = upper @ self._from_upper
        at_lower = self._from_lower.swapaxes(1, 2) @ of_joints @ self._from_lower
        between = upper @ self._from_lower
        own = self._gather(at_upper, at_lower) + np.diag(self.inertia)
        cases = len(of_joints)
        diagonal, ties = [], []
        for level, (start, end) in enumerate(zip([0, *self._ends], self._ends, strict=False)):
            size = end - start
            block = np.zeros((cases, size, 6, size, 6))
            parts = np.arange(size)
            block[:, parts, :, parts] = own[:, start:end].swapaxes(0, 1)
            diagonal.append(block.reshape(cases, 6 * size, 6 * size))
            if level + 1 < len(self._ends):
                tie = np.zeros((cases, size, 6, self._ends[level + 1] - end, 6))
                up = self._tying(level, level + 1)
                near, far = self._lower[up] - start, self._upper[up] - end
                tie[:, near, :, far] = between[:, up].swapaxes(0, 1).swapaxes(2, 3)
                down = self._tying(level + 1, level)
                near, far = self._upper[down] - start, self._lower[down] - end
                tie[:, near, :, far] = between[:, down].swapaxes(0, 1)
                ties.append(tie.reshape(cases, 6 * size, -1))
        return diagonal, ties

    def sliced(self, on_parts: Floats) -> list[Floats]:
        """Cases x parts x 6, as one vector a slice."""
        pieces = np.split(on_parts, self._ends[:-1], axis=1)
        return [piece.reshape(len(on_parts), -1) for piece in pieces]

    def joined(self, slices: list[Floats]) -> Floats:
        """The inverse of ``sliced``."""
        return np.concatenate(slices, axis=1).reshape(len(slices[0]), -1, 6)

    def _gather(self, on_upper: Floats, on_lower: Floats) -> Floats:
        """The sum over the joints of each part."""
        rest = ((0, 0),) * (on_upper.ndim - 2)
        both = np.concatenate([on_upper, on_lower], axis=1)
        return np.asarray(np.pad(both, ((0, 0), (0, 1), *rest))[:, self._joints_at].sum(axis=2))

    def _joint_slots(self) -> Indices:
        """Parts x 6: where each part's joints are in what ``_gather`` joins; its end for none."""
        count = len(self.joints)
        slots = np.full((len(self.cells) + 1, 6), 2 * count)
        for at, joint in enumerate(self.joints):
            slots[self._upper[at], joint.axis] = at
            slots[self._lower[at], 3 + joint.axis] = count + at
        return np.asarray(slots[:-1])

    def _tying(self, lower: int, upper: int) -> Indices:
        """The joints whose parts are in these slices; the floor is in none."""
        inside = (self._slice_of[self._lower] == lower) & (self._slice_of[self._upper] == upper)
        return np.flatnonzero(inside)


def _slices(cells: frozenset[Cell]) -> list[list[Cell]]:
    """The cells by their distance from the lowest corner of their connected piece.

    Elimination then begins at the floor, where parts are held: begun at a free end, it would
    lose their inertia in the rounding of stiff joints.
    """
    left = set(cells)
    slices: list[list[Cell]] = []
    for corner in sorted(cells, key=lambda cell: (cell.z, cell)):
        if corner not in left:
            continue
        left.remove(corner)
        level, distance = [corner], 0
        while level:
            if distance == len(slices):
                slices.append([])
            slices[distance] += level
            reached = {near for cell in level for near in cell.neighbours()} & left
            left -= reached
            level, distance = sorted(reached), distance + 1
    return slices
