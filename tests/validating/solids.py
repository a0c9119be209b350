"""Random objects like furniture, for proofs about any shape."""

from __future__ import annotations

from random import Random

from cellctl.assembly import Cell
from cellctl.validating.rules import pieces, supported

_GRID = (6, 5, 6)


def random_solid(seed: int, grid: tuple[int, int, int] = _GRID) -> frozenset[Cell]:
    """Boxes like legs, seats, walls and lumps that hang together and can be laid from above.

    Nothing says that it stands.
    """
    random = Random(seed)  # noqa: S311 - shapes, not secrets
    cells: set[Cell] = set()
    for _ in range(random.randint(1, 6)):
        kind = random.choice(("leg", "slab", "wall", "lump"))
        spans = [_span(random, size) for size in grid]
        if kind == "leg":
            spans[0] = (spans[0][0], spans[0][0])
            spans[1] = (spans[1][0], spans[1][0])
            spans[2] = (0, spans[2][1])
        elif kind == "slab":
            spans[2] = (spans[2][1], spans[2][1])
        elif kind == "wall":
            axis = random.randint(0, 1)
            spans[axis] = (spans[axis][0], spans[axis][0])
            spans[2] = (0, spans[2][1])
        (x0, x1), (y0, y1), (z0, z1) = spans
        cells |= {
            Cell(x, y, z)
            for x in range(x0, x1 + 1)
            for y in range(y0, y1 + 1)
            for z in range(z0, z1 + 1)
        }
    return laid_from_above(cells) or frozenset({Cell(0, 0, 0)})


def laid_from_above(cells: set[Cell]) -> frozenset[Cell]:
    """What can be laid layer by layer, and of that the largest piece."""
    laid: set[Cell] = set()
    for z in range(max((cell.z for cell in cells), default=-1) + 1):
        for piece in pieces(cell for cell in cells if cell.z == z):
            if any(supported(cell, frozenset(laid)) for cell in piece):
                laid |= piece
    return pieces(laid)[0] if laid else frozenset()


def _span(random: Random, size: int) -> tuple[int, int]:
    low, high = sorted((random.randrange(size), random.randrange(size)))
    return low, high
