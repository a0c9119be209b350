"""In which ways a shape is symmetric about something vertical, and what that ties together."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from cellctl.assembly import Cell
from cellctl.validating.repairing.score import Size
from cellctl.validating.rules import Cells


class Symmetry(NamedTuple):
    """A movement that maps a shape's box to itself."""

    name: str
    square: bool
    """Whether it needs a box that is as wide as it is deep."""
    moved: Callable[[Cell, Size], Cell]


def _mirror_x(cell: Cell, size: Size) -> Cell:
    return Cell(size[0] - 1 - cell.x, cell.y, cell.z)


def _mirror_y(cell: Cell, size: Size) -> Cell:
    return Cell(cell.x, size[1] - 1 - cell.y, cell.z)


def _half_turn(cell: Cell, size: Size) -> Cell:
    return Cell(size[0] - 1 - cell.x, size[1] - 1 - cell.y, cell.z)


def _transpose(cell: Cell, _size: Size) -> Cell:
    return Cell(cell.y, cell.x, cell.z)


def _quarter_turn(cell: Cell, size: Size) -> Cell:
    return Cell(size[1] - 1 - cell.y, cell.x, cell.z)


def _antitranspose(cell: Cell, size: Size) -> Cell:
    return Cell(size[1] - 1 - cell.y, size[0] - 1 - cell.x, cell.z)


SYMMETRIES = (
    Symmetry("left to right", square=False, moved=_mirror_x),
    Symmetry("front to back", square=False, moved=_mirror_y),
    Symmetry("by half a turn", square=False, moved=_half_turn),
    Symmetry("by a quarter turn", square=True, moved=_quarter_turn),
    Symmetry("about a diagonal", square=True, moved=_transpose),
    Symmetry("about the other diagonal", square=True, moved=_antitranspose),
)


def symmetries(cells: Cells, size: Size) -> tuple[Symmetry, ...]:
    """Those of ``SYMMETRIES`` that the cells, from [0, 0, 0] in their box, have."""
    return tuple(
        symmetry
        for symmetry in SYMMETRIES
        if (not symmetry.square or size[0] == size[1])
        and all(symmetry.moved(cell, size) in cells for cell in cells)
    )


def orbits(size: Size, kept: tuple[Symmetry, ...]) -> dict[Cell, Cell]:
    """The representative of every cell of a box: the least of those that symmetry ties to it."""
    nx, ny, nz = size
    found: dict[Cell, Cell] = {}
    for x in range(nx):
        for y in range(ny):
            if Cell(x, y, 0) in found:
                continue
            # Cells come in order, so the first of an orbit is its least.
            orbit, front = {Cell(x, y, 0)}, [Cell(x, y, 0)]
            while front:
                cell = front.pop()
                for symmetry in kept:
                    image = symmetry.moved(cell, size)
                    if image not in orbit:
                        orbit.add(image)
                        front.append(image)
            for cell in orbit:
                for z in range(nz):
                    found[cell._replace(z=z)] = Cell(x, y, z)
    return found
