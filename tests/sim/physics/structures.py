"""Structures and materials that the tests of the world's physics judge."""

from __future__ import annotations

import random
from typing import Literal

from cellctl.assembly import Cell
from cellctl.sim.physics import Material
from cellctl.sim.world_support import adrift

Contact = Literal["diamond", "square"]
MASS_KG = 0.15
WEIGHT_N = MASS_KG * 9.80665
PITCH_M = 0.1


def material(
    magnet_force_n: float = 22.0,
    *,
    friction: float = 0.5,
    contact: Contact = "diamond",
    floor_grips: bool = True,
    down_n: float = 1.5,
    side_n: float = 3.2,
) -> Material:
    """As configured by default, but for what is given."""
    magnet = magnet_force_n / WEIGHT_N
    return Material(
        magnet=magnet,
        floor_magnet=magnet if floor_grips else 0.0,
        friction=friction,
        contact=contact,
        placement_down=down_n / WEIGHT_N,
        placement_side=side_n / WEIGHT_N,
    )


def cells(*places: tuple[int, int, int]) -> frozenset[Cell]:
    return frozenset(Cell(*place) for place in places)


def column(height: int, x: int = 0, y: int = 0) -> frozenset[Cell]:
    return cells(*((x, y, z) for z in range(height)))


def arm(length: int, z: int = 1) -> frozenset[Cell]:
    """So many cells in a row that reach out from the top of a column."""
    return column(z + 1) | cells(*((x, 0, z) for x in range(1, length + 1)))


def bridge(span: int, z: int = 1) -> frozenset[Cell]:
    """So many cells in a row between the tops of two columns."""
    return arm(span, z) | column(z + 1, x=span + 1)


def random_structure(chance: random.Random, parts: int, size: int = 4) -> frozenset[Cell]:
    """Grown part by part, with few of them on the floor; all are joined to it."""
    grown = {Cell(chance.randrange(size), chance.randrange(size), 0)}
    while len(grown) < parts:
        near = chance.choice(chance.choice(sorted(grown)).neighbours())
        inside = 0 <= near.x < size and 0 <= near.y < size and 0 <= near.z < 6
        if inside and (near.z > 0 or chance.random() < 0.3):
            grown.add(near)
    assert not adrift(grown)
    return frozenset(grown)


def grown(seed: int, parts: int) -> frozenset[Cell]:
    """The random structure of a seed."""
    return random_structure(random.Random(seed), parts)  # noqa: S311 - repeatable chance
