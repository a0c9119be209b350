"""Where parts touch, and what a joint of two faces bears.

Everything in this package is dimensionless: lengths in half pitches, masses in parts, and
accelerations in g, so that forces are in weights of one part. A part is a cube whose centre of
mass is its centre.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal, NamedTuple, Self

import numpy as np
import numpy.typing as npt

from cellctl.assembly import Cell
from cellctl.config import CellConfig

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

GRAVITY_M_S2 = 9.80665
INERTIA = 2.0 / 3.0
"""Of a solid cube about any axis through its centre: m (2a)^2 / 6."""


@dataclass(frozen=True)
class Material:
    """What parts are made of, and how hard they are handled; forces in weights of one part.

    A joint presses with its magnet and with what the parts press each other with. Of that sum live
    its friction (the shears along both axes of the face and the twist, together at most
    ``friction`` times it) and its resistance to bending: it opens by rocking over the edge of the
    contact. Each of the two is taken to have all of the sum, as limit analysis of blocks does.
    Twists count with the lever at which the corners of the contact rub.
    """

    magnet: float
    floor_magnet: float
    friction: float
    contact: Literal["diamond", "square"]
    placement_down: float
    placement_side: float

    @classmethod
    def of(cls, config: CellConfig) -> Self:
        """As configured."""
        stability = config.stability
        weight_n = config.voxel.mass_kg * GRAVITY_M_S2
        magnet = stability.magnet_force_n / weight_n
        return cls(
            magnet=magnet,
            floor_magnet=magnet if stability.floor == "grips" else 0.0,
            friction=stability.friction,
            contact=stability.contact,
            placement_down=stability.placement_down_n / weight_n,
            placement_side=stability.placement_side_n / weight_n,
        )

    @property
    def lever(self) -> float:
        """From the contact's centre to its corners."""
        return 1.0 if self.contact == "diamond" else 2.0**0.5

    def bears(self, wrench: Sequence[float], magnet: float) -> bool:
        """Whether a joint bears (press, two shears, two bending moments, twist) at its centre."""
        press, shear_u, shear_v, bend_u, bend_v, twist = wrench
        pressed = press + magnet
        bends = abs(bend_u), abs(bend_v)
        return (
            abs(shear_u) + abs(shear_v) + abs(twist) / self.lever <= self.friction * pressed
            and (sum(bends) if self.contact == "diamond" else max(bends)) <= pressed
        )

    def corners(self) -> Floats:
        """6 x 24: the extreme wrenches of a contact that is pressed by one weight.

        Every wrench that the contact can exert is a sum of these with weights of 0 or more. Rows
        as in ``bears``.
        """
        ends = (-1.0, 1.0)
        if self.contact == "diamond":
            bends = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)]
        else:
            bends = list(product(ends, ends))
        rubs = self.friction * np.diag([1.0, 1.0, self.lever])
        rubs = np.vstack([rubs, -rubs])
        return np.array([(1.0, u, v, *bend, turn) for u, v, turn in rubs for bend in bends]).T


class Joint(NamedTuple):
    """Two faces that touch; ``lower`` is on the lower side along ``axis``, its z -1 the floor."""

    lower: Cell
    upper: Cell
    axis: int

    def __str__(self) -> str:
        if self.lower.z < 0:
            return f"between the floor and cell {tuple(self.upper)}"
        return f"between cells {tuple(self.lower)} and {tuple(self.upper)}"


def joints_of(cells: frozenset[Cell]) -> tuple[Joint, ...]:
    """Every joint of parts at these cells, with each other and with the floor, in order."""
    found = []
    for cell in sorted(cells):
        for axis in range(3):
            lower = Cell(*(index - (at == axis) for at, index in enumerate(cell)))
            if lower in cells or lower.z < 0:
                found.append(Joint(lower, cell, axis))
    return tuple(found)


def frame(axis: int) -> Floats:
    """3 x 3: normal, u and v of joints along that axis, as rows."""
    return np.roll(np.eye(3), -axis, axis=0)


def relative_motion(axis: int, side: Literal[-1, 1]) -> Floats:
    """6 x 6: a part's motion (3 velocities, 3 rates of turning) to what its joint sees of it.

    Args:
        axis: of the joint.
        side: where the joint is, seen from the part's centre.

    Returns:
        The motion of the joint's centre along (normal, u, v) and about (u, v, normal). Its
        transpose takes the joint's wrench to the forces and moments on the part.
    """
    rows = frame(axis)
    arm = side * rows[0]
    # v + w x arm, along each row: row . (w x arm) = w . (arm x row)
    moves = np.hstack([rows, np.cross(arm, rows)])
    turns = np.hstack([np.zeros((3, 3)), rows[[1, 2, 0]]])
    return np.vstack([moves, turns])
