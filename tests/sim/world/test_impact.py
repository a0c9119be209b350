"""The paper's eight trials of speed and acceleration, as the world judges them."""

from __future__ import annotations

import pytest

from cellctl.assembly import Cell
from cellctl.sim.world import World
from tests.sim.world.hand import Hand, emulated_config

TRIALS = [
    (1.0, 1.0, True), (1.5, 1.5, True), (2.0, 2.0, False), (2.5, 2.5, False),
    (1.0, 0.5, True), (1.5, 0.75, True), (2.0, 1.0, True), (2.5, 1.25, False),
]  # fmt: skip
"""Velocity (m/s), acceleration (m/s2), and whether the assembly stood."""


@pytest.mark.parametrize(("speed_m_s", "acceleration_m_s2", "stood"), TRIALS)
def test_a_trial_ends_as_in_the_papers_table(
    speed_m_s: float, acceleration_m_s2: float, stood: bool
) -> None:
    hand = Hand(World(emulated_config()))
    hand.open()
    hand.pick()
    hand.world.commanded(speed_m_s, acceleration_m_s2)
    hand.carry(2, 2, 0)
    # Pressing on it afterwards, slowly, makes no jolt undone.
    hand.world.commanded(0.02, 1.0)
    x_m, y_m, z_m = hand.tcp[:3, 3].tolist()
    hand.go(x_m, y_m, z_m - 0.0007)
    hand.open()
    assert (Cell(2, 2, 0) in hand.world.built) is stood
    assert hand.kinds() == ([] if stood else ["jolted"])
