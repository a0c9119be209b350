"""Thin things that lie in the layer around a cell plane and are inside no cell.

A sheet or rod thinner than the layer, on a plane between two free cells, must be in the object
once: not lost, not on both sides. Each connected thing goes to one side as a whole, the one where
it touches more of what is there; else to the side nearer the object's middle, so that what is
symmetric stays so; else up.
"""

from __future__ import annotations

import itertools

import numpy as np
from scipy import ndimage

from cellctl.validating.crossing import Crossing, reached
from cellctl.validating.orientation import Bools, Floats, Ints


def claim(crossing: Crossing, occupied: Bools) -> Bools:
    """The cells (nx, ny, nz), all of them free, that thin things between cells take.

    Args:
        crossing: the surface over the lattice.
        occupied: the cells that are taken by what is inside of them.
    """
    layers = np.ones([2 * n + 1 for n in occupied.shape], dtype=np.bool_)
    layers[1::2, 1::2, 1::2] = False
    lost = crossing.met(layers & ~reached(occupied))
    claimed = np.zeros_like(occupied)
    if not lost.any():
        return claimed
    # In one layer, on the line where two meet, on the point where three do. What lies in fewer goes
    # first: it may take the rest along.
    layered = (np.indices(lost.shape) % 2 == 0).sum(axis=0)
    for count in (1, 2, 3):
        lost &= ~reached(claimed)
        things, number = ndimage.label(lost)
        for thing in range(1, number + 1):
            slots = np.argwhere((things == thing) & (layered == count))
            if len(slots):
                cells = _side(slots, np.argwhere(things == thing).mean(axis=0), occupied)
                claimed[tuple(cells.T)] = True
    return claimed


def _side(slots: Ints, middle: Floats, occupied: Bools) -> Ints:
    """The cells on one side of the planes in which slots (n, 3) of one thing lie."""
    size = np.array(occupied.shape)
    beside = np.pad(occupied, 1)
    inward = np.where(middle > size, -1, 1)
    # Slots count twice the cells, so the object's middle is at its size. Up wins over the middle.
    inward[2] = 1
    best: tuple[int, Ints] | None = None
    for turn in itertools.product((1, -1), repeat=3):
        slot = np.where(slots % 2 == 0, slots + inward * np.array(turn), slots)
        cells = np.unique((np.clip(slot, 1, 2 * size - 1) - 1) // 2, axis=0)
        touching = sum(
            int(beside[tuple((cells + 1 + step).T)].sum())
            for step in np.concatenate([np.eye(3, dtype=int), -np.eye(3, dtype=int)])
        )
        if best is None or touching > best[0]:
            best = (touching, cells)
    assert best is not None
    return best[1]
