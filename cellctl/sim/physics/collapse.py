"""Which parts do not stay where they are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from cellctl.assembly import Cell
from cellctl.sim.physics.joints import Floats, Joint, Material
from cellctl.sim.physics.least_constraint import accelerations
from cellctl.sim.physics.load_path import unproven
from cellctl.sim.physics.loads import REST, Push, at_top
from cellctl.sim.physics.structure import Structure

STAYS = 5e-4
"""A part stays if neither its centre nor its rim begins to move with more than this, in g. A
cantilever of three whose joint lacks a two-thousandth of the magnet's force moves with it."""
_ALIKE = 7
"""Digits by which motions differ; what is alike to these is taken in the order of its cells."""


class Collapse(NamedTuple):
    """A structure that does not stand."""

    moving: tuple[Cell, ...]
    """The parts that do not stay, in order."""
    weakest: Joint
    """The joint that gives way fastest."""
    pushed: bool
    """Whether it stands at rest, and gives way to what the arm does."""


def collapse(
    cells: frozenset[Cell], material: Material, newest: Cell | None = None
) -> Collapse | None:
    """Whether, and how, a structure of rigid parts begins to collapse.

    Args:
        cells: where parts are; each is joined to the floor by a chain of faces.
        material: what holds them together.
        newest: the part that is being placed, if one is.

    Returns:
        None if all parts stay.
    """
    loads = unproven(cells, material, newest)
    if not loads:
        return None
    structure = Structure(cells, material)
    motions = accelerations(structure, _forces(structure, loads, newest), STAYS)
    fastest = np.abs(motions).max(axis=(1, 2)).round(_ALIKE)
    # At rest first: what moves then needs no push.
    case = 0 if loads[0] == REST and fastest[0] > STAYS else int(fastest.argmax())
    return _told(structure, motions[case], pushed=loads[case] != REST)


def collapse_under(
    cells: frozenset[Cell], material: Material, loads: Mapping[Cell, Floats]
) -> Collapse | None:
    """The same under any loads on some of the parts.

    Args:
        cells: where parts are; each is joined to the floor by a chain of faces.
        material: what holds them together.
        loads: force and moment (6,) about the centre of each part that has one.

    Returns:
        None if all parts stay.
    """
    structure = Structure(cells, material)
    forces = structure.weights()
    for cell, load in loads.items():
        forces[structure.cells.index(cell)] += load
    return _told(structure, accelerations(structure, forces[None], STAYS)[0], pushed=True)


def _told(structure: Structure, motion: Floats, *, pushed: bool) -> Collapse | None:
    """What moves, by the accelerations of parts (parts x 6); None if all stay."""
    each = np.abs(motion).max(axis=1)
    if each.max().round(_ALIKE) <= STAYS:
        return None
    # Of a group that begins to tip, those near its edge are slower than the rest, and move all the
    # same.
    moves = each > min(STAYS, each.max() / 10.0)
    gives = np.abs(structure.relative(motion[None])[0]).max(axis=1)
    return Collapse(
        moving=tuple(sorted(c for c, moved in zip(structure.cells, moves, strict=True) if moved)),
        weakest=structure.joints[int(gives.round(_ALIKE).argmax())],
        pushed=pushed,
    )


def _forces(structure: Structure, loads: tuple[Push, ...], newest: Cell | None) -> Floats:
    """Cases x parts x 6: on all parts, under each of the loads."""
    forces = np.repeat(structure.weights()[None], len(loads), axis=0)
    if newest is not None:
        forces[:, structure.cells.index(newest)] += [at_top(push) for push in loads]
    return forces
