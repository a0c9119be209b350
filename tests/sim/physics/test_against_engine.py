"""The world's verdict on random structures, against MuJoCo's."""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from cellctl.assembly import Cell
from cellctl.sim.physics import Material, collapse
from cellctl.sim.physics.collapse import STAYS
from cellctl.sim.physics.least_constraint import accelerations
from cellctl.sim.physics.loads import SIDES
from cellctl.sim.physics.structure import Structure
from tests.physics_engine import stands

from .structures import MASS_KG, PITCH_M, WEIGHT_N, Contact, material, random_structure

AWAY = 1.2
TILT = 0.1
"""Compared is what stands or falls all the same with joints weaker and stronger by the first, and
on a floor tilted by the second to any side: the engine's contacts are soft, and its friction is
bound to each point of a contact."""


def compare(seeds: range) -> Counter[bool]:
    """Judge structures grown from seeds; returns how many of each verdict were compared."""
    compared: Counter[bool] = Counter()
    for seed in seeds:
        chance = random.Random(seed)  # noqa: S311 - repeatable chance
        structure = random_structure(chance, chance.randint(4, 10))
        contact: Contact = chance.choice(("diamond", "square"))
        force_n = chance.choice((2.0, 4.0, 8.0, 16.0))
        friction = chance.choice((0.3, 0.5, 0.8))
        grips = chance.random() < 0.5
        stuff = material(force_n, friction=friction, contact=contact, floor_grips=grips)
        verdict = collapse(structure, stuff) is None
        if {verdict} != nearby_verdicts(structure, stuff):
            continue
        engine = stands(
            structure,
            mass_kg=MASS_KG,
            pitch_m=PITCH_M,
            magnet_force_n=force_n,
            friction=friction,
            contact=contact,
            floor_grips=grips,
        )
        assert engine == verdict, f"seed {seed}: the world says {verdict}, the engine {engine}"
        compared[verdict] += 1
    return compared


def nearby_verdicts(structure: frozenset[Cell], stuff: Material) -> set[bool]:
    """Whether it stands with other joints and on tilted floors."""
    verdicts = set()
    for share in (AWAY, 1 / AWAY):
        changed = replace(
            stuff,
            magnet=stuff.magnet * share,
            floor_magnet=stuff.floor_magnet * share,
            friction=stuff.friction * share,
        )
        arrays = Structure(structure, changed)
        loads = np.repeat(arrays.weights()[None], 4, axis=0)
        loads[:, :, :2] += TILT * np.array(SIDES)[:, None, :]
        moves = np.abs(accelerations(arrays, loads)).max(axis=(1, 2)) > STAYS
        verdicts |= set((~moves).tolist())
    return verdicts


def test_the_engine_agrees_on_random_structures() -> None:
    compared = compare(range(16))
    assert min(compared[True], compared[False]) >= 2


@pytest.mark.soak
@pytest.mark.timeout(1800)
def test_the_engine_agrees_on_many_random_structures() -> None:
    compared = compare(range(1000, 3000))
    assert min(compared[True], compared[False]) >= 400


def test_weights_are_those_of_the_engine() -> None:
    assert material(WEIGHT_N).magnet == pytest.approx(1.0)
