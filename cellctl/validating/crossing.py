"""Which boxes of a lattice a surface meets: the separating-axis test of a triangle against a box.

Akenine-Moller, "Fast 3D triangle-box overlap testing", 2001. The lattice is finer than the cells:
the planes between cells are layers of their own, twice the tolerance thick, so that what only
grazes a cell can be told from what is in it. Along each axis slot ``2i + 1`` is the inside of cell
``i``, without the tolerance at both its ends, and slot ``2k`` is the layer around plane ``k``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cellctl.errors import PlanError
from cellctl.validating.clean import Surface
from cellctl.validating.orientation import Bools, Floats, Ints

_BLOCK = 300_000
"""Most triangle-box pairs that are looked at together; bounds the memory."""

_MOST_PAIRS = 2_000_000
"""Most pairs of a triangle larger than a cell and a cell within its bounds; they take some ten
seconds. An object of many triangles has small ones; only a tangle has as many large."""


class Lattice(NamedTuple):
    """Slots of a grid of cells: (2 nx + 1, 2 ny + 1, 2 nz + 1) of them."""

    size: tuple[int, int, int]
    """How many cells there are along x, y and z."""
    tolerance: float
    """In cells: half the thickness of the layer around a plane."""

    @property
    def shape(self) -> tuple[int, int, int]:
        """How many slots there are along x, y and z."""
        nx, ny, nz = self.size
        return (2 * nx + 1, 2 * ny + 1, 2 * nz + 1)

    def slots(self, points: Floats) -> Ints:
        """The slot of each point (n, 3), which is measured in cells."""
        plane = np.rint(points)
        around = np.abs(points - plane) <= self.tolerance
        slot = np.where(around, 2 * plane, 2 * np.floor(points) + 1)
        return np.clip(slot, 0, 2 * np.array(self.size)).astype(np.int64)

    def boxes(self, slots: Ints) -> tuple[Floats, Floats]:
        """Centres and half edges of slots (n, 3), in cells."""
        return slots / 2.0, np.where(slots % 2 == 1, 0.5 - self.tolerance, self.tolerance)


def insides(cells: Bools) -> Bools:
    """A mask of slots from a mask of cells: their insides."""
    mask = np.zeros([2 * n + 1 for n in cells.shape], dtype=np.bool_)
    mask[1::2, 1::2, 1::2] = cells
    return mask


def reached(cells: Bools) -> Bools:
    """A mask of slots from a mask of cells: their insides and all layers that touch them."""
    mask = insides(cells)
    for axis in range(3):
        ahead = np.moveaxis(mask, axis, 0)
        ahead[0:-1:2] |= ahead[1::2]
        ahead[2::2] |= ahead[1::2]
    return mask


class Crossing:
    """A surface over a lattice; asks which slots the one meets of the other."""

    def __init__(self, surface: Surface, lattice: Lattice) -> None:
        """Find the span of slots of each triangle.

        Raises:
            PlanError: the triangles are so large and so many that it would take minutes.
        """
        self._surface = surface
        self._lattice = lattice
        slots = lattice.slots(surface.vertices)
        self._entered = np.zeros(lattice.shape, dtype=np.bool_)
        self._entered[tuple(slots.T)] = True
        a, b, c = (slots[surface.faces[:, corner]] for corner in range(3))
        low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
        # A triangle within one slot says no more than its corners do.
        self._wide = np.flatnonzero((low != high).any(axis=1))
        self._low, self._high = low[self._wide], high[self._wide]
        cells = (self._high // 2 - self._low // 2 + 1).prod(axis=1)
        # Wherever it lies, a triangle smaller than a cell is in at most 2 x 2 x 2.
        if int(cells[cells > 8].sum()) > _MOST_PAIRS:
            raise PlanError(
                f"The mesh is a tangle of {len(surface.faces)} triangles, most of which reach "
                "across many parts.",
                "Simplify it first.",
            )

    def met(self, wanted: Bools) -> Bools:
        """Which of the wanted slots the surface meets."""
        found = self._entered & wanted
        left = wanted & ~found
        chosen = self._near(np.arange(len(self._wide)), left)
        counts = (self._high[chosen] - self._low[chosen] + 1).prod(axis=1)
        for block in blocks(counts, _BLOCK):
            near = self._near(chosen[block], left)
            owner, slots = candidates(self._low[near], self._high[near])
            open_ = left[tuple(slots.T)]
            owner, slots = owner[open_], slots[open_]
            centre, half = self._lattice.boxes(slots)
            faces = self._surface.faces[self._wide[near[owner]]]
            meets = _overlap(self._surface.vertices[faces] - centre[:, None, :], half)
            hit = tuple(slots[meets].T)
            found[hit] = True
            left[hit] = False
        return found

    def _near(self, chosen: Ints, left: Bools) -> Ints:
        """Those whose span holds any slot that is left: by a summed volume table."""
        if not left.any():
            return chosen[:0]
        table = np.zeros([n + 1 for n in left.shape], dtype=np.int32)
        table[1:, 1:, 1:] = left.cumsum(0, dtype=np.int32).cumsum(1).cumsum(2)
        (x0, y0, z0), (x1, y1, z1) = self._low[chosen].T, self._high[chosen].T + 1
        there = table[x1, y1, z1] - table[x0, y1, z1] - table[x1, y0, z1] - table[x1, y1, z0]
        there += table[x0, y0, z1] + table[x0, y1, z0] + table[x1, y0, z0] - table[x0, y0, z0]
        near: Ints = chosen[there > 0]
        return near


def blocks(counts: Ints, most: int) -> list[slice]:
    """Runs of items whose counts together stay within ``most`` (a single one may exceed it)."""
    total = np.cumsum(counts)
    runs = []
    start = 0
    while start < len(counts):
        done = total[start - 1] if start else 0
        end = max(start + 1, int(np.searchsorted(total, done + most, side="right")))
        runs.append(slice(start, end))
        start = end
    return runs


def candidates(low: Ints, high: Ints) -> tuple[Ints, Ints]:
    """Every index from low (n, d) to high (n, d): whose it is (k,), and which it is (k, d)."""
    spans = np.maximum(high - low + 1, 0)
    counts = spans.prod(axis=1)
    owner = np.repeat(np.arange(len(counts)), counts)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    index = np.empty((len(owner), low.shape[1]), dtype=np.int64)
    for axis in reversed(range(low.shape[1])):
        rank, index[:, axis] = np.divmod(rank, spans[owner, axis])
    return owner, low[owner] + index


def _overlap(corners: Floats, half: Floats) -> Bools:
    """Whether triangles (k, 3, 3), relative to the centres of boxes, meet the boxes (k, 3)."""
    meets = np.zeros(len(corners), dtype=np.bool_)
    near = np.all((corners.min(axis=1) <= half) & (corners.max(axis=1) >= -half), axis=1)
    edges = np.roll(corners, -1, axis=1) - corners
    normal = np.cross(edges[:, 0], edges[:, 1])
    distance = np.abs(np.einsum("ij,ij->i", normal, corners[:, 0]))
    near &= distance <= (half * np.abs(normal)).sum(axis=1)
    index = np.flatnonzero(near)
    corners, edges, half = corners[index], edges[index], half[index]
    touch = np.ones(len(index), dtype=np.bool_)
    for axis in range(3):
        # The axis is the cross product of a unit vector and an edge.
        b, c = (axis + 1) % 3, (axis + 2) % 3
        for edge in range(3):
            eb, ec = edges[:, edge, b], edges[:, edge, c]
            projected = corners[:, :, c] * eb[:, None] - corners[:, :, b] * ec[:, None]
            reach = half[:, c] * np.abs(eb) + half[:, b] * np.abs(ec)
            touch &= (projected.min(axis=1) <= reach) & (projected.max(axis=1) >= -reach)
    meets[index] = touch
    return meets
