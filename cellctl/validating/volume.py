"""How much of each cell a surface encloses, exactly, by the divergence theorem.

The surface is cut along the planes between cells. Above a point, the enclosed length of a vertical
line is a sum over the pieces that the line crosses, each with the sign of its side; integrated over
a cell's floor, each piece adds its projected area times its height, and the whole area to every
cell beneath it. A closed surface gives the same from all six directions, to rounding. One with
holes does not; the middle of the six is then what most of it says.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cellctl.validating.clean import Surface
from cellctl.validating.orientation import Floats

_BLOCK = 100_000
"""Most triangles that are cut at once; bounds the memory."""


class Contents(NamedTuple):
    """What a surface has to do with each cell; both (nx, ny, nz)."""

    volume: Floats
    """Enclosed volume, in cells; where the surface winds twice, twice."""
    area: Floats
    """Of the surface in the cell, in faces of a cell."""


def contents(surface: Surface, size: tuple[int, int, int]) -> Contents:
    """Enclosed volume and surface of each cell of a grid of that size.

    What reaches beyond the grid counts as in its outermost cells.
    """
    count = size[0] * size[1] * size[2]
    # Along each axis: projected area, and the same times the height within the cell.
    areas, moments = np.zeros((3, count)), np.zeros((3, count))
    surfaces = np.zeros(count)
    for start in range(0, len(surface.faces), _BLOCK):
        pieces = _cut(surface.vertices[surface.faces[start : start + _BLOCK]])
        a, b, c = pieces[:, 0], pieces[:, 1], pieces[:, 2]
        centre = (a + b + c) / 3.0
        normal = 0.5 * np.cross(b - a, c - a)
        cell = np.clip(np.floor(centre), 0, np.array(size) - 1)
        within = np.clip(centre - cell, 0.0, 1.0)
        key = np.ravel_multi_index(tuple(cell.astype(np.int64).T), size)
        surfaces += np.bincount(key, np.sqrt(np.einsum("ij,ij->i", normal, normal)), count)
        for axis in range(3):
            areas[axis] += np.bincount(key, normal[:, axis], count)
            moments[axis] += np.bincount(key, normal[:, axis] * within[:, axis], count)
    sides = []
    for axis in range(3):
        area, moment = areas[axis].reshape(size), moments[axis].reshape(size)
        upto = np.cumsum(area, axis=axis)
        whole = np.take(upto, [-1], axis=axis)
        sides.append(moment + whole - upto)
        sides.append(moment - upto)
    volume: Floats = np.median(np.stack(sides), axis=0)
    return Contents(volume, surfaces.reshape(size))


def _cut(triangles: Floats) -> Floats:
    """The same surface in triangles none of which crosses a plane between cells."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    across = np.any(np.ceil(high) - np.floor(low) > 1, axis=1)
    done, crossing = [triangles[~across]], triangles[across]
    for axis in range(3):
        settled = []
        while len(crossing):
            along = crossing[:, :, axis]
            least, most = along.min(axis=1), along.max(axis=1)
            low, high = np.floor(least), np.ceil(most)
            wide = high - low > 1
            settled.append(crossing[~wide])
            plane = np.clip(np.rint((least + most) / 2), low + 1, high - 1)[wide]
            crossing = _halves(crossing[wide], axis, plane)
        crossing = np.concatenate(settled) if settled else crossing
    return np.concatenate([*done, crossing])


def _halves(triangles: Floats, axis: int, plane: Floats) -> Floats:
    """Triangles (n, 3, 3), each cut in three at its plane (n,), which lies between its corners."""
    above = triangles[:, :, axis] >= plane[:, None]
    # One corner is alone on its side; it becomes the first, in the same cyclic order.
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), above.argmin(axis=1))
    order = (alone[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(triangles, order[:, :, None], axis=1).transpose(1, 0, 2)
    cuts = []
    for other in (b, c):
        share = (plane - a[:, axis]) / (other[:, axis] - a[:, axis])
        cut = a + share[:, None] * (other - a)
        cut[:, axis] = plane
        cuts.append(cut)
    ab, ac = cuts
    return np.concatenate(
        [np.stack(corners, axis=1) for corners in ((a, ab, ac), (ab, b, c), (ab, c, ac))]
    )
