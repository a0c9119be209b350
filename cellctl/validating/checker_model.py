"""The equations of balance and the limits of joints, for the judge of plans.

The unknowns of a joint are the force (3) and the moment (3) along x, y, z that the part on its
lower side, or the floor, exerts on the other one, the moment about the middle of the faces: its
*resultants*. Forces are measured in ``Model.force_n``, lengths in halves of a part's edge.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from collections.abc import Set as AbstractSet

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array

from cellctl.assembly import Cell
from cellctl.config import CellConfig

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

GRAVITY_M_S2 = 9.80665
X, Y, Z = 0, 1, 2
_SLACK = 1e-6
"""The share of a joint's strength that rounding may cost."""
_ROUNDING = 2e-6
"""What of a balance or a limit rounding may cost, in units of force."""

_SMALL = 100
"""Up to so many parts all entries of the balance are kept, empty ones too: they are read faster."""


class Model:
    """All parts that stand at some time, and all joints that they can have; built once a plan.

    Which parts stand is told to each method as ``here``, a mask (parts,).

    Args:
        cells: of all parts.
        config: the cell, with its ``[stability]``.
    """

    def __init__(self, cells: AbstractSet[Cell], config: CellConfig) -> None:
        stability = config.stability
        self.cells = sorted(cells)
        self.number = {cell: index for index, cell in enumerate(self.cells)}
        weight_n = config.voxel.mass_kg * GRAVITY_M_S2
        # So large that rounding counts neither where magnets are weak nor where parts are light.
        self.force_n = stability.magnet_force_n + weight_n
        self.weight = weight_n / self.force_n
        self._joints()
        planes, shares = _planes(stability.friction, stability.contact)
        self.pull = stability.magnet_force_n / self.force_n
        strength = np.full(len(self.upper), self.pull * (1.0 + _SLACK) / stability.least_margin)
        if stability.floor == "bare":
            strength[self.lower < 0] = 0.0
        self._plane = planes[self.axis]
        self.offsets = strength[:, None] * shares
        self.balance = _balance(self.upper, self.lower, self.axis, len(self.cells))
        self._dense = self.balance.toarray() if len(self.cells) <= _SMALL else None
        self.limits = _blocks(self._plane)
        # How readily a joint takes up each resultant, for a first guess: as much as it bears.
        ease = np.tile([1.0, 1.0, 1.0], (len(self.upper), 2))
        shear = max(stability.friction, 0.1) ** 2
        for axis in (X, Y, Z):
            at = self.axis == axis
            ease[np.ix_(at, [(axis + 1) % 3, (axis + 2) % 3, 3 + axis])] = shear
        self.ease = ease

    def _joints(self) -> None:
        """``upper``, ``lower`` (-1 is the floor) and ``axis`` of every joint, (joints,)."""
        found: list[tuple[int, int, int]] = []
        self.beside: list[list[int]] = [[] for _ in self.cells]
        self.beneath = [-1] * len(self.cells)
        self.column_joint = [-1] * len(self.cells)
        for body, (x, y, z) in enumerate(self.cells):
            for axis, lower in enumerate(((x - 1, y, z), (x, y - 1, z), (x, y, z - 1))):
                other = self.number.get(Cell(*lower), -1)
                if other < 0 and not (axis == Z and z == 0):
                    continue
                if axis == Z:
                    self.beneath[body], self.column_joint[body] = other, len(found)
                if other >= 0:
                    self.beside[body].append(other)
                    self.beside[other].append(body)
                found.append((body, other, axis))
        table: Ints = np.array(found, dtype=np.int64).reshape(-1, 3)
        self.upper, self.lower, self.axis = table.T

    def balance_of(self, rows: Ints, columns: Ints) -> Floats:
        """Some rows and columns of ``balance``."""
        found: Floats = (
            self.balance[rows][:, columns].toarray()
            if self._dense is None
            else self._dense[np.ix_(rows, columns)]
        )
        return found

    def joined(self, here: Bools) -> Bools:
        """Joints of which both parts are here, (joints,)."""
        joined: Bools = here[self.upper] & ((self.lower < 0) | here[self.lower])
        return joined

    def rest(self, here: Bools) -> Floats:
        """The weights, (parts, 6)."""
        load = np.zeros((len(self.cells), 6))
        load[here, Z] = -self.weight
        return load

    def left_over(self, resultants: Floats, load: Floats) -> Floats:
        """What does not balance, (parts, 6)."""
        found: Floats = (self.balance @ resultants.ravel()).reshape(-1, 6) + load
        return found

    def holds(self, resultants: Floats, load: Floats, here: Bools) -> bool:
        """Whether resultants (joints, 6) balance a load (parts, 6) and no joint bears too much."""
        if resultants[~self.joined(here)].any():
            return False
        if not (np.abs(self.left_over(resultants, load)[here]) <= _ROUNDING).all():
            return False
        borne = np.matmul(self._plane, resultants[:, :, None])[:, :, 0]
        return bool((borne <= self.offsets + _ROUNDING).all())

    def around(self, seeds: Iterable[int], here: Bools, count: int) -> list[int]:
        """About so many parts nearest to some, and what is straight beneath these."""
        found = [body for body in seeds if here[body]]
        seen = set(found)
        for body in found:  # grows meanwhile
            if len(found) >= count:
                break
            for other in self.beside[body]:
                if here[other] and other not in seen:
                    seen.add(other)
                    found.append(other)
        for body in tuple(found):
            under = self.beneath[body]
            while under >= 0 and here[under] and under not in seen:
                seen.add(under)
                under = self.beneath[under]
        return sorted(seen)


def _planes(friction: float, contact: str) -> tuple[Floats, Floats]:
    """Planes ``a . (force, moment) <= b * strength`` of a joint: a (axis, planes, 6), b (planes,).

    Tilts come first, then shears with the twist.
    """
    signs = list(itertools.product((1.0, -1.0), repeat=2))
    tilts = signs if contact == "diamond" else [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)]
    found = np.zeros((3, len(tilts) + 2 * len(signs), 6))
    for axis in (X, Y, Z):
        one, two = (axis + 1) % 3, (axis + 2) % 3
        found[axis, : len(tilts), [3 + one, 3 + two]] = np.array(tilts).T
        found[axis, : len(tilts), axis] = -1.0
        rubs = [(*pair, turn) for pair in signs for turn in (1.0, -1.0)]
        found[axis, len(tilts) :, [one, two, 3 + axis]] = np.array(rubs).T
        found[axis, len(tilts) :, axis] = -friction
    shares = np.array([1.0] * len(tilts) + [friction] * (2 * len(signs)))
    return found, shares


def _balance(upper: Ints, lower: Ints, axis: Ints, parts: int) -> csr_array:
    """What resultants do to the parts, (6 parts, 6 joints)."""
    # The faces are half an edge down the axis from the upper part, and up from the lower: on both,
    # a force f turns by -e x f, with e along the axis.
    turning = -np.stack([np.cross(np.eye(3)[a], np.eye(3)).T for a in (X, Y, Z)])
    blocks = np.zeros((2, 3, 6, 6))
    for side, sign in enumerate((1.0, -1.0)):
        blocks[side, :, range(6), range(6)] = sign
        blocks[side, :, 3:, :3] = turning
    rows, columns, values = [], [], []
    six = np.arange(6)
    for side, body in enumerate((upper, lower)):
        joint = np.flatnonzero(body >= 0)
        shape = (len(joint), 6, 6)
        rows.append(np.broadcast_to(6 * body[joint, None, None] + six[:, None], shape).ravel())
        columns.append(np.broadcast_to(6 * joint[:, None, None] + six, shape).ravel())
        values.append(blocks[side][axis[joint]].ravel())
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    found = csr_array(entries, shape=(6 * parts, 6 * len(upper)))
    found.eliminate_zeros()
    return found


def _blocks(planes: Floats) -> csr_array:
    """The planes of all joints side by side, (planes joints, 6 joints)."""
    joints, each, _ = planes.shape
    columns = np.broadcast_to(6 * np.arange(joints)[:, None, None] + np.arange(6), planes.shape)
    starts = np.arange(0, planes.size + 1, 6)
    found = csr_array(
        (planes.flatten(), columns.flatten(), starts), shape=(joints * each, 6 * joints)
    )
    found.eliminate_zeros()
    return found
