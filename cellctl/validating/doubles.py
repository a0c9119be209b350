"""Faces that are there more than once: copies, double-sided sheets, and walls between solids."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cellctl.validating.orientation import Bools, Ints, edges, is_closed, mixed


def without_doubles(faces: Ints) -> Ints:
    """One of each face (m, 3), in their order.

    Copies stay only where a closed mesh needs them: two solids, one in the other, may share a face.
    Two faces on the same three vertices with opposite sides may be the wall between two solids that
    touch, and both stay, for they cancel as they should. Or the mesh is double-sided there, and one
    must go, lest the solid itself be cancelled.
    """
    a, b, c = faces.T
    low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
    whole = mixed(mixed(low, high).astype(np.int64), a + b + c - low - high) & ~np.uint64(1)
    ranked = np.sort(whole)
    if not np.any(ranked[1:] == ranked[:-1]):
        return faces
    # Which of the two cyclic orders: the parity of the permutation that sorts the face.
    sided = whole | ((a > b) ^ (b > c) ^ (a > c)).astype(np.uint64)
    order = np.argsort(sided, kind="stable")
    again = np.zeros(len(faces), dtype=np.bool_)
    again[order[1:]] = sided[order[1:]] == sided[order[:-1]]
    kept = order[~again[order]]
    pairs = np.flatnonzero(whole[kept[1:]] == whole[kept[:-1]])
    if len(pairs):
        pair = np.stack([kept[pairs], kept[pairs + 1]], axis=1)
        rest = np.delete(kept, np.r_[pairs, pairs + 1])
        first, second = pair.min(axis=1), pair.max(axis=1)
        walls = _walls(faces[rest], faces[first])
        kept = np.r_[rest, first, second[walls]]
    once: Ints = faces[np.sort(kept)]
    if again.any() and not is_closed(once):
        copies = np.flatnonzero(again)
        if len(pairs):
            copies = copies[~np.isin(whole[copies], whole[pair[:, 0]])]
        every: Ints = faces[np.sort(np.r_[kept, copies])]
        if is_closed(every):
            return every
    return once


def _walls(rest: Ints, sheet: Ints) -> Bools:
    """Which faces of a sheet that is there with both its sides are walls between solids.

    Each connected patch of it is a wall where it is joined to the rest of the mesh, and the rest is
    at least as closed without it as with it.
    """
    keys, forward, owner = edges(np.concatenate([sheet, rest]))
    starts = np.flatnonzero(np.r_[True, keys[1:] != keys[:-1]])
    edge = np.repeat(np.arange(len(starts)), np.diff(np.r_[starts, len(keys)]))
    count = len(starts)
    step = np.where(forward, 1, -1)
    of_sheet = owner < len(sheet)
    bare = np.bincount(edge[~of_sheet], step[~of_sheet], count)
    covered = np.bincount(edge, step, count)
    joined = np.bincount(edge[~of_sheet], minlength=count) > 0
    # Patches: faces and edges are the nodes of a graph.
    face, side = owner[of_sheet], edge[of_sheet]
    nodes = len(sheet) + count
    graph = coo_array((np.ones(len(face)), (face, len(sheet) + side)), shape=(nodes, nodes))
    patches, patch = connected_components(graph.tocsr(), directed=False)
    of_edge = patch[len(sheet) :]
    gain = np.bincount(of_edge, (covered != 0).astype(float) - (bare != 0), patches)
    held = np.bincount(of_edge, joined, patches) > 0
    walls: Bools = (held & (gain >= 0))[patch[: len(sheet)]]
    return walls
