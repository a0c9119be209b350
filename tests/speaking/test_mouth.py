"""The mouth in front of a virtual loudspeaker: what is heard of it, and what goes wrong with it."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import numpy as np
import pytest

from cellctl.config import VoiceSection
from cellctl.sim.loudspeaker import RATE_HZ
from cellctl.sim.microphone import VirtualMicrophone
from cellctl.speaking.events import Began, Condition, Ended, MouthEvent, MouthSettings
from cellctl.speaking.mouth import Mouth
from cellctl.wording import Line

pytestmark = pytest.mark.wire

PATIENCE_S = 60.0
LONG = Line(key="test", text="One two three four five six seven eight nine ten eleven twelve.")
SHORT = Line(key="test", text="Shall I build it?")


class Listener:
    """What the mouth has told so far."""

    def __init__(self) -> None:
        self.events: asyncio.Queue[tuple[MouthEvent, str]] = asyncio.Queue()

    def tell(self, event: MouthEvent, text: str) -> None:
        """See ``Mouth``."""
        self.events.put_nowait((event, text))

    async def until(self, wanted: Callable[[MouthEvent, str], bool]) -> MouthEvent:
        """The next event that is as wanted."""
        async with asyncio.timeout(PATIENCE_S):
            while not wanted(*(found := await self.events.get())):
                continue
            return found[0]

    async def state(self, *states: str) -> Condition:
        """The next condition that has one of these states."""
        event = await self.until(lambda e, _: isinstance(e, Condition) and e.state in states)
        assert isinstance(event, Condition)
        return event

    async def began(self, line: Line) -> Began:
        """Wait until this line is heard."""
        event = await self.until(lambda e, text: isinstance(e, Began) and text == line.text)
        assert isinstance(event, Began)
        return event

    async def ended(self, line: Line) -> Ended:
        """Wait until this line is not heard any more."""
        event = await self.until(lambda e, text: isinstance(e, Ended) and text == line.text)
        assert isinstance(event, Ended)
        return event

    async def next_ended(self) -> tuple[Ended, str]:
        """The next line that is not heard any more, or never will be."""
        ended: list[tuple[Ended, str]] = []

        def is_one(event: MouthEvent, text: str) -> bool:
            if isinstance(event, Ended):
                ended.append((event, text))
            return bool(ended)

        await self.until(is_one)
        return ended[0]


@asynccontextmanager
async def speaking(loudspeaker: str = "spk") -> AsyncIterator[tuple[Mouth, Listener]]:
    """A mouth that is ready."""
    listener = Listener()
    settings = MouthSettings(voice=VoiceSection(loudspeaker=loudspeaker), language="en")
    mouth = Mouth(settings, [SHORT.text], listener.tell)
    task = asyncio.create_task(mouth.run())
    try:
        await listener.state("quiet")
        yield mouth, listener
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def run(scenario: Callable[[], Awaitable[None]]) -> None:
    async def bounded() -> None:
        async with asyncio.timeout(280.0):
            await scenario()

    asyncio.run(bounded())


def is_speaking(mouth: Mouth) -> bool:
    """Whether it says that it is."""
    return mouth.speaking


async def until(holds: Callable[[], bool]) -> None:
    """Wait until something holds."""
    async with asyncio.timeout(PATIENCE_S):
        while not holds():  # noqa: ASYNC110 - a file, or another process
            await asyncio.sleep(0.02)


def length_s(began: Began) -> float:
    """How long a line is heard."""
    return len(began.envelope) * 0.032


def heard_s(recording: Path) -> float:
    """Seconds of the recording from its first loud sample to its last."""
    samples = np.frombuffer(recording.read_bytes(), dtype=np.int16).astype(np.int32)
    loud = np.flatnonzero(np.abs(samples) > 300)
    return float(loud[-1] - loud[0]) / RATE_HZ if len(loud) else 0.0


def test_lines_are_heard_one_after_the_other_and_a_hush_cuts_them_off(
    room: VirtualMicrophone, tmp_path: Path
) -> None:
    whole, cut = tmp_path / "whole.raw", tmp_path / "cut.raw"

    async def scenario() -> None:
        async with speaking() as (mouth, listener):
            await asyncio.to_thread(room.loudspeaker.record, whole)
            mouth.say(SHORT)
            mouth.say(LONG)
            assert is_speaking(mouth)
            began = await listener.began(SHORT)
            first = await listener.ended(SHORT)
            assert first.complete
            assert first.at_s - began.at_s > length_s(began) - 0.3
            began = await listener.began(LONG)
            second = await listener.ended(LONG)
            assert second.complete
            assert not is_speaking(mouth)
            assert second.at_s - began.at_s > length_s(began) - 0.3

            await asyncio.to_thread(room.loudspeaker.record, cut)
            mouth.say(LONG)
            mouth.say(SHORT)
            began = await listener.began(LONG)
            await until(lambda: heard_s(cut) > 0.8)
            hushed_s = time.monotonic()
            mouth.hush()
            # What waits is forgotten, and told to be, before or after what was heard.
            cut_off: dict[str, Ended] = {}
            while len(cut_off) < 2:
                event, text = await listener.next_ended()
                cut_off[text] = event
            ended = cut_off[LONG.text]
            assert not ended.complete
            assert not cut_off[SHORT.text].complete
            assert not is_speaking(mouth)
            length = cut.stat().st_size
            await until(lambda: cut.stat().st_size > length + RATE_HZ)  # half a second more
            room.loudspeaker.end()
            # Within a tenth of a second where the machine has nothing else to do.
            print(  # noqa: T201
                f"heard for {heard_s(cut):.3f} s, hushed after {hushed_s - began.at_s:.3f} s, "
                f"told {ended.at_s - hushed_s:.3f} s later"
            )
            assert 0.5 < heard_s(cut) < length_s(began) / 2

    run(scenario)
    assert 4.0 < heard_s(whole) < 12.0


def test_a_loudspeaker_that_goes_away_is_told_and_taken_up_again(room: VirtualMicrophone) -> None:
    speaker = room.loudspeaker

    async def scenario() -> None:
        async with speaking() as (mouth, listener):
            mouth.say(LONG)
            await listener.began(LONG)
            await asyncio.to_thread(speaker.unplug)
            assert not (await listener.ended(LONG)).complete
            lost = await listener.state("lost")
            assert "loudspeaker" in lost.sentence
            # What cannot be said is left to the screen at once.
            mouth.say(SHORT)
            assert not (await listener.ended(SHORT)).complete
            assert not is_speaking(mouth)

            await asyncio.to_thread(speaker.replug)
            await listener.state("quiet")
            await asyncio.to_thread(speaker.mute, True)
            assert "muted" in (await listener.state("silent")).sentence
            await asyncio.to_thread(speaker.mute, False)
            await listener.state("quiet")

            first = mouth.pid
            assert first is not None
            mouth.say(LONG)
            await listener.began(LONG)
            os.kill(first, signal.SIGKILL)
            assert not (await listener.ended(LONG)).complete
            await listener.state("quiet")
            assert mouth.pid not in (None, first)
            mouth.say(SHORT)
            assert (await listener.ended(SHORT)).complete

    run(scenario)


@pytest.mark.soak
def test_without_a_sound_server_it_says_so_and_waits(room: VirtualMicrophone) -> None:
    async def scenario() -> None:
        async with speaking(loudspeaker="") as (mouth, listener):
            await asyncio.to_thread(room.stop)
            await listener.state("lost")
            await asyncio.to_thread(room.start)
            await listener.state("quiet")
            mouth.say(SHORT)
            assert (await listener.ended(SHORT)).complete

    run(scenario)
