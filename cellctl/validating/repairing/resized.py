"""The wanted shape at other sizes, as it is: what can be had without a solver."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator

import numpy as np

from cellctl.assembly import Cell
from cellctl.validating.repairing.score import Size, Wanted
from cellctl.validating.rules import Cells, hanging, pieces

_SPARE = 1.5
"""Boxes that would take this many times the parts, were they as full as the wanted one, are left
out: thin things vanish at other sizes, but not so many."""


def resized(wanted: Wanted, sizes: Iterable[Size], parts: int, until_s: float) -> Iterator[Cells]:
    """Objects that look like the wanted one, the closest first, each with far fewer parts.

    The next one has at most half as many parts as the one before: who could not use that one, for
    it collapsed or time was short, needs something of another kind.

    Args:
        wanted: the shape.
        sizes: of its box.
        parts: the most cells.
        until_s: no more sizes are tried after this time of the monotonic clock.
    """
    most_cells = _SPARE * parts / float(wanted.filled.mean())
    found: list[tuple[float, Cells]] = []
    for size in sizes:
        if time.monotonic() > until_s:
            break
        if math.prod(size) > most_cells:
            continue
        terms = wanted.terms(size)
        filled = terms.volume >= terms.cell / 2
        if 0 < int(filled.sum()) <= parts:
            cells = frozenset(Cell(*cell) for cell in np.argwhere(filled).tolist())
            found.append((wanted.score(cells), cells))
    for _, cells in sorted(found, key=lambda pair: (-pair[0], sorted(pair[1]))):
        if len(cells) <= parts and len(pieces(cells)) == 1 and not hanging(cells):
            parts = len(cells) // 2
            yield cells
