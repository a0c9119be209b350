"""How much of a wanted shape is kept: one number from 0 to 1, the same for every policy.

Both shapes are stretched into the same unit box, and compared there by the volume that they fill
and by their outlines from the front, the side and above: what the two share over what they cover
together. That is a Jaccard index of one weighted measure, and linear-fractional in the cells, so
that an exact solver can prove the best one. What the stretching hides, the size, is a factor of its
own: how far the two boxes agree, as the mean ratio of their edges.

Identical shapes have 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Cell
from cellctl.validating.rules import Cells

Floats = npt.NDArray[np.float64]
Size = tuple[int, int, int]

FORMULA = (
    "likeness = G * (V+ + P+) / (V* + P*); "
    "G: the mean ratio of the boxes' edges, smaller over larger (geometric mean); "
    "V: volume shared (+) or covered (*) over the volume wanted, both stretched to one box; "
    "P: the same of the outlines from the front, the side and above, averaged"
)
"""For reports, beside the figures."""

VIEWS = ((0, 2), (1, 2), (0, 1))
"""The axes that span the outlines from the front, from the side and from above."""


class Part(NamedTuple):
    """What two shapes share and what they cover together, as a part of what was wanted."""

    shared: float
    covered: float


class Likeness(NamedTuple):
    """The comparison of two shapes."""

    volume: Part
    outlines: Part
    size: float
    """The mean ratio of the boxes' edges."""

    @property
    def score(self) -> float:
        """0 to 1; see ``FORMULA``."""
        shared = self.volume.shared + self.outlines.shared
        # Rounding must not make it more than all.
        return min(1.0, self.size * shared / (self.volume.covered + self.outlines.covered))


@dataclass(frozen=True)
class Terms:
    """What every cell and pixel of a box of another size counts, for the solver.

    A cell c that is filled adds ``volume[c]`` to what is shared and
    ``cell - volume[c]`` to what is covered; pixels of the outlines likewise.
    """

    size: Size
    volume: Floats
    """(nx, ny, nz): the part of the wanted volume that lies in each cell."""
    cell: float
    """The volume of a cell, as a part of the wanted volume."""
    outlines: tuple[Floats, Floats, Floats]
    """Of each view: the part of a third of the wanted outline that lies in each pixel."""
    pixels: tuple[float, float, float]
    """The area of a pixel of each view, likewise."""
    agreement: float
    """Of the sizes: the mean ratio of the boxes' edges."""


@dataclass(frozen=True)
class Wanted:
    """A shape that was asked for, as cells from [0, 0, 0]."""

    cells: Cells

    @cached_property
    def size(self) -> Size:
        """Extent in cells along x, y and z."""
        spans = [max(axis) + 1 for axis in zip(*self.cells, strict=True)]
        return (spans[0], spans[1], spans[2])

    @cached_property
    def filled(self) -> Floats:
        """1 where there is a cell, else 0; shaped like ``size``."""
        return grid_of(self.cells, self.size)

    @cached_property
    def views(self) -> tuple[Floats, Floats, Floats]:
        """The outlines: 1 where any cell is seen, else 0."""
        front, side, top = (self.filled.max(axis=3 - a - b) for a, b in VIEWS)
        return (front, side, top)

    def terms(self, size: Size) -> Terms:
        """What the cells and pixels of a box of that size count."""
        spread = [_overlaps(old, new) for old, new in zip(self.size, size, strict=True)]
        volume = self.filled
        for axis, matrix in enumerate(spread):
            volume = np.moveaxis(np.tensordot(volume, matrix, axes=(axis, 0)), -1, axis)
        total = float(self.filled.mean())
        outlines = []
        pixels = []
        for view, (a, b) in zip(self.views, VIEWS, strict=True):
            share = 3.0 * float(view.mean())
            outlines.append(spread[a].T @ view @ spread[b] / share)
            pixels.append(1.0 / (size[a] * size[b]) / share)
        return Terms(
            size=size,
            volume=volume / total,
            cell=1.0 / float(np.prod(size)) / total,
            outlines=(outlines[0], outlines[1], outlines[2]),
            pixels=(pixels[0], pixels[1], pixels[2]),
            agreement=_agreement(self.size, size),
        )

    def likeness(self, cells: Cells) -> Likeness:
        """How much of this shape other cells keep; they may lie anywhere.

        Raises:
            ValueError: there are no cells.
        """
        low = [min(axis) for axis in zip(*cells, strict=True)]
        other = Wanted(frozenset(Cell(c.x - low[0], c.y - low[1], c.z - low[2]) for c in cells))
        terms = self.terms(other.size)
        shared = float((terms.volume * other.filled).sum())
        volume = Part(shared, 1.0 + terms.cell * len(cells) - shared)
        seen = sum(float((t * v).sum()) for t, v in zip(terms.outlines, other.views, strict=True))
        area = sum(p * float(v.sum()) for p, v in zip(terms.pixels, other.views, strict=True))
        return Likeness(volume, Part(seen, 1.0 + area - seen), terms.agreement)

    def score(self, cells: Cells) -> float:
        """``likeness(cells).score``, and 0 where there are no cells."""
        return float(self.likeness(cells).score) if cells else 0.0


def grid_of(cells: Cells, size: Size) -> Floats:
    """An array of that size with 1 at the cells."""
    grid = np.zeros(size)
    grid[tuple(np.array(sorted(cells)).T)] = 1.0
    return grid


def _overlaps(old: int, new: int) -> Floats:
    """Length shared by the i-th of ``old`` and the j-th of ``new`` equal parts of [0, 1]."""
    low = np.maximum.outer(np.arange(old) / old, np.arange(new) / new)
    high = np.minimum.outer(np.arange(1, old + 1) / old, np.arange(1, new + 1) / new)
    shared: Floats = np.maximum(high - low, 0.0)
    return shared


def _agreement(wanted: Size, size: Size) -> float:
    ratios = [min(old, new) / max(old, new) for old, new in zip(wanted, size, strict=True)]
    return math.prod(ratios) ** (1.0 / 3.0)
