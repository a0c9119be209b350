"""A stop, spoken or typed, waits for nothing that was said before it."""

from __future__ import annotations

import asyncio
import itertools
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from cellctl.assembly import Role, Utterance
from cellctl.config import HearingSection
from cellctl.control import ears as live
from cellctl.control.controller import Post
from cellctl.control.daemon import Daemon
from cellctl.control.ears import LiveEars
from cellctl.control.states import Event
from cellctl.errors import HearingError
from cellctl.listening.ears.ears import Ears
from cellctl.listening.ears.events import EarsEvent, Expecting, Segment, SpokenAfter
from cellctl.listening.hearing import Hearing
from tests.cell.harness import cell_config
from tests.listening.model_server import Reply, model_server

PATIENCE_S = 60.0


class Microphone(Ears):
    """Ears without a process: what a test says is what they tell."""

    def __init__(self, _settings: HearingSection) -> None:
        self.events = asyncio.Queue[EarsEvent]()

    async def run(self) -> None:
        await asyncio.Event().wait()

    async def next_event(self) -> EarsEvent:
        return await self.events.get()

    def expect(self, what: Expecting) -> None:
        del what

    def says(self, words: str, after: SpokenAfter = "") -> None:
        """Somebody says something; the sound of it is its letters."""
        pcm = words.encode().ljust(64)
        self.events.put_nowait(Segment(pcm=pcm, after=after, speech_end_s=0.0, speech_s=0.5))


class Reading(Hearing):
    """A recogniser for that sound, which takes only the bare word for a stop at a glance."""

    async def hear_samples(self, pcm: bytes) -> Utterance:
        words = pcm.decode().strip()
        if words == "?":
            raise HearingError("There is no model.", "Get one.")
        return Utterance(text=words, source="microphone")

    async def says_stop(self, pcm: bytes) -> bool:
        return pcm.decode().strip() == "stop"


def listening(
    folder: Path, patch: pytest.MonkeyPatch, said: Callable[[Microphone, LiveEars], Awaitable[None]]
) -> list[str]:
    """Have something said to a cell that builds; returns what it says itself. A wish is still being
    read, by a language model that never answers."""
    patch.setattr(live, "Ears", Microphone)
    told: list[str] = []

    async def scenario() -> None:
        made = Daemon(cell_config(journal={"path": str(folder / "journal.db")}))
        try:
            settings = HearingSection(microphone="", activation="push_to_talk")
            ears = LiveEars(
                settings,
                Reading(settings),
                lambda: "assembling_placing",
                lambda _data: None,
                voice=made.voice,
                asks=lambda: False,
                changes=_never,
                sayings=made.conversation.phrasebook.sayings,
                say=told.append,
                translated=lambda text: text,
            )
            microphone = ears._ears
            assert isinstance(microphone, Microphone)
            async with asyncio.timeout(PATIENCE_S):
                await said(microphone, ears)
        finally:
            made.bus.close()

    asyncio.run(scenario())
    return told


async def _never(_text: str) -> bool:
    return False


@pytest.mark.parametrize("word", ["stop", "please stop", "pause"])
def test_it_passes_a_wish_that_is_still_being_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, word: str
) -> None:
    async def said(microphone: Microphone, ears: LiveEars) -> None:
        taken = asyncio.Queue[str]()

        async def take(utterance: Utterance, _begun_s: float) -> str:
            taken.put_nowait(utterance.text)
            if "stool" in utterance.text:
                await asyncio.Event().wait()
            return ""

        running = asyncio.create_task(ears.run(take))
        microphone.says("I want a stool", "push_to_talk")
        assert await taken.get() == "I want a stool"
        microphone.says(word)
        assert (await taken.get()).removeprefix("please ") == word.removeprefix("please ")
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)

    assert listening(tmp_path, monkeypatch, said) == []


def test_who_was_waited_for_is_told_that_nothing_was_made_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And nobody else: the room may be loud."""

    async def said(microphone: Microphone, ears: LiveEars) -> None:
        taken = asyncio.Queue[str]()

        async def take(utterance: Utterance, _begun_s: float) -> str:
            taken.put_nowait(utterance.text)
            return ""

        running = asyncio.create_task(ears.run(take))
        afters: tuple[SpokenAfter, ...] = ("", "open", "wake_word")
        for after, words in itertools.product(afters, ("?", " ")):
            microphone.says(words, after)
            microphone.says("a stool", "push_to_talk")
            assert await taken.get() == "a stool"
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)

    deaf, unclear = listening(tmp_path, monkeypatch, said)
    assert "type" in deaf
    assert "say it again" in unclear


def test_a_typed_one_passes_a_language_model_that_does_not_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with model_server() as server:
        server.replies = [Reply(silent=True)]
        model = {"back_end": "model", "model_url": server.url, "model_name": "tiny"}
        patience = {"timeout_s": PATIENCE_S, "budget_s": PATIENCE_S, "attempts": 1}
        journal = {"path": str(tmp_path / "journal.db")}
        made = Daemon(cell_config(understanding=model | patience, journal=journal))
        monkeypatch.setattr(made.cell, "run_stage", _nothing)

        async def typed(text: str) -> str:
            said = Utterance(text=text, source="text")
            return await made.conversation.take(said, Role.VISITOR)

        async def scenario() -> None:
            controller = made.cell.controller
            running = asyncio.create_task(controller.run())
            for event in (Event.STARTED, Event.SAY):
                controller.post(event)
            await controller.probe()
            assert controller.state == "listening_interpreting"
            wish = asyncio.create_task(typed("something like a stool but on three legs"))
            assert await asyncio.to_thread(server.asked.acquire, timeout=PATIENCE_S)
            assert await typed("stop")
            assert controller.state == "idle"
            assert not wish.done()
            assert len(server.requests) == 1
            server.ended.set()  # it hangs up
            await asyncio.gather(wish, return_exceptions=True)
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

        try:
            asyncio.run(scenario())
        finally:
            made.bus.close()


async def _nothing(_name: str, _post: Post) -> None:
    await asyncio.Event().wait()
