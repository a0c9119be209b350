"""The form of a part: a cuboctahedron, whose six square faces stand on their corners."""

from __future__ import annotations

import itertools
from functools import cache

import numpy as np
import numpy.typing as npt

Points = npt.NDArray[np.float64]


@cache
def faces() -> tuple[tuple[Points, Points], ...]:
    """Its 14 faces, the squares first: (outward normal (3,), corners (4 or 3, 3)).

    It is one cell wide and centred on the origin. Corners run counter-clockwise seen from outside;
    normals are whole numbers, not of length 1.
    """
    found: list[tuple[Points, Points]] = []
    for axis, sign in itertools.product(range(3), (-1.0, 1.0)):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        corners = np.zeros((4, 3))
        corners[:, axis] = sign * 0.5
        corners[[0, 2], u] = (0.5, -0.5)
        corners[[1, 3], v] = (0.5, -0.5)
        normal = np.zeros(3)
        normal[axis] = sign
        found.append((normal, corners if sign > 0.0 else corners[::-1]))
    for signs in itertools.product((-1.0, 1.0), repeat=3):
        normal = np.array(signs)
        corners = np.array([normal * 0.5 * mask for mask in ((1, 1, 0), (0, 1, 1), (1, 0, 1))])
        found.append((normal, corners if signs.count(-1.0) % 2 == 0 else corners[::-1]))
    return tuple(found)
