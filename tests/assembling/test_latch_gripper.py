"""The latch gripper over the emulated controller's lines, with a gripper acted on its pins."""

from __future__ import annotations

import asyncio
import math
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress

import pytest

from cellctl.assembling.arm import Switch
from cellctl.assembling.latch_gripper import LatchGripper
from cellctl.config import CellConfig
from cellctl.errors import CellFault
from tests.assembling.emulator import Emulator
from tests.assembling.paths import away_from
from tests.assembling.test_arm import connected, stance, until_moving

pytestmark = pytest.mark.wire

TRAVEL_S = 0.35
HEARD_S = 0.3

Behaviour = Callable[[bool, float], bool]
"""From the command line's level and the time since it changed to the status line's level."""


def healthy(commanded_open: bool, since_s: float) -> bool:
    return not commanded_open and since_s >= TRAVEL_S


def silent(commanded_open: bool, since_s: float) -> bool:  # noqa: ARG001
    return False


def stuck_high(commanded_open: bool, since_s: float) -> bool:  # noqa: ARG001
    return True


def stalled(commanded_open: bool, since_s: float) -> bool:  # noqa: ARG001
    return since_s >= TRAVEL_S and int((since_s - TRAVEL_S) / 0.1) % 2 == 0


class Pins:
    """A gripper on command output 0 and status input 0, in the emulator's time."""

    def __init__(self, emulator: Emulator) -> None:
        self.behaviour: Behaviour = healthy
        self.commands = [False]
        self._emulator = emulator

    async def run(self) -> None:
        changed_at_s, level = -1.0, False
        while True:
            truth = self._emulator.truth()
            commanded_open = bool(truth["outputs"] & 1)
            if commanded_open != self.commands[-1]:
                self.commands.append(commanded_open)
                changed_at_s = truth["time_s"]
            wanted = self.behaviour(commanded_open, truth["time_s"] - changed_at_s)
            if wanted != level:
                level = wanted
                self._emulator.tell(f"input 0 {int(level)}")
            await asyncio.sleep(0.003)

    async def shown(self, *, high: bool) -> None:
        """Wait until the controller sees that level on the status line."""
        async with asyncio.timeout(10):
            while True:
                if bool(self._emulator.truth()["inputs"] & 1) == high:
                    return
                await asyncio.sleep(0.003)

    async def heard(self) -> None:
        """Wait for long enough that whoever listens to the controller has heard its newest."""
        until_s = self._emulator.truth()["time_s"] + HEARD_S
        async with asyncio.timeout(10):
            while True:
                if self._emulator.truth()["time_s"] >= until_s:
                    return
                await asyncio.sleep(0.003)


@asynccontextmanager
async def gripper(config: CellConfig) -> AsyncIterator[tuple[LatchGripper, Pins]]:
    with Emulator(config, "--clock-rate", "2") as emulator:
        pins = Pins(emulator)
        async with connected(emulator.config) as arm:
            at_work = asyncio.create_task(pins.run())
            try:
                yield LatchGripper(arm, emulator.config), pins
            finally:
                at_work.cancel()
                with suppress(asyncio.CancelledError):
                    await at_work


def test_the_wiring_is_proved_by_opening_closing_and_opening(impatient: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(impatient) as (latch, pins):
            assert TRAVEL_S < await latch.check_wiring() < 2.0
            assert pins.commands == [False, True, False, True]
            pins.behaviour = lambda is_open, since_s: not is_open and stalled(is_open, since_s)
            with pytest.raises(CellFault, match="Input 0 rose and fell again"):
                await latch.check_wiring()
            assert pins.commands[-1] is True

    asyncio.run(scenario())


def test_a_status_line_on_another_input_is_named(impatient: CellConfig) -> None:
    lines = impatient.gripper.model_copy(update={"status_input": 5})

    async def scenario() -> None:
        async with gripper(impatient.model_copy(update={"gripper": lines})) as (latch, pins):
            with pytest.raises(CellFault, match=r"input 5 did not rise .* input 0 changed instead"):
                await latch.check_wiring()
            pins.behaviour = silent
            await pins.shown(high=False)
            with pytest.raises(CellFault, match="no input changed: look at the command line"):
                await latch.check_wiring()
            assert pins.commands[-1] is True

    asyncio.run(scenario())


@pytest.fixture
def impatient(config: CellConfig) -> CellConfig:
    lines = config.gripper.model_copy(update={"travel_timeout_s": 0.8})
    return config.model_copy(update={"gripper": lines})


def test_opens_then_latches(config: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(config) as (latch, pins):
            await latch.unlatch()
            assert pins.commands[-1] is True
            await latch.latch()
            assert pins.commands == [False, True, False]

    asyncio.run(scenario())


def test_a_latch_that_was_never_open_is_opened_first(config: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(config) as (latch, pins):
            await latch.latch()
            assert pins.commands == [False, True, False]

    asyncio.run(scenario())


def test_a_silent_gripper_is_tried_again_and_then_a_fault(impatient: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(impatient) as (latch, pins):
            await latch.unlatch()
            pins.behaviour = silent
            with pytest.raises(CellFault) as caught:
                await latch.latch()
            assert caught.value.code == "gripper_silent"
            assert "2 attempts" in caught.value.detail
            assert pins.commands == [False, True, False, True, False]

    asyncio.run(scenario())


def test_a_second_attempt_may_succeed(impatient: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(impatient) as (latch, pins):
            await latch.unlatch()
            pins.behaviour = lambda is_open, since_s: (
                len(pins.commands) > 4 and healthy(is_open, since_s)
            )
            await latch.latch()
            assert pins.commands == [False, True, False, True, False]

    asyncio.run(scenario())


def test_a_toggling_status_is_no_latch(config: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(config) as (latch, pins):
            await latch.unlatch()
            pins.behaviour = stalled
            with pytest.raises(CellFault) as caught:
                await latch.latch()
            assert caught.value.code == "gripper_fault"

    asyncio.run(scenario())


def test_the_proof_may_be_left_for_later_and_is_not_forgotten(config: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(config) as (latch, pins):
            await latch.unlatch()
            await latch.latch(prove=False)
            await latch.proof()
            await latch.unlatch()
            pins.behaviour = stalled
            await latch.latch(prove=False)
            with pytest.raises(CellFault, match="confirmed and then revoked") as caught:
                await latch.proof()
            assert caught.value.code == "gripper_fault"

    asyncio.run(scenario())


def test_a_proof_that_begins_late_sees_a_toggling_status_all_the_same(config: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(config) as (latch, pins):
            await latch.unlatch()
            pins.behaviour = stalled
            await latch.latch(prove=False)
            await pins.heard()
            await pins.shown(high=False)
            await pins.shown(high=True)
            with pytest.raises(CellFault, match="confirmed and then revoked"):
                await latch.proof()

    asyncio.run(scenario())


def test_a_latch_that_is_revoked_stops_the_arm(config: CellConfig) -> None:
    async def scenario() -> None:
        with Emulator(config, "--clock-rate", "2") as emulator:
            pins = Pins(emulator)
            async with connected(emulator.config) as arm:
                at_work = asyncio.create_task(pins.run())
                latch = LatchGripper(arm, emulator.config)
                await latch.unlatch()
                await latch.latch(prove=False)
                move = asyncio.create_task(arm.follow(away_from(stance(arm).tcp_pose), 3.0))
                await until_moving(arm)
                pins.behaviour = silent
                with pytest.raises(CellFault, match="confirmed and then revoked"):
                    await latch.proof()
                (ended,) = await asyncio.gather(move, return_exceptions=True)
                assert isinstance(ended, asyncio.CancelledError)
                at_work.cancel()
                with suppress(asyncio.CancelledError):
                    await at_work

    asyncio.run(scenario())


def test_a_latch_that_was_told_to_close_on_the_way_is_not_opened_again(config: CellConfig) -> None:
    async def scenario() -> None:
        with Emulator(config, "--clock-rate", "2") as emulator:
            pins = Pins(emulator)
            async with connected(emulator.config) as arm:
                at_work = asyncio.create_task(pins.run())
                latch = LatchGripper(arm, emulator.config)
                await latch.unlatch()
                lines = emulator.config.gripper
                path = away_from(stance(arm).tcp_pose)[:1]
                switch = Switch(line=lines.command_output, high=False, within_m=0.02)
                states: list[tuple[bool, bool]] = []
                move = asyncio.create_task(arm.follow(path, 3.0, switch))
                while not move.done():
                    state = arm.state()
                    assert state is not None
                    told_open = bool(state.digital_outputs >> lines.command_output & 1)
                    near = math.dist(state.tcp_pose[:3], path[-1].pose[:3]) < 0.02
                    states.append((told_open, near))
                    await asyncio.sleep(0.002)
                await move
                assert (True, False) in states
                assert (False, False) not in states
                await latch.latch(begun=True)
                assert pins.commands == [False, True, False]
                at_work.cancel()
                with suppress(asyncio.CancelledError):
                    await at_work

    asyncio.run(scenario())


def test_a_status_that_is_high_before_the_latch_closes_is_no_latch(impatient: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(impatient) as (latch, pins):
            await latch.unlatch()
            pins.behaviour = stuck_high
            await pins.shown(high=True)
            await pins.heard()
            with pytest.raises(CellFault, match="stays high although") as caught:
                await latch.latch()
            assert caught.value.code == "gripper_silent"

    asyncio.run(scenario())


def test_a_toggling_status_is_no_opening(config: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(config) as (latch, pins):
            pins.behaviour = stalled
            with pytest.raises(CellFault) as caught:
                await latch.unlatch()
            assert caught.value.code == "gripper_fault"

    asyncio.run(scenario())


def test_a_status_that_never_falls_is_no_opening(impatient: CellConfig) -> None:
    async def scenario() -> None:
        async with gripper(impatient) as (latch, pins):
            pins.behaviour = stuck_high
            await pins.shown(high=True)
            with pytest.raises(CellFault) as caught:
                await latch.unlatch()
            assert caught.value.code == "gripper_silent"
            assert "stays high" in caught.value.detail

    asyncio.run(scenario())
