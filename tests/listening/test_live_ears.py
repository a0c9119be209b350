"""The ears behind a virtual microphone: what goes wrong with it is noticed, and mended."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import pytest

from cellctl.config import HearingSection
from cellctl.listening.ears.ears import Ears
from cellctl.listening.ears.events import Condition, EarsEvent, Segment
from cellctl.sim.microphone import VirtualMicrophone
from cellctl.sound.portaudio import listed
from tests.virtual_sound import virtual_sound

pytestmark = pytest.mark.wire

NOTICED_S = 10.0
"""Two where the machine has nothing else to do."""
PATIENCE_S = 90.0
SETTINGS = HearingSection(microphone="", activation="push_to_talk")


@pytest.fixture
def microphone() -> Iterator[VirtualMicrophone]:
    with virtual_sound() as virtual:
        yield virtual


class Listener:
    """What the ears have told so far."""

    def __init__(self, ears: Ears) -> None:
        self.ears = ears

    async def until(self, wanted: Callable[[EarsEvent], bool]) -> EarsEvent:
        """The next event that is as wanted."""
        async with asyncio.timeout(PATIENCE_S):
            while not wanted(event := await self.ears.next_event()):
                continue
            return event

    async def state(self, *states: str) -> Condition:
        """The next condition that has one of these states."""
        event = await self.until(lambda e: isinstance(e, Condition) and e.state in states)
        assert isinstance(event, Condition)
        return event

    async def named(self, device: str) -> None:
        """Wait until it listens to this microphone; the sound server may tell its name late."""
        await self.until(
            lambda e: isinstance(e, Condition) and e.state == "waiting" and e.device == device
        )


@asynccontextmanager
async def listening(settings: HearingSection = SETTINGS) -> AsyncIterator[Listener]:
    """Ears that are at work."""
    ears = Ears(settings)
    task = asyncio.create_task(ears.run())
    try:
        listener = Listener(ears)
        await listener.state("waiting")
        yield listener
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


async def noticed(listener: Listener, act: Callable[[], None], *states: str) -> Condition:
    """Do something to the microphone; the ears must tell of it in time."""
    await asyncio.to_thread(act)
    began_s = time.monotonic()
    condition = await listener.state(*states)
    took_s = time.monotonic() - began_s
    print(f"{act}: {condition.state} after {took_s:.2f} s")  # noqa: T201 - pytest shows it
    assert took_s < NOTICED_S
    return condition


def run(scenario: Callable[[], Awaitable[None]]) -> None:
    async def bounded() -> None:
        async with asyncio.timeout(90.0):
            await scenario()

    asyncio.run(bounded())


def test_a_microphone_that_goes_away_in_any_way_is_noticed_and_taken_up_again(
    microphone: VirtualMicrophone, speak: Callable[[str], Path]
) -> None:
    wish = speak("I want a simple stool")

    async def scenario() -> None:
        async with listening() as listener:
            lost = await noticed(listener, microphone.unplug, "lost")
            assert "microphone" in lost.sentence
            await asyncio.to_thread(microphone.replug)
            await listener.named("VirtualMicrophone")

            await noticed(listener, lambda: microphone.suspend(True), "lost")
            microphone.suspend(False)
            await listener.state("waiting")

            silent = await noticed(listener, lambda: microphone.silence(True), "silent")
            assert "switch" in silent.sentence
            await noticed(listener, lambda: microphone.silence(False), "waiting")

            # After all that it still hears.
            listener.ears.listen()
            await listener.state("recording")
            microphone.begin(wish)
            segment = await listener.until(lambda e: isinstance(e, Segment))
            assert isinstance(segment, Segment)
            assert segment.after == "push_to_talk"
            assert 1.0 < len(segment.samples) / 16_000 < 4.0
            assert 0.0 < time.monotonic() - segment.speech_end_s < 15.0

    run(scenario)


@pytest.mark.soak
def test_a_process_that_hangs_is_told_and_replaced(microphone: VirtualMicrophone) -> None:
    del microphone

    async def scenario() -> None:
        async with listening() as listener:
            first = listener.ears.pid
            assert first is not None
            await noticed(listener, lambda: os.kill(first, signal.SIGSTOP), "lost")
            await listener.state("waiting")
            assert listener.ears.pid not in (None, first)

    run(scenario)


def test_what_was_missed_is_told(microphone: VirtualMicrophone) -> None:
    del microphone

    async def scenario() -> None:
        async with listening() as listener:
            while True:
                pid = listener.ears.pid
                assert pid is not None
                os.kill(pid, signal.SIGSTOP)
                await listener.state("lost")
                with suppress(ProcessLookupError):  # replaced, where we were told so late
                    os.kill(pid, signal.SIGCONT)
                if (await listener.state("slow", "waiting")).state == "slow":
                    break
            await listener.state("waiting")
            assert listener.ears.pid == pid

    run(scenario)


def test_a_sound_server_that_dies_leaves_ears_that_say_so(microphone: VirtualMicrophone) -> None:
    async def scenario() -> None:
        async with listening() as listener:
            await noticed(listener, microphone.stop, "lost")
            await asyncio.to_thread(microphone.start)
            await listener.state("waiting")

    run(scenario)


def test_mute_closes_the_microphone(microphone: VirtualMicrophone) -> None:
    del microphone

    async def scenario() -> None:
        async with listening() as listener:
            listener.ears.mute(True)
            await listener.state("muted")
            listener.ears.mute(False)
            await listener.state("waiting")

    run(scenario)


def test_a_microphone_that_is_not_there_is_waited_for(microphone: VirtualMicrophone) -> None:
    settings = SETTINGS.model_copy(update={"microphone": "vmic"})

    async def scenario() -> None:
        ears = Ears(settings)
        task = asyncio.create_task(ears.run())
        try:
            listener = Listener(ears)
            lost = await listener.state("lost")
            assert "'vmic'" in lost.sentence
            await asyncio.to_thread(microphone.replug)
            await listener.named("VirtualMicrophone")
        finally:
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)

    microphone.unplug()
    run(scenario)


def test_the_devices_are_listed(microphone: VirtualMicrophone) -> None:
    del microphone
    assert "pulse" in listed("input")
