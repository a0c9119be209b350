"""Inside or outside, also for surfaces with holes: the generalised winding number.

Jacobson, Kavan and Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding
numbers", 2013; far triangles are summed as dipoles after Barill et al., 2018.
"""

from __future__ import annotations

import numpy as np

from cellctl.validating.clean import Surface
from cellctl.validating.orientation import Floats

_FINE = 4
"""Triangles smaller than a cell's edge divided by this are summed in groups of that size. A point
asked about is the centre of a cell that the surface does not meet, two such groups away: numbers
are then right to 0.01."""

_EXACT_BELOW = 1_000
"""Fewer triangles than this are not worth grouping."""

_BLOCK = 50_000
"""Most point-triangle pairs at once: what fits a processor's cache."""


def winding_numbers(surface: Surface, points: Floats) -> Floats:
    """How often the surface winds around each point (k, 3): 1 inside a closed outward one."""
    triangles = surface.triangles
    numbers = np.zeros(len(points))
    if len(triangles) >= _EXACT_BELOW:
        small = np.ptp(triangles, axis=1).max(axis=1) < 1.0 / _FINE
        numbers += _dipoles(triangles[small], points)
        triangles = triangles[~small]
    step = max(1, _BLOCK // max(1, len(points)))
    for start in range(0, len(triangles), step):
        numbers += _solid_angles(triangles[start : start + step], points)
    return numbers


def _solid_angles(triangles: Floats, points: Floats) -> Floats:
    """Exact sum over triangles, after Van Oosterom and Strackee, 1983.

    Products of the offsets from a point are expanded, so that each is a product of matrices.
    """
    square = np.einsum("ij,ij->i", points, points)[:, None]
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    la, lb, lc = (np.sqrt(np.maximum(_dot(side, side, points, square), 0.0)) for side in (a, b, c))
    around = np.cross(a, b) + np.cross(b, c) + np.cross(c, a)
    top = np.einsum("ij,ij->i", a, np.cross(b, c)) - points @ around.T
    bottom = (
        la * lb * lc
        + _dot(a, b, points, square) * lc
        + _dot(b, c, points, square) * la
        + _dot(c, a, points, square) * lb
    )
    numbers: Floats = np.arctan2(top, bottom).sum(axis=1) / (2.0 * np.pi)
    return numbers


def _dot(a: Floats, b: Floats, points: Floats, square: Floats) -> Floats:
    """(a - p) . (b - p) for every point p (k, 3) and pair of a and b (n, 3): (k, n)."""
    dot: Floats = square - points @ (a + b).T + np.einsum("ij,ij->i", a, b)
    return dot


def _dipoles(triangles: Floats, points: Floats) -> Floats:
    """The sum over small triangles, grouped by where they are."""
    numbers = np.zeros(len(points))
    if len(triangles) == 0:
        return numbers
    normals = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    centres = triangles.mean(axis=1)
    where = np.floor(centres * _FINE).astype(np.int64)
    where -= where.min(axis=0)
    spans = where.max(axis=0) + 1
    cell = (where[:, 0] * spans[1] + where[:, 1]) * spans[2] + where[:, 2]
    # An area of 0 would leave a group without a centre; such triangles add nothing.
    weight = np.maximum(areas, 1e-30)
    total = np.bincount(cell, weight)
    there = np.flatnonzero(total)
    normal = np.stack([np.bincount(cell, normals[:, i])[there] for i in range(3)])
    moment = np.stack([np.bincount(cell, centres[:, i] * weight)[there] for i in range(3)])
    centre = moment / total[there]
    along, square = (centre * normal).sum(axis=0), (centre * centre).sum(axis=0)
    own = np.einsum("ij,ij->i", points, points)[:, None]
    step = max(1, _BLOCK // len(points))
    for start in range(0, len(there), step):
        part = slice(start, start + step)
        distance = np.maximum(own - 2.0 * (points @ centre[:, part]) + square[part], 1e-12)
        flux = along[part] - points @ normal[:, part]
        numbers += (flux / (distance * np.sqrt(distance))).sum(axis=1)
    return numbers / (4.0 * np.pi)
