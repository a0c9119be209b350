"""The gripper's pins."""

from __future__ import annotations

import itertools

import pytest

from cellctl.sim.latch import TRAVEL_S, Latch, LatchFault
from cellctl.sim.world import World
from cellctl.sim.world_values import Where

from .hand import Hand, emulated_config

STEP_S = 0.01


@pytest.fixture
def hand() -> Hand:
    """A hand with a part in its gripper."""
    hand = Hand(World(emulated_config()))
    hand.pick()
    return hand


def wait(latch: Latch, duration_s: float) -> list[bool]:
    """Let time pass; returns the status after each step."""
    levels = []
    for _ in range(round(duration_s / STEP_S)):
        latch.advance(STEP_S)
        levels.append(latch.status)
    return levels


def test_at_boot_it_is_closed_unconfirmed_and_does_not_move() -> None:
    latch = Latch(World(emulated_config()))
    latch.command(False)  # the controller's output as it comes up
    assert not any(wait(latch, 1.0))
    assert latch.closed


def test_status_rises_only_when_a_latch_is_complete() -> None:
    latch = Latch(World(emulated_config()))
    latch.command(True)
    assert not any(wait(latch, 1.0))
    latch.command(False)
    assert not any(wait(latch, TRAVEL_S - STEP_S))
    assert all(wait(latch, 1.0))


def test_status_falls_as_soon_as_the_latch_is_told_to_open(hand: Hand) -> None:
    levels = [hand.latch.status]
    hand.latch.command(True)
    levels.append(hand.latch.status)
    assert levels == [True, False]
    wait(hand.latch, TRAVEL_S - STEP_S)
    assert hand.world.counts()[Where.GRIPPER] == 1
    wait(hand.latch, STEP_S)
    assert hand.world.counts()[Where.GRIPPER] == 0


def test_a_silent_gripper_moves_all_the_same(hand: Hand) -> None:
    hand.latch.inject(LatchFault.SILENT)
    hand.open()
    assert hand.world.held_part is None
    hand.close()
    assert not hand.latch.status
    hand.latch.clear(LatchFault.SILENT)
    assert hand.latch.status


def test_a_fault_toggles_the_status_five_times_a_second_and_keeps_the_part(hand: Hand) -> None:
    hand.latch.inject(LatchFault.FAULT)
    hand.latch.command(True)
    levels = [hand.latch.status, *wait(hand.latch, 2.0)]
    edges = sum(a != b for a, b in itertools.pairwise(levels))
    assert edges == pytest.approx(20, abs=1)
    assert hand.world.held_part is not None


def test_a_stuck_latch_goes_on_once_it_is_free(hand: Hand) -> None:
    hand.latch.inject(LatchFault.STUCK)
    hand.latch.command(True)
    wait(hand.latch, 2.0)
    assert hand.world.held_part is not None
    hand.latch.clear(LatchFault.STUCK)
    wait(hand.latch, TRAVEL_S)
    assert hand.world.held_part is None


def test_losing_power_keeps_the_part_and_forgets_the_confirmation(hand: Hand) -> None:
    hand.latch.reboot()
    assert not any(wait(hand.latch, 1.0))
    assert hand.world.held_part is not None
    hand.latch.command(False)  # the level it had all along
    assert not any(wait(hand.latch, 1.0))


def test_losing_power_while_opening_keeps_the_part(hand: Hand) -> None:
    hand.latch.command(True)
    wait(hand.latch, TRAVEL_S / 2)
    hand.latch.reboot()
    wait(hand.latch, 1.0)
    assert hand.world.held_part is not None
    assert hand.latch.truth() == {"latched": True, "moving": False, "status": False, "faults": []}
