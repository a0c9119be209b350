"""Whatever is done to it, the world loses no part and makes none."""

from __future__ import annotations

import random

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule

from cellctl.sim.world import World
from cellctl.sim.world_values import Imperfections, Where

from .hand import PARTS, Hand, emulated_config

share = st.floats(0.0, 0.5)


class AnyLife(RuleBasedStateMachine):
    """Hands, belts and people do whatever they like."""

    @initialize(seed=st.integers(0, 1000), missing=share, sticky=share, yawed=share)
    def begin(self, seed: int, missing: float, sticky: float, yawed: float) -> None:
        rough = Imperfections(missing_share=missing, sticky_share=sticky, yawed_share=yawed)
        self.hand = Hand(World(emulated_config(), seed, rough))

    @rule(distance_m=st.floats(-0.2, 0.3))
    def move_belt(self, distance_m: float) -> None:
        self.hand.world.belt_move(distance_m)

    @rule()
    def go_to_station(self) -> None:
        self.hand.jump(self.hand.station_m)

    @rule(x=st.integers(-1, 3), y=st.integers(0, 2), z=st.integers(0, 3))
    def go_to_cell(self, x: int, y: int, z: int) -> None:
        self.hand.jump(((x + 0.5) * 0.1, (y + 0.5) * 0.1, (z + 1) * 0.1))

    @rule()
    def open(self) -> None:
        self.hand.open()

    @rule()
    def close(self) -> None:
        self.hand.close()

    @rule()
    def hand_over(self) -> None:
        self.hand.world.hand_over()

    @rule()
    def clear(self) -> None:
        self.hand.world.clear_workspace()

    @rule(parts=st.none() | st.integers(1, 5))
    def refill(self, parts: int | None) -> None:
        self.hand.world.refill_belt(parts)

    @rule()
    def mishaps(self) -> None:
        self.hand.world.remove_next_part()
        self.hand.world.drop_held_part()

    @rule()
    def empty(self) -> None:
        self.hand.world.empty_belt()

    @precondition(lambda self: self.hand.world.built)
    @rule(chance=st.randoms(use_true_random=False))
    def take_along(self, chance: random.Random) -> None:
        self.hand.world.take_placed_part(chance.choice(sorted(self.hand.world.built)))

    @invariant()
    def every_part_is_in_one_place(self) -> None:
        world = self.hand.world
        truths = world.parts()
        assert [truth.part for truth in truths] == list(range(PARTS))
        assert sum(world.counts().values()) == PARTS
        placed = [truth.cell for truth in truths if truth.where is Where.PLACED]
        assert set(placed) == world.built
        assert len(placed) == len(world.built)


TestAnyLife = AnyLife.TestCase
TestAnyLife.settings = settings(max_examples=25, stateful_step_count=25, deadline=None)
