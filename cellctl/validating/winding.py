"""Inside or outside, also for surfaces with holes: the generalised winding number.

Jacobson, Kavan and Sorkine-Hornung, "Robust inside-outside segmentation using generalized winding
numbers", 2013; far triangles are summed as dipoles after Barill et al., 2018.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cellctl.validating.clean import Surface, oriented

Floats = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

_FINE = 8
"""Triangles smaller than a cell's edge divided by this are summed in groups of that size. A point
asked about is the centre of a cell that the surface does not meet, four such groups away."""

_EXACT_BELOW = 4_000
"""Fewer triangles than this are not worth grouping."""

_BLOCK = 2_000_000
"""Most point-triangle pairs at once; bounds the memory."""


def inside(surface: Surface, points: Floats) -> Bools:
    """Which points (k, 3) the surface encloses; triangles may be turned inside out.

    Where the numbers are ambiguous because neighbouring triangles disagree, they are turned to
    agree first.
    """
    numbers = np.abs(winding_numbers(surface, points))
    ambiguous = (numbers > 0.15) & (numbers < 0.85)
    if ambiguous.any():
        numbers = np.abs(winding_numbers(oriented(surface), points))
    verdict: Bools = numbers > 0.5
    return verdict


def winding_numbers(surface: Surface, points: Floats) -> Floats:
    """How often the surface winds around each point: 1 inside a closed outward one, 0 outside."""
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
    """Exact sum over triangles, after Van Oosterom and Strackee, 1983."""
    a, b, c = (triangles[:, i][None] - points[:, None] for i in range(3))
    la, lb, lc = (np.linalg.norm(side, axis=2) for side in (a, b, c))
    top = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
    bottom = (
        la * lb * lc
        + np.einsum("ijk,ijk->ij", a, b) * lc
        + np.einsum("ijk,ijk->ij", b, c) * la
        + np.einsum("ijk,ijk->ij", c, a) * lb
    )
    numbers: Floats = np.arctan2(top, bottom).sum(axis=1) / (2.0 * np.pi)
    return numbers


def _dipoles(triangles: Floats, points: Floats) -> Floats:
    """The sum over small triangles, grouped by where they are."""
    if len(triangles) == 0:
        return np.zeros(len(points))
    normals = 0.5 * np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    centres = triangles.mean(axis=1)
    where = np.floor(centres * _FINE).astype(np.int64)
    where -= where.min(axis=0)
    spans = where.max(axis=0) + 1
    _, group = np.unique(
        (where[:, 0] * spans[1] + where[:, 1]) * spans[2] + where[:, 2], return_inverse=True
    )
    count = int(group.max()) + 1
    # An area of 0 would leave a group without a centre; such triangles add nothing.
    weight = np.maximum(areas, 1e-30)
    total = np.bincount(group, weight, count)
    summed = [np.bincount(group, normals[:, i], count) for i in range(3)]
    moment = [np.bincount(group, centres[:, i] * weight, count) / total for i in range(3)]
    normal, centre = np.stack(summed, axis=1), np.stack(moment, axis=1)
    numbers = np.zeros(len(points))
    step = max(1, _BLOCK // len(points))
    for start in range(0, count, step):
        offset = centre[None, start : start + step] - points[:, None]
        cubed = np.linalg.norm(offset, axis=2) ** 3
        numbers += (np.einsum("ijk,jk->ij", offset, normal[start : start + step]) / cubed).sum(
            axis=1
        )
    return numbers / (4.0 * np.pi)
