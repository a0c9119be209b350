"""A placed part in the latch: it stands until it is moved, and how it is moved decides."""

from __future__ import annotations

import math

import numpy as np

from cellctl.assembly import Cell
from cellctl.sim.world import PARTING_M, World
from cellctl.sim.world_geometry import rotation
from cellctl.sim.world_values import ViolationKind, Where
from tests.sim.world.hand import DOWN, Hand, emulated_config

TOP = Cell(2, 2, 1)


def gripping(floor: str = "grips") -> Hand:
    """A column of two, with the latch closed on its top part."""
    config = emulated_config()
    gently = {"floor": floor, "placement_side_n": 0.0}
    stability = config.stability.model_copy(update=gently)
    hand = Hand(World(config.model_copy(update={"stability": stability})))
    for z in range(2):
        hand.place(2, 2, z)
    hand.over(0.25, 0.25, 0.2)
    hand.close()
    assert hand.kinds() == []
    return hand


def test_a_gripped_part_stands_until_it_is_moved_and_when_it_is_let_go() -> None:
    hand = gripping()
    assert TOP in hand.world.built
    hand.go(0.25, 0.25, 0.2 + PARTING_M / 2)
    assert TOP in hand.world.built
    hand.go(0.25, 0.25, 0.2)
    hand.open()
    hand.go(0.25, 0.25, 0.8)
    assert TOP in hand.world.built
    assert hand.kinds() == []


def test_a_part_that_is_lifted_off_is_in_the_gripper_and_can_be_laid_on_the_belt() -> None:
    hand = gripping()
    hand.go(0.25, 0.25, 0.8)
    assert hand.world.built == {Cell(2, 2, 0)}
    assert hand.world.held_part is not None
    on_belt = hand.world.parts_on_belt
    hand.world.belt_move(-0.11)
    hand.over(*hand.station_m)
    hand.open()
    assert hand.world.parts_on_belt == on_belt + 1
    assert hand.world.part_at_pick()
    assert hand.kinds() == []


def test_a_part_can_be_tilted_off() -> None:
    hand = gripping()
    hinge = np.array([0.3, 0.25, 0.1])
    for step in range(1, 21):
        turn = rotation(np.array([0.0, math.radians(0.3 * step), 0.0]))
        hand.jump(hinge + turn @ (np.array([0.25, 0.25, 0.2]) - hinge), turn @ DOWN)
    assert hand.world.held_part is not None
    assert hand.kinds() == []


def test_what_does_not_bear_it_comes_along_and_falls() -> None:
    hand = gripping(floor="bare")
    hand.go(0.25, 0.25, 0.25)
    assert hand.world.held_part is not None
    assert hand.kinds() == [ViolationKind.DRAGGED_NEIGHBOUR]
    assert hand.world.built == frozenset()
    assert hand.world.counts()[Where.FALLEN] == 1


def test_whoever_takes_away_what_is_gripped_leaves_an_empty_latch() -> None:
    hand = gripping()
    hand.world.take_placed_part(TOP)
    hand.go(0.25, 0.25, 0.8)
    assert hand.world.held_part is None
    assert hand.world.built == {Cell(2, 2, 0)}


def test_what_is_pressed_on_its_seat_is_felt() -> None:
    hand = gripping()
    hand.open()
    hand.pick()
    for cell, felt in ((Cell(2, 2, 2), True), (Cell(4, 2, 2), False)):
        hand.carry(*cell, off_m=(0.0, 0.0, 0.0005))
        assert hand.world.tcp_force_n()[2] == 0.0
        hand.carry(*cell, off_m=(0.0, 0.0, -0.0007))
        assert bool(hand.world.tcp_force_n()[2] > 10.0) is felt
        hand.over(0.25, 0.25, 0.8)
    assert hand.kinds() == []


def test_a_part_that_sticks_is_felt_before_it_comes_off() -> None:
    hand = gripping()
    hand.open()
    hand.pick()
    hand.carry(2, 2, 2)
    hand.world.parts_stick = True
    hand.open()
    hand.go(0.25, 0.25, 0.3007)
    assert hand.world.tcp_force_n()[2] < -10.0
    assert Cell(2, 2, 2) in hand.world.built
    hand.world.free_parts()
    hand.go(0.25, 0.25, 0.8)
    assert Cell(2, 2, 2) in hand.world.built
    assert hand.kinds() == []
