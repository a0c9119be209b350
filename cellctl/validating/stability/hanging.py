"""What a part needs whatever the rest of the structure does: a bound that no forces get below."""

from __future__ import annotations

from collections.abc import Set as AbstractSet

import numpy as np

from cellctl.assembly import Cell
from cellctl.validating.stability.joints import Floats
from cellctl.validating.stability.physics import Physics
from cellctl.validating.stability.strength import needed_pull


def least_pull(cell: Cell, push: Floats, cells: AbstractSet[Cell], physics: Physics) -> float:
    """The least share of the magnets' force that holds a cell while it is pushed.

    As far as one part after the other is held by a single joint, that joint bears all beyond it,
    and nothing can ease it.

    Args:
        cell: one at whose end nothing else hangs, or nothing is known.
        push: the load on it besides its weight, force in N and moment about its centre in N m.
        cells: all that stand.
        physics: what holds them.
    """
    load, before = push.copy(), cell
    axes, wrenches = [], []
    while cell.z >= 0:
        load[2] -= physics.weight_n
        held = [c for c in cell.neighbours() if c != before and (c in cells or c.z < 0)]
        if len(held) != 1:
            break
        way = np.subtract(cell, held[0])
        arm_m = way * (physics.pitch_m / 2)
        load[3:] += np.cross(arm_m, load[:3])
        axes.append(int(np.argmax(np.abs(way))))
        wrenches.append(-way.sum() * load)
        load[3:] += np.cross(arm_m, load[:3])
        before, cell = cell, held[0]
    if not axes:
        return 0.0
    bare = np.zeros(len(axes), dtype=np.bool_)
    bare[-1] = cell.z < 0 and not physics.floor_grips
    needs = needed_pull(np.array(wrenches), np.array(axes, dtype=np.int64), bare, physics)
    return float(needs.max())
