"""What the robot has set, read back before motion: each thing that differs is named."""

from __future__ import annotations

import asyncio
import time

import pytest

from cellctl.assembling.arm_process import RemoteArm
from cellctl.config import CellConfig
from cellctl.errors import CellFault
from tests.assembling.emulator import Emulator
from tests.assembling.paths import away_from
from tests.assembling.test_arm import connected, stance, until_moving

pytestmark = pytest.mark.wire

AT_MOST_S = 0.3
CHANGES = {
    "payload_changed payload_kg=2.5": "The payload is 2.5 kg and must be 1 kg.",
    "tcp_changed z_m=0.21": "The TCP is [0, 0, 0.21, 0, 0, 0] and must be [0, 0, 0.15, 0, 0, 0].",
    "tool_voltage_changed voltage_v=24": "The tool's supply is 24 V and must be 0 V",
    "output_changed line=3 high=false": "Digital output 3 is low and was ordered high",
    "output_changed line=0 high=true": "Digital output 0 is high and was ordered low",
    "reduced_mode": "The safety mode is reduced and must be normal.",
}


async def mismatch(arm: RemoteArm) -> str:
    """The detail of the mismatch that is found within five seconds."""
    async with asyncio.timeout(5.0):
        while True:
            try:
                await arm.verify()
            except CellFault as fault:
                assert fault.code == "robot_mismatch"  # noqa: PT017 - its detail is asked for
                return fault.detail


def test_a_robot_as_it_should_be_passes_quickly(either_cell: CellConfig) -> None:
    async def scenario(config: CellConfig) -> None:
        async with connected(config) as arm:
            await arm.set_output(3, high=True)
            durations_s = []
            for _ in range(5):
                begun_s = time.monotonic()
                check = await arm.verify()
                durations_s.append(time.monotonic() - begun_s)
            assert check.identity == await arm.connect()
            assert check.tcp == pytest.approx(config.tool.frame)
            assert check.payload_cog_m == pytest.approx(config.tool.payload_cog_m)
            assert (check.payload_kg, check.tool_voltage_v) == (config.tool.payload_kg, 24)
            assert check.digital_outputs == 1 << 3
            assert min(durations_s) < AT_MOST_S, durations_s
            assert (await arm.connect()) == check.identity

    tool = either_cell.tool.model_copy(update={"voltage_v": 24})
    wired = either_cell.model_copy(update={"tool": tool})
    with Emulator(wired, "--tool-voltage-v=24") as emulator:
        asyncio.run(scenario(emulator.config))
        assert emulator.truth()["watchdog"]["trips"] == 0


def test_a_check_that_was_given_up_does_not_spoil_the_next(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            known = (await arm.verify()).identity
            for _ in range(10):
                given_up = asyncio.create_task(arm.verify())
                await asyncio.sleep(0)  # it is ordered
                given_up.cancel()
                both = await asyncio.gather(arm.verify(), arm.verify())
                assert [check.identity for check in both] == [known, known]

    asyncio.run(scenario())


def test_whatever_somebody_changes_on_the_pendant_is_named(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            for line, high in ((0, False), (3, True)):
                await arm.set_output(line, high=high)
            await arm.verify()
            for change in CHANGES:
                emulator.tell(f"inject {change}")
            await until_reduced(arm)
            detail = await mismatch(arm)
            for sentence in CHANGES.values():
                assert sentence in detail
            # Connecting anew sets TCP and payload; a person has to mend the rest.
            emulator.tell("clear reduced_mode")
            emulator.tell("inject tool_voltage_changed voltage_v=0")
            await arm.recover()
            assert await mismatch(arm) == (
                "Digital output 0 is high and was ordered low; somebody switched it elsewhere. "
                "Digital output 3 is low and was ordered high; somebody switched it elsewhere."
            )
            for line, high in ((0, False), (3, True)):
                await arm.set_output(line, high=high)
            await arm.verify()

    asyncio.run(scenario())


async def until_reduced(arm: RemoteArm) -> None:
    """The last of the changes has come through."""
    async with asyncio.timeout(5.0):
        while "reduced" not in await mismatch(arm):
            pass


def test_an_output_that_nobody_waited_for_is_no_mismatch(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            await arm.set_output(0, high=False)
            ordering = asyncio.create_task(arm.set_output(0, high=True))
            await asyncio.sleep(0)
            ordering.cancel()
            await asyncio.gather(ordering, return_exceptions=True)
            assert ordering.cancelled()
            async with asyncio.timeout(5.0):
                await arm.verify()
                while not emulator.truth()["outputs"] & 1:  # it is set all the same
                    await arm.verify()

    asyncio.run(scenario())


def test_nothing_is_checked_while_the_arm_moves_or_stands_in_a_stop(emulator: Emulator) -> None:
    async def scenario() -> None:
        async with connected(emulator.config) as arm:
            move = asyncio.create_task(arm.follow(away_from(stance(arm).tcp_pose), 3.0))
            await until_moving(arm)
            with pytest.raises(CellFault, match="at rest only"):
                await arm.verify()
            await arm.stop()
            await asyncio.gather(move, return_exceptions=True)
            await arm.verify()
            emulator.tell("inject protective_stop")
            emulator.wait_until(lambda truth: truth["safety_mode"] == "PROTECTIVE_STOP")
            async with asyncio.timeout(5.0):
                while True:
                    try:
                        await arm.verify()
                    except CellFault as fault:
                        assert fault.code == "protective_stop"  # noqa: PT017 - after the loop
                        break

    asyncio.run(scenario())
