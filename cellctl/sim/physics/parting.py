"""What a part does to its neighbours while the arm takes it off them.

The arm is stiff: it makes the part move, and the part's joints are at their limits then. What each
passes on follows from how its two faces move against each other at the start, for a magnet lets go
within the first millimetres:

- they come apart all over: the magnet pulls the neighbour after the part with all it has;
- they come apart about a line that stays in touch: the magnet pulls at the centre, and the line
  presses back as hard, because the arm carries the part and leans on nothing;
- they slide or turn on each other: they rub with what the magnet presses;
- they would press into each other, which two solid parts cannot.

Lengths, forces and frames are those of ``joints``.
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from cellctl.assembly import Cell
from cellctl.sim.physics.collapse import Collapse, collapse_under
from cellctl.sim.physics.joints import Floats, Material

STILL = 0.03
"""Faces that part more slowly than this share of the part's fastest corner stay in touch: an arm
that tilts a part goes from pose to pose on chords of the arc that it means."""


class Parting(NamedTuple):
    """What came of taking one part."""

    pressed: Cell | None
    """A neighbour into which the part was pressed."""
    dragged: Collapse | None
    """Neighbours that came along."""


def parting(
    cells: frozenset[Cell], part: Cell, linear: Floats, angular: Floats, material: Material
) -> Parting:
    """Judge how a part begins to come off.

    Args:
        cells: where parts stand, ``part`` included.
        part: the one that the arm moves.
        linear: velocity of its centre (3,), in half pitches.
        angular: how it turns (3,), in radians; any unit of time serves for both.
        material: what holds parts together.
    """
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    fastest = float(np.linalg.norm(linear + np.cross(angular, corners), axis=1).max())
    linear, angular = linear / fastest, angular / fastest
    loads: dict[Cell, Floats] = {}
    pressed: Cell | None = None
    for axis, side in product(range(3), (-1, 1)):
        normal = side * np.eye(3)[axis]
        neighbour = Cell(*(int(i + n) for i, n in zip(part, normal, strict=True)))
        if neighbour not in cells:
            continue
        load = _passed_on(normal, linear, angular, material)
        if load is None:
            pressed = pressed or neighbour
        else:
            loads[neighbour] = load
    rest = _grounded(cells - {part})
    felt = {cell: load for cell, load in loads.items() if cell in rest}
    return Parting(pressed, collapse_under(rest, material, felt) if felt else None)


def _passed_on(
    normal: Floats, linear: Floats, angular: Floats, material: Material
) -> Floats | None:
    """Force and moment (6,) about the centre of the neighbour behind one face; None where the part
    is pressed into it."""
    spots = _spots(normal, material)
    velocities = linear + np.cross(angular, spots)
    leaving = -velocities @ normal
    if leaving.min() < -STILL:
        return None
    opens = bool(leaving.max() > STILL)
    touching = spots[leaving <= STILL]
    force, moment = np.zeros(3), np.zeros(3)
    # The neighbour's centre is one half pitch behind the face.
    if opens:
        force -= material.magnet * normal
    if len(touching):
        at = touching.mean(axis=0) if opens else normal
        push = material.magnet * normal if opens else np.zeros(3)
        sliding = linear + np.cross(angular, at)
        sliding = sliding - (sliding @ normal) * normal
        # What rubs is shared between shears and twist as each moves the corners of the contact.
        twisting = material.lever * float(angular @ normal)
        slip = float(np.abs(sliding).sum()) + abs(twisting)
        if slip > STILL:
            rub = material.friction * material.magnet
            push = push + rub * sliding / slip
            moment += rub * material.lever * twisting / slip * normal
        force += push
        moment += np.cross(at - 2.0 * normal, push)
    return np.concatenate([force, moment])


def _spots(normal: Floats, material: Material) -> Floats:
    """Corners of the contact at one face, from the part's centre."""
    one, two = np.roll(np.eye(3), -int(np.argmax(np.abs(normal))) - 1, axis=0)[:2]
    ends = (-1.0, 1.0)
    if material.contact == "diamond":
        around = [end * axis for axis in (one, two) for end in ends]
    else:
        around = [a * one + b * two for a in ends for b in ends]
    return np.array([normal + spot for spot in around])


def _grounded(cells: frozenset[Cell]) -> frozenset[Cell]:
    """The cells that a chain of faces joins to the floor; the others fall for another reason."""
    reached = {cell for cell in cells if cell.z == 0}
    pending = list(reached)
    while pending:
        for near in pending.pop().neighbours():
            if near in cells and near not in reached:
                reached.add(near)
                pending.append(near)
    return frozenset(reached)
