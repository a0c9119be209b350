"""Which side of a triangle is out: whether a mesh knows it, and telling it where it does not."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Bools = npt.NDArray[np.bool_]
Hashes = npt.NDArray[np.uint64]

_SAMPLE = 16
"""One edge in so many is looked at to learn whether neighbours agree."""

_EXACT_BELOW = 20_000
"""With fewer faces every edge is looked at."""

_DISAGREE = 0.005
"""A share of edges whose two triangles contradict each other, above which they are turned."""


def mixed(a: Ints, b: Ints) -> Hashes:
    """A hash of each pair of numbers (splitmix64, Steele et al., 2014), the same on every run."""
    golden = np.uint64(0x9E3779B97F4A7C15)
    x = a.astype(np.uint64) * golden
    x ^= x >> np.uint64(32)
    x += b.astype(np.uint64)
    x *= golden
    x ^= x >> np.uint64(30)
    x *= np.uint64(0xBF58476D1CE4E5B9)
    x ^= x >> np.uint64(27)
    x *= np.uint64(0x94D049BB133111EB)
    x ^= x >> np.uint64(31)
    return x


def is_closed(faces: Ints) -> bool:
    """Whether every edge is run along as often one way as the other.

    Then, and only then, winding numbers are whole everywhere. No edges are sorted for this: each
    adds its hash, with the sign of its direction, to a sum that is 0 for a closed mesh and for an
    open one with a chance of 2**-64.
    """
    sums = []
    for start, end in ((0, 1), (1, 2), (2, 0)):
        a, b = faces[:, start], faces[:, end]
        hashes = mixed(np.minimum(a, b), np.maximum(a, b))
        sums.append(np.add.reduce(np.where(a < b, hashes, np.negative(hashes))))
    return bool(np.add.reduce(np.array(sums, dtype=np.uint64)) == 0)


def agreeing(faces: Ints) -> bool:
    """Whether triangles that share an edge nearly always agree about which side is out."""
    keys, forward, _ = edges(faces, 1 if len(faces) < _EXACT_BELOW else _SAMPLE)
    pairs = _pairs(keys)
    if len(pairs) == 0:
        return True
    return float(np.mean(forward[pairs] == forward[pairs + 1])) <= _DISAGREE


def oriented(vertices: Floats, faces: Ints) -> Ints:
    """The same triangles, turned so that neighbours agree and each piece encloses its inside.

    Pieces meet only where exactly two triangles share an edge; an edge with more is no guide. A
    hollow inside a piece, being a piece of its own, becomes solid.
    """
    count = len(faces)
    keys, forward, owner = edges(faces)
    pairs = _pairs(keys)
    one, two = owner[pairs], owner[pairs + 1]
    # Consistent neighbours run along their common edge in opposite directions.
    weights = np.where(forward[pairs] == forward[pairs + 1], 2, 1)
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
    flip = np.zeros(count + 1, dtype=np.bool_)
    flip[visit[1:]] = np.asarray(symmetric[visit[1:], parent[visit[1:]]]).ravel() == 2
    # Each face adds up what lies between it and the root, in leaps that double.
    above = np.full(count + 1, count, dtype=np.int64)
    above[visit[1:]] = parent[visit[1:]]
    while np.any(above != count):
        flip ^= flip[above]
        above = above[above]
    turned = faces.copy()
    turned[flip[:-1]] = turned[flip[:-1]][:, ::-1]
    corners = vertices[turned]
    # From each piece's own middle: the volume of one with a hole depends on where one looks from.
    middles = [np.bincount(piece, along) for along in corners.mean(axis=1).T]
    middle = np.stack(middles, axis=1) / np.bincount(piece)[:, None]
    corners -= middle[piece][:, None, :]
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    inverted = np.bincount(piece, weights=volume, minlength=pieces) < 0
    turned[inverted[piece]] = turned[inverted[piece]][:, ::-1]
    return turned


def edges(faces: Ints, one_in: int = 1) -> tuple[Hashes, Bools, Ints]:
    """A key, a direction and the owning face of every edge, or of one in so many; by key."""
    start, end = faces.ravel(), faces[:, [1, 2, 0]].ravel()
    keys = mixed(np.minimum(start, end), np.maximum(start, end))
    forward = start < end
    owner = np.repeat(np.arange(len(faces)), 3)
    if one_in > 1:
        # By the key, so that an edge's two triangles are both chosen or both left.
        chosen = keys % np.uint64(one_in) == 0
        keys, forward, owner = keys[chosen], forward[chosen], owner[chosen]
    order = np.argsort(keys, kind="stable")
    return keys[order], forward[order], owner[order]


def _pairs(keys: Hashes) -> Ints:
    """Where in sorted keys those begin that are there exactly twice."""
    starts = np.flatnonzero(np.r_[True, keys[1:] != keys[:-1]])
    twice: Ints = starts[np.diff(np.r_[starts, len(keys)]) == 2]
    return twice
