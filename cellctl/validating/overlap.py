"""Where a surface winds more than once, or inside out: sampled along columns through the cells.

A volume by the divergence theorem counts twice what two overlapping solids share. Columns on a
fine grid tell how much that is, and so make of the sum a union; where nothing overlaps they change
nothing, and the sum stays exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cellctl.validating.clean import Surface
from cellctl.validating.crossing import blocks, candidates
from cellctl.validating.orientation import Floats, Ints

_COLUMNS = 16
"""So many along each edge of a cell's floor."""

_PLACE = np.array([0.4142135, 0.5772156])
"""Where in its square a column stands: not where a designer would put an edge."""

_BLOCK = 1_000_000
"""Most triangle-column pairs that are looked at together; bounds the memory."""


class Windings(NamedTuple):
    """What the columns saw."""

    excess: Floats
    """(nx, ny, nz), in cells: by how much the enclosed volume, counted as often as the surface
    winds around it, exceeds the solid, which is there once. What is inside out is left out: beside
    a hole a column may seem so that is not."""
    outward: float
    """Volume around which the surface winds as it should, in cells."""
    inward: float
    """Volume around which it winds inside out."""


def windings(surface: Surface, size: tuple[int, int, int]) -> Windings:
    """Sample how often a surface winds around what is in each cell of a grid of that size.

    Columns that enter a surface without leaving it went through a hole, and are left out.
    """
    column, height, turn = _hits(surface, size)
    order = np.lexsort((-height, column))
    column, height, turn = column[order], height[order], turn[order]
    across, along = size[0] * _COLUMNS, size[1] * _COLUMNS
    good = np.bincount(column, turn, across * along) == 0
    # From above: winding number between each hit and the next. Sound columns sum up to 0, so their
    # running sum needs no new start.
    sound = good[column]
    column, height, turn = column[sound], height[sound], turn[sound]
    number = np.cumsum(turn)[:-1]
    length = height[:-1] - height[1:]
    outward = float(length[number > 0].sum()) / _COLUMNS**2
    inward = float(length[number < 0].sum()) / _COLUMNS**2
    more = np.flatnonzero((number > 1) & (length > 0))
    excess = np.zeros(size)
    if len(more):
        top, bottom = height[more], height[more + 1]
        limit = size[2] - 1
        low = np.clip(np.floor(bottom), 0, limit).astype(np.int64)
        high = np.clip(np.floor(top), 0, limit).astype(np.int64)
        owner, layer = candidates(low[:, None], high[:, None])
        layer = layer[:, 0]
        share = np.minimum(top[owner], layer + 1) - np.maximum(bottom[owner], layer)
        x, y = np.divmod(column[more][owner], along)
        cells = (x // _COLUMNS, y // _COLUMNS, layer)
        np.add.at(excess, cells, share * (number[more][owner] - 1.0))
        seen = good.reshape(size[0], _COLUMNS, size[1], _COLUMNS).sum(axis=(1, 3))
        excess /= np.maximum(seen, 1)[:, :, None]
    return Windings(excess, outward, inward)


def _hits(surface: Surface, size: tuple[int, int, int]) -> tuple[Ints, Floats, Floats]:
    """Where columns meet triangles: the column, the height, and 1 on top of a solid, else -1."""
    limit = np.array(size[:2]) * _COLUMNS - 1
    flat = surface.vertices[:, :2] * _COLUMNS - _PLACE
    a, b, c = (flat[surface.faces[:, corner]] for corner in range(3))
    low = np.maximum(np.ceil(np.minimum(np.minimum(a, b), c)), 0).astype(np.int64)
    high = np.minimum(np.floor(np.maximum(np.maximum(a, b), c)), limit).astype(np.int64)
    chosen = np.flatnonzero((low <= high).all(axis=1))
    columns, heights, turns = [], [], []
    counts = (high[chosen] - low[chosen] + 1).prod(axis=1)
    for block in blocks(counts, _BLOCK):
        near = chosen[block]
        owner, place = candidates(low[near], high[near])
        which = near[owner]
        pa, pb, pc = (corner[which] - place for corner in (a, b, c))
        wa, wb, wc = _turn(pb, pc), _turn(pc, pa), _turn(pa, pb)
        met = ((wa > 0) & (wb > 0) & (wc > 0)) | ((wa < 0) & (wb < 0) & (wc < 0))
        wa, wb, wc, which, place = wa[met], wb[met], wc[met], which[met], place[met]
        za, zb, zc = surface.vertices[surface.faces[which], 2].T
        columns.append(place[:, 0] * (limit[1] + 1) + place[:, 1])
        heights.append((wa * za + wb * zb + wc * zc) / (wa + wb + wc))
        turns.append(np.sign(wa))
    if not columns:
        return np.zeros(0, np.int64), np.zeros(0), np.zeros(0)
    return np.concatenate(columns), np.concatenate(heights), np.concatenate(turns)


def _turn(a: Floats, b: Floats) -> Floats:
    """Twice the signed area of the triangle of the origin and points (n, 2)."""
    turned: Floats = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return turned
