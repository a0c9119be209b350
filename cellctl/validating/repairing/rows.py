"""Rows of cells that stay unbroken."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Cell

Bools = npt.NDArray[np.bool_]


def broken_rows(wanted: Bools) -> Iterator[tuple[Cell, Cell, Cell]]:
    """Cells a, b and c in a row of which a and c must not be filled without b.

    They belong to an unbroken row of the wanted shape (nx, ny, nz), along any axis. Cells that
    nobody sees, with wanted ones on all sides, may be left out between others.
    """
    shown = wanted & ~_hidden(wanted)
    for axis in range(3):
        for place in np.argwhere(wanted).tolist():
            row = _row(Cell(*place), axis, wanted)
            for end in range(2, len(row)):
                for between in row[1:end]:
                    if shown[between]:
                        yield row[0], between, row[end]


def _hidden(wanted: Bools) -> Bools:
    padded = np.pad(wanted, 1)
    hidden = wanted.copy()
    for axis in range(3):
        for step in (1, -1):
            hidden &= np.roll(padded, step, axis)[1:-1, 1:-1, 1:-1]
    return hidden


def _row(cell: Cell, axis: int, wanted: Bools) -> list[Cell]:
    """The wanted cells from one on along an axis, up to the first that is not wanted."""
    row = [cell]
    for at in range(cell[axis] + 1, wanted.shape[axis]):
        place = list(cell)
        place[axis] = at
        if not wanted[tuple(place)]:
            break
        row.append(Cell(*place))
    return row
