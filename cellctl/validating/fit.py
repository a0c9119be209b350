"""How large the object will be: from a generator's mesh to a shape measured in cells."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Change
from cellctl.config import CellConfig
from cellctl.errors import PlanError
from cellctl.mesh import GeneratedMesh
from cellctl.validating.clean import Surface, clean

Floats = npt.NDArray[np.float64]

TOLERANCE_M = 0.0006
"""A shape that reaches no more than this into a cell does not occupy it: half a millimetre, and
what a mesh of a metre in single precision is inexact by."""

AXES = ("width", "depth", "height")
"""Names of x, y and z, as people call an object's extents."""

FLAT = 1e-5
"""A shape thinner than this part of its longest side has no inside and no thickness."""

LARGEST_M = 1000.0
"""A metric shape beyond this is no object but an error of units."""


@dataclass(frozen=True)
class Shape:
    """A surface measured in cells, its minimum corner at the origin."""

    surface: Surface
    pitch_m: float = 0.1
    """The edge of a cell."""

    @property
    def tolerance(self) -> float:
        """``TOLERANCE_M`` in cells."""
        return TOLERANCE_M / self.pitch_m

    @property
    def extent(self) -> Floats:
        """Width, depth and height in cells."""
        extent: Floats = self.surface.vertices.max(axis=0)
        return extent

    def rescaled(self, extent: Floats) -> Shape:
        """The same shape with other extents, stretched axis by axis."""
        factors = extent / self.extent
        return Shape(Surface(self.surface.vertices * factors, self.surface.faces), self.pitch_m)


@dataclass(frozen=True)
class Fitted:
    """The shape at the size at which it will be built, and what that size cost."""

    shape: Shape
    changes: tuple[Change, ...]


def centimetres(length_m: float) -> str:
    """``60 cm``, ``12.5 cm``."""
    return f"{round(length_m * 100, 1):g} cm"


def fit(generated: GeneratedMesh, config: CellConfig) -> Fitted:
    """Scale a mesh to the building space where it must be, and only then.

    A metric mesh keeps its size unless it is too large. A mesh without a unit takes the size that
    was stated for it, else it fills the building space.

    Raises:
        PlanError: nothing there to build: empty, flat, tiny, not finite, or absurdly large.
    """
    surface = clean(generated.vertices, generated.faces)
    low = surface.vertices.min(axis=0)
    extent = surface.vertices.max(axis=0) - low
    if generated.metric and extent.max() > LARGEST_M:
        raise PlanError(
            f"The shape is {extent.max():.3g} m across; that is no size for an object.",
            "Check its unit: vertices are read as metres.",
        )
    if extent.min() <= FLAT * extent.max():
        raise PlanError(
            "The shape is flat: it has no thickness along "
            f"{' and '.join(AXES[i] for i in np.flatnonzero(extent <= FLAT * extent.max()))}.",
            "A shape to build needs a width, a depth and a height.",
        )
    pitch_m = config.voxel.pitch_m
    space_m = np.array(config.grid, dtype=np.float64) * pitch_m
    if generated.metric:
        scale = 1.0
        if extent.max() < pitch_m / 2:
            raise PlanError(
                f"The shape is {centimetres(float(extent.max()))} across, "
                f"less than half a part ({centimetres(pitch_m)}).",
                "Ask for a larger one.",
            )
    else:
        scale = _unitless_scale(generated, extent, space_m, config)
    most = float((space_m / extent).min())
    changes: list[Change] = []
    if not generated.metric and not generated.stated_dimensions_m:
        changes.append(
            Change(
                what=f"It is {centimetres(float(extent[2] * scale))} high.",
                why="Its mesh has no unit, and no size was asked for, so it fills the building "
                f"space of {_space(space_m)}.",
            )
        )
    # What fills no further cell is not too large.
    if np.any(extent * scale > space_m + TOLERANCE_M):
        before, after = (centimetres(float(extent[2] * s)) for s in (scale, most))
        changes.append(
            Change(
                what=f"It is {most / scale:.0%} of its size: {after} high instead of {before}.",
                why=f"The building space is {_space(space_m)}.",
            )
        )
        scale = most
    vertices = (surface.vertices - low) * (scale / pitch_m)
    return Fitted(Shape(Surface(vertices, surface.faces), pitch_m), tuple(changes))


def _unitless_scale(
    generated: GeneratedMesh, extent: Floats, space_m: Floats, config: CellConfig
) -> float:
    """Metres per unit of a mesh that has no unit."""
    for axis in (2, 0, 1):
        stated_m = generated.stated_dimensions_m.get(AXES[axis])
        if stated_m is not None:
            return float(stated_m / extent[axis])
    if not config.planning.scale_unitless_to_workspace:
        raise PlanError(
            "The shape has no size: its mesh has no unit, and no size was asked for.",
            "Say how high it should be, or set planning.scale_unitless_to_workspace.",
        )
    return float((space_m / extent).min())


def size_questions(
    stated_m: dict[str, float], size_cells: tuple[int, int, int], pitch_m: float
) -> tuple[str, ...]:
    """What to ask about where the outcome misses a stated size by more than half a part."""
    questions = []
    for axis, name in enumerate(AXES):
        stated = stated_m.get(name)
        built = size_cells[axis] * pitch_m
        if stated is not None and abs(built - stated) > pitch_m / 2 + 1e-9:
            questions.append(
                f"You asked for a {name} of {centimetres(stated)}; what I can build here has "
                f"{centimetres(built)}."
            )
    return tuple(questions)


def size_changes(
    stated_m: dict[str, float], size_cells: tuple[int, int, int], pitch_m: float
) -> tuple[Change, ...]:
    """What to say where a stated size had to be rounded to whole parts."""
    changes = []
    for axis, name in enumerate(AXES):
        stated = stated_m.get(name)
        built = size_cells[axis] * pitch_m
        if stated is not None and 1e-6 < abs(built - stated) <= pitch_m / 2 + 1e-9:
            changes.append(
                Change(
                    what=f"Its {name} is {centimetres(built)} instead of {centimetres(stated)}.",
                    why=f"Parts are cubes of {centimetres(pitch_m)}.",
                )
            )
    return tuple(changes)


def _space(space_m: Floats) -> str:
    return " x ".join(f"{edge * 100:.3g}" for edge in space_m) + " cm"
