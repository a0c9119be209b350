"""Simple solids and their mesh: what a description of parts consists of."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from cellctl.description import (
    BoxPart,
    CapsulePart,
    ConePart,
    CylinderPart,
    EllipsoidPart,
    PartsDescription,
    PrismPart,
    RingPart,
    SpherePart,
)

if TYPE_CHECKING:
    from cellctl.description import Part

_SECTIONS = 24
"""Sides of what is round: off by less than a hundredth of its radius."""


def mesh_of_parts(
    description: PartsDescription,
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Vertices (n, 3) in metres and faces (m, 3): a closed, outward mesh for each part."""
    vertices, faces, count = [], [], 0
    for part in description.parts:
        solid = _solid(part)
        turned = np.asarray(solid.vertices) @ _turn(part.turned_deg).T + np.array(part.at_m)
        vertices.append(turned)
        faces.append(np.asarray(solid.faces, dtype=np.int64) + count)
        count += len(turned)
    return np.vstack(vertices), np.vstack(faces)


def _solid(part: Part) -> Any:  # noqa: PLR0911 - one way out a shape
    """A part about the origin, upright: a trimesh."""
    from trimesh import creation  # noqa: PLC0415 - takes a second to load, and few need it

    match part:
        case BoxPart():
            return creation.box(extents=part.size_m)
        case SpherePart():
            return creation.icosphere(subdivisions=2, radius=part.radius_m)
        case EllipsoidPart():
            ball = creation.icosphere(subdivisions=2, radius=0.5)
            ball.apply_scale(part.size_m)
            return ball
        case CylinderPart():
            return creation.cylinder(radius=part.radius_m, height=part.height_m, sections=_SECTIONS)
        case ConePart():
            half = part.height_m / 2
            outline = [(0.0, -half), (part.radius_m, -half), (part.top_radius_m, half)]
            if part.top_radius_m > 0.0:
                outline.append((0.0, half))
            return creation.revolve(np.array(outline), sections=_SECTIONS)
        case CapsulePart():
            straight = max(1e-6, part.height_m - 2 * part.radius_m)
            capsule = creation.capsule(
                radius=part.radius_m, height=straight, count=(_SECTIONS, _SECTIONS)
            )
            capsule.apply_translation(-capsule.bounds.mean(axis=0))
            return capsule
        case PrismPart():
            return _prism(part)
        case RingPart():
            return creation.torus(
                major_radius=part.radius_m,
                minor_radius=part.thickness_m / 2,
                major_sections=_SECTIONS,
                minor_sections=_SECTIONS // 2,
            )


def _prism(part: PrismPart) -> Any:
    from trimesh import Trimesh  # noqa: PLC0415 - as above

    x, y, z = (edge / 2 for edge in part.size_m)
    ends = [[(-x, at, -z), (x, at, -z), (0.0, at, z)] for at in (-y, y)]
    faces = [(0, 1, 2), (3, 5, 4), (0, 3, 4), (0, 4, 1), (1, 4, 5), (1, 5, 2), (2, 5, 3), (2, 3, 0)]
    return Trimesh(vertices=ends[0] + ends[1], faces=faces, process=False)


def _turn(degrees: tuple[float, float, float]) -> npt.NDArray[np.float64]:
    """The rotation about x, then y, then z, all fixed axes."""
    turn = np.eye(3)
    for axis, angle in enumerate(degrees):
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        a, b = [i for i in range(3) if i != axis]
        step = np.eye(3)
        step[a, a] = step[b, b] = c
        sign = -1.0 if axis == 1 else 1.0
        step[a, b], step[b, a] = -sign * s, sign * s
        turn = step @ turn
    return turn
