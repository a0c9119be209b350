"""The motions that come out prove themselves, and so does the quick proof of standing."""

from __future__ import annotations

import numpy as np
import pytest

from cellctl.sim.physics.collapse import STAYS
from cellctl.sim.physics.joints import Joint, Material, joints_of
from cellctl.sim.physics.least_constraint import accelerations
from cellctl.sim.physics.load_path import unproven
from cellctl.sim.physics.loads import at_top, pushes
from cellctl.sim.physics.structure import Structure

from .structures import arm, cells, column, grown, material

MATERIALS = [
    material(22.0),
    material(10.0, floor_grips=False),
    material(15.0, contact="square", friction=0.3),
    material(22.0, friction=0.0),
]


@pytest.mark.parametrize("stuff", MATERIALS)
def test_a_motion_is_permitted_and_driven_by_the_loads(stuff: Material) -> None:
    """Then the structure cannot stand: no contact could resist it [upper bound theorem]."""
    fallen = 0
    for seed in range(25):
        structure = Structure(grown(seed, 4 + seed % 20), stuff)
        loads = structure.weights()[None]
        motion = accelerations(structure, loads)
        permitted = structure.relative(motion) @ stuff.corners()
        assert permitted.min() > -1e-6
        power = (loads * motion).sum()
        inertia = (structure.inertia * motion**2).sum()
        assert power == pytest.approx(inertia, rel=1e-3, abs=1e-6)
        fallen += np.abs(motion).max() > STAYS
    assert 0 < fallen < 25


def test_several_loads_at_once_move_as_each_does_alone() -> None:
    structure = Structure(arm(4) | column(6, x=0, y=2), material())
    rest = structure.weights()
    push = rest.copy()
    push[structure.cells.index((0, 2, 5))] += at_top((3.0, 1.0, -1.0))
    together = accelerations(structure, np.stack([rest, push]))
    for load, motion in zip((rest, push), together, strict=True):
        assert np.abs(accelerations(structure, load[None])[0] - motion).max() < 1e-4


def test_what_is_given_as_still_is_slow_and_the_rest_is_as_without() -> None:
    for seed in range(12):
        structure = Structure(grown(seed, 10), material(8.0))
        loads = structure.weights()[None]
        exact, quick = accelerations(structure, loads), accelerations(structure, loads, STAYS)
        if np.any(quick):
            assert np.abs(quick - exact).max() < 1e-6
        else:
            assert np.abs(exact).max() <= STAYS


def test_forces_are_the_transpose_of_relative_motions() -> None:
    structure = Structure(grown(3, 12), material())
    chance = np.random.default_rng(3)
    motion = chance.normal(size=(2, len(structure.cells), 6))
    wrenches = chance.normal(size=(2, len(structure.joints), 6))
    work = (structure.relative(motion) * wrenches).sum()
    assert work == pytest.approx((motion * structure.forces(wrenches)).sum())


def test_a_rigid_turn_about_the_floor_moves_joints_with_the_floor_only() -> None:
    structure = Structure(arm(2) | column(3, y=2), material())
    turn = np.array([0.3, -0.2, 0.5])
    centres = 2.0 * np.array(structure.cells) + 1.0
    motion = np.hstack([np.cross(turn, centres), np.tile(turn, (len(centres), 1))])
    seen = np.abs(structure.relative(motion[None])[0]).max(axis=1)
    assert [joint.lower.z < 0 for joint in structure.joints] == (seen > 1e-12).tolist()


def test_joints_are_all_pairs_of_faces_and_the_feet() -> None:
    found = {str(joint) for joint in joints_of(cells((0, 0, 0), (0, 0, 1), (1, 0, 1)))}
    assert found == {
        "between the floor and cell (0, 0, 0)",
        "between cells (0, 0, 0) and (0, 0, 1)",
        "between cells (0, 0, 1) and (1, 0, 1)",
    }
    assert all(isinstance(joint, Joint) for joint in joints_of(column(2)))


@pytest.mark.parametrize(
    "stuff", [material(22.0), material(22.0, floor_grips=False, contact="square", side_n=0.5)]
)
def test_what_a_single_path_proves_to_stand_does_not_move(stuff: Material) -> None:
    proven = 0
    for seed in range(20):
        structure = grown(seed, 1 + seed % 12)
        newest = max(structure)
        left = unproven(structure, stuff, newest)
        arrays = Structure(structure, stuff)
        for push in set(pushes(newest, structure, stuff)) - set(left):
            proven += 1
            load = arrays.weights()
            load[arrays.cells.index(newest)] += at_top(push)
            assert np.abs(accelerations(arrays, load[None])).max() <= STAYS
    assert proven > 10
