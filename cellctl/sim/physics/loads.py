"""What a structure must bear: its weight, and what the arm does to the part that it places."""

from __future__ import annotations

import numpy as np

from cellctl.assembly import Cell
from cellctl.sim.physics.joints import Floats, Material

Push = tuple[float, float, float]
"""A force at the centre of the top face of the part that is placed."""

REST: Push = (0.0, 0.0, 0.0)
SIDES = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))


def pushes(newest: Cell | None, cells: frozenset[Cell], material: Material) -> tuple[Push, ...]:
    """What must be borne besides the weight: nothing, and each of the pushes of a placement.

    What is set down on the floor or on a part is pressed, and rubs to any side as it finds its
    place. What joins others at its side only slides down along them, and is pressed. Pressing
    alone is borne by what bears two opposite pushes.

    Args:
        newest: the part that is being placed, if one is.
        cells: where parts are, that one included.
    """
    if newest is None:
        return (REST,)
    down = -material.placement_down
    if newest.z > 0 and newest.below() not in cells:
        return (REST, (0.0, 0.0, down))
    side = material.placement_side
    return (REST, *((side * x, side * y, down) for x, y in SIDES))


def at_top(force: Push) -> Floats:
    """The same as force and moment about the part's centre."""
    return np.concatenate([force, np.cross([0.0, 0.0, 1.0], force)])
