"""What a structure must bear: its weight, and what the arm does to the part that it places."""

from __future__ import annotations

import numpy as np

from cellctl.assembly import Cell
from cellctl.sim.physics.joints import Floats, Material

SIDES = ((1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0))


def placement_pushes(
    newest: Cell, cells: frozenset[Cell], material: Material
) -> tuple[tuple[float, float, float], ...]:
    """Forces at the top face of the part that is placed, each of which must be borne.

    What is set down on the floor or on a part is pressed, and rubs to any side as it finds its
    place. What joins others at its side only slides down along them, and is pressed. Pressing
    alone is borne by what bears two opposite pushes.
    """
    down = -material.placement_down
    if newest.z > 0 and newest.below() not in cells:
        return ((0.0, 0.0, down),)
    side = material.placement_side
    return tuple((side * x, side * y, down) for x, y in SIDES)


def at_top(force: tuple[float, float, float]) -> Floats:
    """A force at the centre of a part's top face as (force, moment about the part's centre)."""
    return np.concatenate([force, np.cross([0.0, 0.0, 1.0], force)])
