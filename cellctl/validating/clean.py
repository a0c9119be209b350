"""A surface that geometry can be asked of, from whatever a generator returned."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from cellctl.errors import PlanError

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]

MOST_TRIANGLES = 5_000_000
"""Above this no mesh is worth the memory at the resolution of a cell."""


class Surface(NamedTuple):
    """Triangles: vertices (n, 3) and indices into them (m, 3)."""

    vertices: Floats
    faces: Ints

    @property
    def triangles(self) -> Floats:
        """Corners of every triangle, (m, 3, 3)."""
        return self.vertices[self.faces]


def clean(vertices: Floats, faces: Ints) -> Surface:
    """Weld vertices (n, 3); drop faces (m, 3) that are not finite, degenerate or there twice.

    Raises:
        PlanError: there is no usable face, or there are too many.
    """
    if len(faces) == 0:
        raise PlanError("The shape is empty: its mesh has no face.", "Ask again, or otherwise.")
    if len(faces) > MOST_TRIANGLES:
        raise PlanError(
            f"The mesh has {len(faces)} triangles; at most {MOST_TRIANGLES} can be planned.",
            "Simplify it first.",
        )
    inside = np.all((faces >= 0) & (faces < len(vertices)), axis=1)
    faces = faces[inside]
    finite = np.isfinite(vertices).min(axis=1)
    faces = faces[finite[faces].all(axis=1)]
    if len(faces) == 0:
        raise PlanError(
            "The shape is empty: no face of its mesh has finite coordinates.",
            "Ask again, or otherwise.",
        )
    used, index = np.unique(faces, return_inverse=True)
    vertices, faces = vertices[used], index.reshape(-1, 3)
    vertices, faces = _weld(vertices, faces)
    degenerate = (
        (faces[:, 0] == faces[:, 1]) | (faces[:, 1] == faces[:, 2]) | (faces[:, 2] == faces[:, 0])
    )
    faces = faces[~degenerate]
    _, first = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)
    faces = faces[np.sort(first)]
    if len(faces) == 0:
        raise PlanError(
            "The shape is a single point or line: no face of its mesh has an area.",
            "Ask again, or otherwise.",
        )
    used, index = np.unique(faces, return_inverse=True)
    return Surface(vertices[used], index.reshape(-1, 3))


def _weld(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Merge vertices that agree to a millionth of the shape's extent."""
    low = vertices.min(axis=0)
    extent = float((vertices.max(axis=0) - low).max())
    if not extent > 0.0:
        raise PlanError("The shape is a single point.", "Ask again, or otherwise.")
    # Not np.unique over rows: sorting three keys is many times faster than sorting records.
    grid = np.round((vertices - low) / (extent * 1e-6)).astype(np.int64)
    order = np.lexsort(grid.T)
    ranked = grid[order]
    new = np.ones(len(ranked), dtype=np.bool_)
    new[1:] = np.any(ranked[1:] != ranked[:-1], axis=1)
    merged = np.empty(len(vertices), dtype=np.int64)
    merged[order] = np.cumsum(new) - 1
    return vertices[order[new]], merged[faces]


def oriented(surface: Surface) -> Surface:
    """The same triangles, turned so that neighbours agree and each piece encloses its inside.

    Pieces meet only where exactly two triangles share an edge; an edge with more is no guide.
    """
    faces = surface.faces
    count = len(faces)
    edges = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    owner = np.repeat(np.arange(count), 3)
    forward = edges[:, 0] < edges[:, 1]
    key = np.sort(edges, axis=1)
    order = np.lexsort((key[:, 1], key[:, 0]))
    key, owner, forward = key[order], owner[order], forward[order]
    starts = np.flatnonzero(np.r_[True, np.any(key[1:] != key[:-1], axis=1)])
    pairs = starts[np.diff(np.r_[starts, len(key)]) == 2]
    one, two = owner[pairs], owner[pairs + 1]
    # Consistent neighbours run along their common edge in opposite directions.
    disagree = forward[pairs] == forward[pairs + 1]
    weights = np.where(disagree, 2, 1)
    adjacency = coo_array((weights, (one, two)), shape=(count, count)).tocsr()
    pieces, piece = connected_components(adjacency, directed=False)
    # A root that touches one triangle of every piece lets one search visit them all.
    roots = np.unique(piece, return_index=True)[1]
    rows = np.r_[one, np.full(pieces, count)]
    columns = np.r_[two, roots]
    rooted = coo_array(
        (np.r_[weights, np.ones(pieces, dtype=np.int64)], (rows, columns)),
        shape=(count + 1, count + 1),
    ).tocsr()
    symmetric = rooted + rooted.T
    visit, parent = breadth_first_order(symmetric, count, directed=False)
    between = np.asarray(symmetric[visit[1:], parent[visit[1:]]]).ravel()
    flip = np.zeros(count + 1, dtype=np.bool_)
    for face, above, weight in zip(
        visit[1:].tolist(), parent[visit[1:]].tolist(), between.tolist(), strict=True
    ):
        flip[face] = flip[above] ^ (weight == 2)
    turned = faces.copy()
    turned[flip[:-1]] = turned[flip[:-1]][:, ::-1]
    corners = surface.vertices[turned]
    centred = corners - surface.vertices.mean(axis=0)
    volume = np.einsum("ij,ij->i", centred[:, 0], np.cross(centred[:, 1], centred[:, 2]))
    inverted = np.bincount(piece, weights=volume, minlength=pieces) < 0
    turned[inverted[piece]] = turned[inverted[piece]][:, ::-1]
    return Surface(surface.vertices, turned)
