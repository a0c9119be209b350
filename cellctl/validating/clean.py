"""A surface that geometry can be asked of, from whatever a generator returned."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cellctl.errors import PlanError
from cellctl.validating.doubles import without_doubles
from cellctl.validating.orientation import Floats, Ints, agreeing, is_closed, oriented

MOST_TRIANGLES = 5_000_000
"""Above this no mesh is worth the memory at the resolution of a cell."""

LARGEST_COORDINATE = 1e9
"""Beyond this, in whatever unit, a coordinate is an error and no place."""

_WELD = 1e-6
"""Vertices closer than this part of the shape's extent are one. Three such numbers fit one key of
63 bits."""


class Surface(NamedTuple):
    """Triangles: vertices (n, 3), each used by some triangle, and indices into them (m, 3)."""

    vertices: Floats
    faces: Ints

    @property
    def triangles(self) -> Floats:
        """Corners of every triangle, (m, 3, 3)."""
        return self.vertices[self.faces]


def clean(vertices: Floats, faces: Ints) -> Surface:
    """Weld vertices (n, 3); drop faces (m, 3) that are not finite, degenerate or there twice.

    Where neighbours contradict each other about which side is out, they are turned to agree.

    Raises:
        PlanError: there is no usable face, there are too many, or they lie absurdly far out.
    """
    if len(faces) == 0:
        raise PlanError("The shape is empty: its mesh has no face.", "Ask again, or otherwise.")
    if len(faces) > MOST_TRIANGLES:
        raise PlanError(
            f"The mesh has {len(faces)} triangles; at most {MOST_TRIANGLES} can be planned.",
            "Simplify it first.",
        )
    there = np.all((faces >= 0) & (faces < len(vertices)), axis=1)
    faces = faces[there]
    finite = np.isfinite(vertices).min(axis=1)
    faces = faces[np.all(finite[faces], axis=1)]
    if len(faces) == 0:
        raise PlanError(
            "The shape is empty: no face of its mesh has finite coordinates.",
            "Ask again, or otherwise.",
        )
    vertices, faces = _used(vertices, faces)
    farthest = float(np.abs(vertices).max())
    if farthest > LARGEST_COORDINATE:
        raise PlanError(
            f"The shape is absurdly large: its mesh has a coordinate of {farthest:.3g}.",
            "Check the file, or ask again.",
        )
    vertices, faces = _weld(vertices, faces)
    degenerate = (
        (faces[:, 0] == faces[:, 1]) | (faces[:, 1] == faces[:, 2]) | (faces[:, 2] == faces[:, 0])
    )
    if degenerate.any():
        faces = faces[~degenerate]
    if len(faces) == 0:
        raise PlanError(
            "The shape is a single point or line: no face of its mesh has an area.",
            "Ask again, or otherwise.",
        )
    faces = without_doubles(faces)
    vertices, faces = _used(vertices, faces)
    if not is_closed(faces) and not agreeing(faces):
        faces = oriented(vertices, faces)
    return Surface(vertices, faces)


def _used(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Without the vertices that no face has."""
    used = np.zeros(len(vertices), dtype=np.bool_)
    used[faces] = True
    if used.all():
        return vertices, faces
    return vertices[used], (np.cumsum(used) - 1)[faces]


def _weld(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Merge vertices that agree to ``_WELD`` of the shape's extent."""
    low = vertices.min(axis=0)
    extent = float((vertices.max(axis=0) - low).max())
    if not extent > 1.0 / LARGEST_COORDINATE:
        raise PlanError("The shape is a single point.", "Ask again, or otherwise.")
    grid = np.round((vertices - low) / (extent * _WELD)).astype(np.int64)
    # One key a vertex: sorting it is many times faster than sorting records.
    key = (grid[:, 0] << 42) | (grid[:, 1] << 21) | grid[:, 2]
    order = np.argsort(key, kind="stable")
    ranked = key[order]
    new = np.ones(len(ranked), dtype=np.bool_)
    new[1:] = ranked[1:] != ranked[:-1]
    if new.all():
        return vertices, faces
    merged = np.empty(len(vertices), dtype=np.int64)
    merged[order] = np.cumsum(new) - 1
    return vertices[order[new]], merged[faces]
