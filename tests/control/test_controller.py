"""The controller: a consumer that outlives everything, and stages that come and go with states."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager

import pytest

from cellctl.control.controller import INBOX_LIMIT, Controller, Post
from cellctl.control.states import Event
from cellctl.errors import CellctlError, CellFault, NoObjectError, RefusedError
from cellctl.messages import FaultData, StatusData

Work = Callable[[Post], Awaitable[None]]


class Script:
    """Stages whose work a test writes; those it does not name do nothing."""

    def __init__(self, **works: Work) -> None:
        self.works = works
        self.begun: list[str] = []
        self.ended: list[str] = []
        self.states: list[str] = []
        self.refusals: list[str] = []
        self.news = asyncio.Event()
        self.trip: Exception | None = None

    async def run_stage(self, name: str, post: Post) -> None:
        self.begun.append(name)
        self.news.set()
        try:
            await self.works.get(name, nothing)(post)
        finally:
            self.ended.append(name)

    def request_ended(self, error: CellctlError) -> None:
        self.refusals.append(error.message)

    def changed(self, event: Event, before: str, after: str) -> None:  # noqa: ARG002 - protocol
        self.states.append(after)
        self.news.set()
        if self.trip is not None:
            trip, self.trip = self.trip, None
            raise trip

    async def until(self, state: str) -> None:
        async with asyncio.timeout(10):
            while not self.states or self.states[-1] != state:
                self.news.clear()
                await self.news.wait()

    async def until_begun(self, name: str, times: int) -> None:
        async with asyncio.timeout(10):
            while self.begun.count(name) < times:
                self.news.clear()
                await self.news.wait()


async def nothing(_post: Post) -> None:
    return


async def start(post: Post) -> None:
    post(Event.STARTED)


async def brake(post: Post) -> None:
    post(Event.AT_REST)


async def recover(post: Post) -> None:
    post(Event.RECOVERED)


@asynccontextmanager
async def running(script: Script) -> AsyncIterator[tuple[Controller, list[StatusData]]]:
    published: list[StatusData] = []
    controller = Controller(script, lambda data, _state: published.append(data))
    task = asyncio.create_task(controller.run())
    try:
        yield controller, published
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)


def latched(controller: Controller) -> FaultData:
    """The fault that the controller keeps, as the bus shows it; empty when there is none."""
    return controller.latched.view() if controller.latched is not None else FaultData()


def test_a_command_that_was_given_up_does_nothing_later() -> None:
    async def scenario() -> None:
        script = Script()
        controller = Controller(script, lambda _data, _state: None)
        controller.post(Event.STARTED)
        # Nobody takes anything from the inbox yet.
        with pytest.raises(RefusedError, match="too busy"):
            await controller.command(Event.SAY, timeout_s=0.0)
        task = asyncio.create_task(controller.run())
        await controller.probe()
        assert script.states == ["idle"]
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)

    asyncio.run(scenario())


def test_results_of_a_stage_that_was_cancelled_are_dropped() -> None:
    posts: list[Post] = []

    async def generate(post: Post) -> None:
        posts.append(post)
        await asyncio.Event().wait()

    async def interpret(post: Post) -> None:
        post(Event.UNDERSTOOD)

    async def scenario() -> None:
        script = Script(start=start, interpret=interpret, generate=generate, brake=brake)
        async with running(script) as (controller, _):
            await script.until("idle")
            await controller.command(Event.SAY)
            await script.until_begun("generate", 1)
            await controller.command(Event.PAUSE)
            await script.until("paused_resting")
            posts[0](Event.DESIGNED)
            await controller.command(Event.RESUME_GENERATING)
            await script.until_begun("generate", 2)
            assert script.ended[-1] == "generate", "the old stage ends before the new one begins"
            posts[0](Event.DESIGNED)
            with pytest.raises(RefusedError):
                await controller.command(Event.CONFIRM)
            assert controller.state == "generating"

    asyncio.run(scenario())


def test_the_first_fault_stays_until_it_is_reset_and_later_ones_are_kept() -> None:
    async def scenario() -> None:
        script = Script(start=start, recover=recover)
        async with running(script) as (controller, published):
            await script.until("idle")
            controller.post_fault(CellFault("belt_jam", "first"))
            controller.post_fault(CellFault("protective_stop", "second"))
            await script.until("fault_stopped")
            view = latched(controller)
            assert view.entry is not None
            assert (view.entry.code, view.detail, view.during) == ("belt_jam", "first", "idle")
            assert "protective stop" in view.later[0]
            await controller.command(Event.RESET)
            await script.until("paused_resting")
            assert latched(controller) == FaultData()
            assert FaultData() in published

    asyncio.run(scenario())


def test_a_stage_that_fails_is_a_fault_and_a_request_that_fails_is_none() -> None:
    async def interpret(_post: Post) -> None:
        raise NoObjectError("Beauty is no object.")

    async def stumble(_post: Post) -> None:
        raise ZeroDivisionError("1/0")

    async def scenario() -> None:
        script = Script(start=start, interpret=interpret, hear=stumble)
        async with running(script) as (controller, _):
            await script.until("idle")
            await controller.command(Event.SAY)
            await script.until("idle")
            assert script.refusals == ["Beauty is no object."]
            await controller.command(Event.HEAR)
            await script.until("fault_held")
            assert controller.latched is not None
            assert controller.latched.fault.code == "internal"
            assert "ZeroDivisionError" in controller.latched.fault.detail

    asyncio.run(scenario())


def test_a_defect_in_what_follows_an_event_does_not_end_the_consumer() -> None:
    async def scenario() -> None:
        script = Script(start=start, brake=brake)
        async with running(script) as (controller, _):
            await script.until("idle")
            script.trip = KeyError("bookkeeping")
            await controller.command(Event.PAUSE)
            await script.until("fault_held")
            assert (await controller.command(Event.STOP)).verdict == "accepted"

    asyncio.run(scenario())


def test_stop_gets_through_a_full_inbox() -> None:
    async def scenario() -> None:
        script = Script(start=start, brake=brake)
        async with running(script) as (controller, _):
            await script.until("idle")
            await controller.command(Event.PAUSE)
            for _ in range(INBOX_LIMIT + 10):
                controller.post(Event.PART_NEAR)
            assert controller.inbox_size == INBOX_LIMIT
            with pytest.raises(RefusedError, match="busy"):
                await controller.command(Event.RESUME_IDLE)
            assert (await controller.command(Event.STOP)).state == "paused_braking"

    asyncio.run(scenario())
