"""From a shape to cells: occupied if any portion of it is inside the cell.

Cells that the surface meets are found by the separating-axis test of a triangle against a box
(Akenine-Moller, 2001); the rest is inside where the winding number says so (winding.py). Cells are
tested shrunk by ``SKIN``, so that a face that lies on a cell's plane fills no neighbour.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Cell
from cellctl.validating.fit import Shape
from cellctl.validating.winding import inside

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

SKIN = 1e-3
"""How much a cell is shrunk on every side for the test, as a part of its edge. Meshes are exact to
about a millionth of their size, so a tenth of this would still be safe; a hundredth is not."""

_BLOCK = 400_000
"""Most triangle-cell pairs that are tested at once; bounds the memory."""


def grid_size(extent: Floats) -> tuple[int, int, int]:
    """How many cells a shape of that extent covers, along x, y and z; at least one each."""
    nx, ny, nz = np.maximum(1, np.ceil(extent - 2 * SKIN)).astype(int).tolist()
    return (nx, ny, nz)


def discretise(shape: Shape) -> frozenset[Cell]:
    """The cells that the shape occupies, from [0, 0, 0] at its bounding box's minimum corner."""
    size = grid_size(shape.extent)
    surface = shape.surface
    occupied, unclaimed = _crossed(surface.triangles, size)
    free = np.argwhere(~occupied)
    if len(free):
        within = inside(surface, free.astype(np.float64) + 0.5)
        occupied[tuple(free[within].T)] = True
    _claim_sheets(surface.triangles[unclaimed], occupied)
    return frozenset(Cell(*cell) for cell in np.argwhere(occupied).tolist())


def _crossed(triangles: Floats, size: tuple[int, int, int]) -> tuple[Bools, Bools]:
    """Which cells the surface meets, (nx, ny, nz), and which triangles met none, (m,)."""
    occupied = np.zeros(size, dtype=np.bool_)
    limit = np.array(size) - 1
    low = np.maximum(np.ceil(triangles.min(axis=1) - 1 + SKIN), 0).astype(np.int64)
    high = np.minimum(np.floor(triangles.max(axis=1) - SKIN), limit).astype(np.int64)
    spans = high - low + 1
    # A triangle that lies wholly between two shrunk cells has an empty span.
    empty = np.any(spans <= 0, axis=1)
    single = np.all(spans == 1, axis=1)
    # The box of such a triangle touches one cell only, but its corner may be cut off: only a
    # triangle with a vertex in the shrunk cell is certain. The others are tested like the large.
    offset = triangles - (low[:, None, :] + 0.5)
    certain = single & np.any(np.all(np.abs(offset) < 0.5 - SKIN, axis=2), axis=1)
    occupied[tuple(low[certain].T)] = True
    rest = np.flatnonzero(~certain & ~empty)
    hit = certain.copy()
    counts = spans[rest].prod(axis=1)
    for block in _blocks(counts):
        chosen = rest[block]
        owner, cells = _candidates(low[chosen], spans[chosen])
        meets = _overlap(triangles[chosen][owner] - (cells[:, None, :] + 0.5))
        occupied[tuple(cells[meets].T)] = True
        hit[chosen[owner[meets]]] = True
    return occupied, ~hit


def _blocks(counts: Ints) -> list[slice]:
    """Runs of triangles whose pairs together stay within ``_BLOCK`` (a single one may exceed)."""
    total = np.cumsum(counts)
    blocks = []
    start = 0
    while start < len(counts):
        done = total[start - 1] if start else 0
        end = max(start + 1, int(np.searchsorted(total, done + _BLOCK, side="right")))
        blocks.append(slice(start, end))
        start = end
    return blocks


def _candidates(low: Ints, spans: Ints) -> tuple[Ints, Ints]:
    """Every cell of every span: the span's number (k,), and the cell (k, 3)."""
    counts = spans.prod(axis=1)
    owner = np.repeat(np.arange(len(counts)), counts)
    rank = np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)
    _, ny, nz = spans[owner].T
    cells = low[owner] + np.stack([rank // (ny * nz), rank // nz % ny, rank % nz], axis=1)
    return owner, cells


def _overlap(corners: Floats) -> Bools:
    """Whether triangles (k, 3, 3), relative to cell centres, meet the shrunk cells."""
    half = 0.5 - SKIN
    meets: Bools = np.all((corners.min(axis=1) < half) & (corners.max(axis=1) > -half), axis=1)
    edges = np.roll(corners, -1, axis=1) - corners
    normal = np.cross(edges[:, 0], edges[:, 1])
    distance = np.abs(np.einsum("ij,ij->i", normal, corners[:, 0]))
    meets &= distance <= half * np.abs(normal).sum(axis=1)
    for axis in range(3):
        # The axis is the cross product of a unit vector and an edge.
        b, c = (axis + 1) % 3, (axis + 2) % 3
        for edge in range(3):
            eb, ec = edges[:, edge, b], edges[:, edge, c]
            projected = corners[:, :, c] * eb[:, None] - corners[:, :, b] * ec[:, None]
            reach = half * (np.abs(eb) + np.abs(ec))
            meets &= (projected.min(axis=1) <= reach) & (projected.max(axis=1) >= -reach)
    return meets


def _claim_sheets(triangles: Floats, occupied: Bools) -> None:
    """Give the cell above it to an open sheet that lies exactly on a plane between free cells.

    Such a sheet is inside no cell, and would vanish. Faces of solids lie so too: they are known by
    an occupied cell on one of their sides.
    """
    for axis in range(3):
        plane = np.round(triangles[:, 0, axis])
        on_plane = np.all(np.abs(triangles[:, :, axis] - plane[:, None]) <= SKIN, axis=1)
        if not on_plane.any():
            continue
        planes = plane[on_plane]
        sheets = triangles[on_plane].copy()
        for height in np.unique(planes):
            above = min(int(height), occupied.shape[axis] - 1)
            below = max(int(height) - 1, 0)
            sheet = sheets[planes == height]
            sheet[:, :, axis] = above + 0.5
            met, _ = _crossed(sheet, occupied.shape)
            index = [slice(None), slice(None), slice(None)]
            index[axis] = slice(above, above + 1)
            here = tuple(index)
            index[axis] = slice(below, below + 1)
            occupied[here] |= met[here] & ~occupied[tuple(index)]
