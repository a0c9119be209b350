"""What a tilted box has in common with each cell, by half-spaces and vertex enumeration alone."""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from cellctl.assembly import Cell
from cellctl.generating.boxes import Box, mesh_of
from cellctl.validating.clean import Surface
from cellctl.validating.orientation import Floats


class Tilted(NamedTuple):
    """A box with any attitude, moved so that its bounding box begins at the origin."""

    edges: Floats
    turn: Floats

    @property
    def centre(self) -> Floats:
        middle: Floats = np.abs(self.turn) @ self.edges / 2.0
        return middle

    @property
    def surface(self) -> Surface:
        vertices, faces = mesh_of((Box(0, 0, 0, *self.edges.tolist()),), 1.0)
        return Surface((vertices - self.edges / 2.0) @ self.turn.T + self.centre, faces)

    def volumes(self, shrunk: float = 0.0) -> dict[Cell, float]:
        """Its volume in every cell (in cells), or in what is left of it when it is shrunk."""
        normals = np.concatenate([self.turn.T, -self.turn.T, np.eye(3), -np.eye(3)])
        triples = np.array(list(itertools.combinations(range(12), 3)))
        planes = normals[triples]
        meets = np.abs(np.linalg.det(planes)) > 1e-9
        triples, inverses = triples[meets], np.linalg.inv(planes[meets])
        out = normals[:6] @ self.centre + np.tile(self.edges / 2.0, 2)
        found = {}
        for index in np.ndindex(*np.ceil(2 * self.centre).astype(int).tolist()):
            low = np.array(index, dtype=np.float64)
            offsets = np.concatenate([out, low + 1 - shrunk, -low - shrunk])
            corners = np.einsum("ijk,ik->ij", inverses, offsets[triples])
            within = corners[np.all(corners @ normals.T <= offsets + 1e-9, axis=1)]
            found[Cell(*index)] = _volume(within)
        return found


def tilted(edges: list[float], angles: list[float]) -> Tilted:
    """A box of these edges, turned about x, y and z by these degrees."""
    turn = Rotation.from_euler("xyz", angles, degrees=True).as_matrix()
    return Tilted(np.array(edges), turn)


def _volume(corners: Floats) -> float:
    if len(corners) < 4:
        return 0.0
    try:
        return float(ConvexHull(corners).volume)
    except QhullError:  # flat
        return 0.0
