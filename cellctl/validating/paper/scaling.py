"""Algorithm 1 (Component Discretization) up to its grid, and how algorithms 2 and 3 scale down.

As printed, algorithm 1 lays its grid over the bounding box from before the scaling; here the grid
covers the scaled shape, as the text of section 3.2 has it. ``Intersect`` is
``cellctl.validating.discretise``.

*Uniformly scales down by one component size* (algorithm 2) takes one cell off every axis, and
``Scale1D`` (algorithm 3) one cell off its axis. A ratio that is the same for all axes would keep
the proportions, but it does not give the paper's own figures (60 parts would become 57 and then
24). An axis that is a single cell long, or shorter, keeps its length: the printed loops would drive
a flat shape to no thickness at all, and on.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from cellctl.assembly import Cell, Change
from cellctl.errors import PlanError
from cellctl.validating.clean import Surface
from cellctl.validating.discretise import discretise
from cellctl.validating.fit import Shape
from cellctl.validating.rules import Cells, size_of
from cellctl.validating.rules import to_corner as moved_to_corner
from cellctl.validating.words import times


@dataclass(frozen=True)
class Rescaled:
    """A shape, the cells that it occupies, and what was done to it to get there."""

    shape: Shape
    cells: Cells
    changes: tuple[Change, ...] = ()


def scale_to_fit(surface: Surface, grid: tuple[int, int, int]) -> Shape:
    """Algorithm 1, ``ScaleToFit``: uniformly, until the shape fills the assembly space.

    Args:
        surface: in any unit; with an extent along at least one axis.
        grid: cells of the assembly space along x, y and z.
    """
    low = surface.vertices.min(axis=0)
    extent = surface.vertices.max(axis=0) - low
    long = extent > 0.0
    scale = float((np.array(grid)[long] / extent[long]).min())
    return Shape(Surface((surface.vertices - low) * scale, surface.faces))


def one_cell_smaller(shape: Shape, axes: Iterable[int]) -> Shape:
    """``Scale`` (all three axes) and ``Scale1D`` (one of them) of algorithms 2 and 3.

    Raises:
        PlanError: the shape is a single cell along each of those axes already.
    """
    extent = shape.extent
    factors = np.ones(3)
    for axis in axes:
        if extent[axis] > 1.0:
            factors[axis] = max(extent[axis] - 1.0, 1.0) / extent[axis]
    if np.all(factors == 1.0):
        raise PlanError(
            "The rescaling of the Speech-to-Reality paper ends here: the shape is one part thin, "
            "and cannot lose a part.",
            "Ask for another shape.",
        )
    return Shape(Surface(shape.surface.vertices * factors, shape.surface.faces), shape.pitch_m)


def occupy(shape: Shape) -> Rescaled:
    """Algorithm 1, ``Discretize`` and ``Intersect``: the cells of a shape as it is.

    Raises:
        PlanError: it occupies none.
    """
    return Rescaled(shape, to_corner(discretise(shape)))


def to_corner(cells: Iterable[Cell]) -> Cells:
    """The same cells from [0, 0, 0] on.

    Raises:
        PlanError: there are none.
    """
    found = frozenset(cells)
    if not found:
        raise PlanError("There are no cells to build.", "Name at least one cell.")
    return moved_to_corner(found)


def resized(before: Cells, after: Rescaled, why: str) -> Rescaled:
    """The outcome of a rescaling with its change put in words, behind those from before it."""
    old, new = (times(size_of(cells)) for cells in (before, after.cells))
    what = f"It is {new} parts large instead of {old} (wide, deep, high)."
    return Rescaled(after.shape, after.cells, (*after.changes, Change(what=what, why=why)))
