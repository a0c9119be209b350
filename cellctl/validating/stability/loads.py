"""What a structure must bear besides its weight."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from functools import lru_cache

import numpy as np

from cellctl.assembly import Cell
from cellctl.validating.rules import supported
from cellctl.validating.stability.joints import Floats
from cellctl.validating.stability.physics import Physics

SIDES = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))
"""Directions of a push aside: along +x, -x, +y and -y."""


@lru_cache(maxsize=64)
def push(physics: Physics, side: tuple[float, float] = (0.0, 0.0)) -> Floats:
    """Pressing a part down and aside at its top face: (6,), in N, and N m about its centre."""
    force = np.array(
        [
            side[0] * physics.placement_side_n,
            side[1] * physics.placement_side_n,
            -physics.placement_down_n,
        ]
    )
    found = np.concatenate([force, np.cross([0.0, 0.0, physics.pitch_m / 2], force)])
    found.flags.writeable = False
    return found


def placement_pushes(placed: Cell, cells: AbstractSet[Cell], physics: Physics) -> Iterator[Floats]:
    """The pushes that the structure must bear while a part is placed, (6,) each.

    A part that is set on something is pressed down and may be pushed aside, since its lower face
    catches as it finds its place. Pressing down alone is the mean of two opposite ones of these
    and so needs no more. A part that only joins others at its side slides down along their faces,
    and is pressed down.
    """
    if supported(placed, cells):
        for side in SIDES:
            yield push(physics, side)
    else:
        yield push(physics)
