"""Shapes made of upright boxes, and their mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

_CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=np.float64)
# Two outward triangles a side, counter-clockwise seen from outside; corner number is 4x + 2y + z.
_FACES = np.array(
    [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ],
    dtype=np.int64,
)


class Box(NamedTuple):
    """An upright box by its minimum corner and its extent; in cells wherever families make one."""

    x: float
    y: float
    z: float
    width: float
    depth: float
    height: float


def mesh_of(
    boxes: tuple[Box, ...], unit_m: float
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
    """Vertices (8n, 3) in metres and faces (12n, 3): a closed, outward mesh for each box.

    Args:
        boxes: at least one; they may touch and overlap.
        unit_m: length of the boxes' unit, in metres.
    """
    corners = np.array([box[:3] for box in boxes])[:, None, :]
    extents = np.array([box[3:] for box in boxes])[:, None, :]
    vertices = (corners + _CORNERS * extents).reshape(-1, 3) * unit_m
    faces = (_FACES + 8 * np.arange(len(boxes))[:, None, None]).reshape(-1, 3)
    return vertices, faces
