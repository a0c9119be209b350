"""From a shape to cells: occupied if any portion of it is inside the cell.

Cells that the surface meets are found by a triangle-box test (crossing.py). The rest is inside
where the surface winds around it: for a closed surface its enclosed volume there says so
(volume.py), which is exact; for one with holes the generalised winding number (winding.py).

What reaches into a cell by no more than ``fit.TOLERANCE_M`` is not in it: a shape half a millimetre
too large fills no further row, and a face on a plane fills no neighbour. Things so thin that they
would be in no cell at all get one nevertheless (slivers.py).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Cell
from cellctl.validating.clean import Surface
from cellctl.validating.crossing import Crossing, Lattice, insides
from cellctl.validating.fit import Shape
from cellctl.validating.orientation import Bools, is_closed, oriented
from cellctl.validating.overlap import windings
from cellctl.validating.slivers import claim
from cellctl.validating.volume import contents
from cellctl.validating.winding import winding_numbers

Floats = npt.NDArray[np.float64]

LEAST_FILL = 1e-6
"""A cell that is occupied is never told as empty."""

_CONTRADICTION = 1e-3
"""A share of the volume that is inside out while the rest is not: some pieces must be turned."""


class Voxels(NamedTuple):
    """The cells that a shape occupies, from [0, 0, 0] at its bounding box's minimum corner."""

    cells: frozenset[Cell]
    fill: dict[Cell, float]
    """For every cell, in their order: which share of its volume is solid, above 0 and up to 1. An
    open sheet counts as thick as the tolerance, and so does what is in no cell but between two."""


def grid_size(extent: Floats, tolerance: float) -> tuple[int, int, int]:
    """How many cells a shape of that extent covers, along x, y and z; at least one each.

    Args:
        extent: in cells.
        tolerance: in cells: so much too large is not too large.
    """
    nx, ny, nz = np.maximum(1, np.ceil(extent - tolerance)).astype(int).tolist()
    return (nx, ny, nz)


def discretise(shape: Shape) -> frozenset[Cell]:
    """The cells of ``voxelise``."""
    return voxelise(shape).cells


def voxelise(shape: Shape) -> Voxels:
    """The cells that a shape occupies, and how full they are.

    Raises:
        PlanError: the mesh is a tangle that would take minutes.
    """
    size = grid_size(shape.extent, shape.tolerance)
    lattice = Lattice(size, shape.tolerance)
    crossing = Crossing(shape.surface, lattice)
    crossed = crossing.met(insides(np.ones(size, dtype=np.bool_)))[1::2, 1::2, 1::2]
    surface, excess = _outward(shape.surface, size)
    closed = is_closed(surface.faces)
    enclosed = contents(surface, size)
    within = _within(surface, enclosed.volume, closed, ~crossed)
    occupied = crossed | within
    thin = claim(crossing, occupied)
    least = np.full(size, LEAST_FILL) if closed else enclosed.area * shape.tolerance
    least[thin] = shape.tolerance
    fill = np.clip(np.maximum(enclosed.volume - excess, least), LEAST_FILL, 1.0)
    fill[within] = 1.0
    cells = [Cell(*cell) for cell in np.argwhere(occupied | thin).tolist()]
    return Voxels(frozenset(cells), {cell: float(fill[cell]) for cell in cells})


def _outward(surface: Surface, size: tuple[int, int, int]) -> tuple[Surface, Floats]:
    """The surface with its pieces' outsides out, and the volume it encloses more than once."""
    wound = windings(surface, size)
    if wound.inward > _CONTRADICTION * wound.outward:
        vertices, faces = surface
        if wound.outward > _CONTRADICTION * wound.inward:
            faces = oriented(vertices, faces)
        else:
            faces = faces[:, ::-1]
        surface = Surface(vertices, faces)
        wound = windings(surface, size)
    return surface, wound.excess


def _within(surface: Surface, volume: Floats, closed: bool, free: Bools) -> Bools:
    """Which of the cells that the surface does not meet it encloses."""
    if closed:
        return free & (np.abs(volume) > 0.5)
    within = np.zeros_like(free)
    cells = np.argwhere(free).astype(np.float64)
    if len(cells):
        within[free] = np.abs(winding_numbers(surface, cells + 0.5)) > 0.5
    return within
