"""The four objects of the paper's tables, as solids that reproduce its figures.

The paper publishes neither meshes nor cells. These are furniture of its proportions whose cells
give the counts, overhangs and stacks that it prints, before and after each rescaling. Their volumes
are of no consequence for that, and are not fitted to the paper's.

The stool's splayed legs stand across boundaries of cells, other ones at each size: five columns of
four parts at full size become fourteen parts in three layers once it is a cell smaller. No stool
with upright legs goes from 45 parts to 30.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
import numpy.typing as npt

from cellctl.validating.clean import Surface

_SIDES = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
"""Quadrilaterals of a block, counter-clockwise from outside; corner number is 4 x + 2 y + z."""
_TRIANGLES: Final = np.array([[q[0], q[i], q[i + 1]] for q in _SIDES for i in (1, 2)])


class Rectangle(NamedTuple):
    """A horizontal rectangle by its corners, in cells."""

    x0: float
    y0: float
    x1: float
    y1: float


class Block(NamedTuple):
    """A solid between two horizontal rectangles, in cells."""

    bottom_z: float
    top_z: float
    bottom: Rectangle
    top: Rectangle


@dataclass(frozen=True)
class PaperObject:
    """One row of the paper's tables."""

    name: str
    title: str
    """As the tables name it."""
    prompt: str
    """As table 6 has it."""
    blocks: tuple[Block, ...]
    """They touch, and do not overlap."""

    @property
    def surface(self) -> Surface:
        """Its mesh, each block closed, in cells of the paper's workspace."""
        vertices = np.concatenate([_corners(block) for block in self.blocks])
        offsets = 8 * np.arange(len(self.blocks))[:, None, None]
        return Surface(vertices, (_TRIANGLES + offsets).reshape(-1, 3))


def volume(surface: Surface) -> float:
    """Enclosed by a closed, outward surface, in cubes of its unit (divergence theorem)."""
    a, b, c = (surface.triangles[:, i] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _corners(block: Block) -> npt.NDArray[np.float64]:
    low, high = block.bottom, block.top
    return np.array(
        [
            [(r.x0, r.x1)[i], (r.y0, r.y1)[j], z]
            for i in (0, 1)
            for j in (0, 1)
            for z, r in ((block.bottom_z, low), (block.top_z, high))
        ]
    )


def _upright(bottom_z: float, top_z: float, outline: Rectangle) -> Block:
    return Block(bottom_z, top_z, outline, outline)


OBJECTS: Final = (
    PaperObject(
        "stool",
        "Stool",
        "I want a simple stool",
        (
            _upright(4.8, 5.0, Rectangle(0.0, 0.0, 5.0, 5.0)),
            Block(0.0, 4.8, Rectangle(1.6, 1.1, 2.4, 1.6), Rectangle(1.6, 1.75, 2.4, 1.95)),
            Block(0.0, 4.8, Rectangle(1.6, 3.4, 2.4, 3.9), Rectangle(1.6, 3.05, 2.4, 3.25)),
            Block(0.0, 4.8, Rectangle(3.3, 2.2, 3.7, 2.8), Rectangle(3.1, 2.2, 3.5, 2.8)),
        ),
    ),
    PaperObject(
        "shelf",
        "Shelf",
        "A shelf with two tiers",
        (
            _upright(0.0, 6.0, Rectangle(0.0, 0.0, 0.3, 3.0)),
            _upright(0.0, 6.0, Rectangle(5.7, 0.0, 6.0, 3.0)),
            _upright(2.5, 2.8, Rectangle(0.3, 0.0, 5.7, 3.0)),
            _upright(5.7, 6.0, Rectangle(0.3, 0.0, 5.7, 3.0)),
        ),
    ),
    PaperObject(
        "letter_t",
        "Letter T",
        "The letter 'T'",
        (
            _upright(5.0, 6.0, Rectangle(0.0, 0.0, 3.0, 1.0)),
            _upright(0.0, 5.0, Rectangle(1.0, 0.0, 2.0, 1.0)),
        ),
    ),
    PaperObject(
        "table",
        "Table",
        "Assemble me a table with one leg",
        (
            _upright(5.7, 6.0, Rectangle(0.0, 0.0, 4.0, 4.0)),
            _upright(0.0, 5.7, Rectangle(1.2, 1.2, 1.8, 1.8)),
        ),
    ),
)
"""In the order of the tables."""
