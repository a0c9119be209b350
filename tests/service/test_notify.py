"""What the service manager hears of a daemon, on a real notify socket."""

from __future__ import annotations

import asyncio
import itertools
import os
import secrets
import signal
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Self

import psutil
import pytest

from cellctl.control.controller import Controller, Post
from cellctl.control.notify import Condition, NotifySocket, ServiceManager, ServiceReport
from cellctl.control.states import Event
from cellctl.errors import CellctlError
from tests.cell.harness import bar, running_cell
from tests.service.notified import NotifyReceiver, backlog_full

WATCHDOG_S = 1.0


@pytest.fixture(params=["path", "abstract"])
def receiver(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[NotifyReceiver]:
    address = f"@cellctl-{secrets.token_hex(8)}"
    if request.param == "path":
        address = str(tmp_path / "notify")
    with NotifyReceiver(address) as opened:
        yield opened


def test_lines_travel_in_one_datagram(receiver: NotifyReceiver) -> None:
    assert NotifySocket(receiver.address).send("READY=1", "STATUS=here I am")
    assert receiver.listen(0.05) == ["READY=1", "STATUS=here I am"]


def test_a_service_manager_that_takes_nothing_holds_nobody_up(receiver: NotifyReceiver) -> None:
    notify = NotifySocket(receiver.address)
    with backlog_full(receiver):
        begun_s = time.monotonic()
        assert not notify.send("WATCHDOG=1")
        assert time.monotonic() - begun_s < 10.0
    assert notify.send("WATCHDOG=1")
    receiver.wait("a ping", lambda line: line == "WATCHDOG=1", 5.0)


def test_without_a_service_manager_nothing_is_sent() -> None:
    manager = ServiceManager.from_environment({})
    assert manager.watchdog_s is None
    assert manager.socket.send("READY=1")


def test_the_variables_are_taken_away_from_children_and_must_be_meant_for_us() -> None:
    ours = {"NOTIFY_SOCKET": "/run/x", "WATCHDOG_USEC": "2500000", "WATCHDOG_PID": str(os.getpid())}
    assert ServiceManager.from_environment(ours).watchdog_s == 2.5
    assert ours == {}
    others = {"NOTIFY_SOCKET": "/run/x", "WATCHDOG_USEC": "2500000", "WATCHDOG_PID": "1"}
    assert ServiceManager.from_environment(others).watchdog_s is None
    assert others == {}


class BlockingStages:
    """Stages of which one never gives the loop back until it is let go."""

    def __init__(self) -> None:
        self.let_go = threading.Event()
        self.blocking = threading.Event()

    async def run_stage(self, name: str, post: Post) -> None:
        if name == "start":
            post(Event.STARTED)

    def request_ended(self, error: CellctlError) -> None:
        raise AssertionError(error)

    def changed(self, event: Event, before: str, after: str) -> None:  # noqa: ARG002 - protocol
        if event is Event.PAUSE:
            self.blocking.set()
            self.let_go.wait(30)


class LoopInThread:
    """A controller and its report on a loop of their own, which a test may let hang."""

    def __init__(self, address: str, stages: BlockingStages) -> None:
        self._address = address
        self._stages = stages
        self._begun = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._run()))

    def __enter__(self) -> Self:
        self._thread.start()
        assert self._begun.wait(10)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._stages.let_go.set()
        self._loop.call_soon_threadsafe(self._end.set)
        self._thread.join(30)

    async def _run(self) -> None:
        self._loop, self._end = asyncio.get_running_loop(), asyncio.Event()
        self._controller = Controller(self._stages, lambda _data, _state: None)
        report = ServiceReport(
            ServiceManager(NotifySocket(self._address), WATCHDOG_S),
            self._controller.probe,
            lambda: Condition(up=True, sentence="All is well."),
        )
        self._consumer = asyncio.create_task(self._controller.run())
        reporter = asyncio.create_task(report.run())
        self._begun.set()
        await self._end.wait()
        for task in (self._consumer, reporter):
            task.cancel()
        await asyncio.gather(self._consumer, reporter, return_exceptions=True)

    def hang(self) -> None:
        """Make the consumer, and with it the loop, stand still."""
        self._loop.call_soon_threadsafe(self._controller.post, Event.PAUSE)
        assert self._stages.blocking.wait(10)

    def end_consumer(self) -> None:
        """End the consumer; the loop goes on."""
        self._loop.call_soon_threadsafe(self._consumer.cancel)


def test_a_hung_loop_falls_silent_and_so_does_a_dead_consumer(tmp_path: Path) -> None:
    stages = BlockingStages()
    with (
        NotifyReceiver(str(tmp_path / "notify")) as receiver,
        LoopInThread(receiver.address, stages) as loop,
    ):
        receiver.wait("readiness", lambda line: line == "READY=1", 10.0)
        receiver.wait("a ping", lambda line: line == "WATCHDOG=1", 10.0)
        loop.hang()
        receiver.listen(0.05)
        assert receiver.listen(2 * WATCHDOG_S) == []  # the loop hangs: not a word
        stages.let_go.set()
        receiver.wait("a ping after the hang", lambda line: line == "WATCHDOG=1", 10.0)
        loop.end_consumer()
        receiver.listen(0.5)
        # The loop runs on, its timers fire, but nobody takes events: not a word either.
        assert receiver.listen(2 * WATCHDOG_S) == []


@pytest.mark.wire
def test_a_daemon_tells_all_its_life(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with NotifyReceiver(str(tmp_path / "notify")) as receiver:
        monkeypatch.setenv("NOTIFY_SOCKET", receiver.address)
        monkeypatch.setenv("WATCHDOG_USEC", f"{WATCHDOG_S * 1e6:.0f}")
        with running_cell(speed=10.0) as cell:
            deadline_s = time.monotonic() + 30.0
            while (lines := [line for _, line in receiver.heard]).count("READY=1") == 0:
                assert time.monotonic() < deadline_s, "it is not told that the daemon is ready"
                receiver.listen(0.1)
            assert lines.count("READY=1") == 1
            assert any(line.startswith("EXTEND_TIMEOUT_USEC=") for line in lines)
            assert "READY=1" not in lines[: lines.index(_last_extension(lines))]

            cell.client.build("bar.json", bar(1, 1, 1))
            snapshot = cell.wait_state("assembling_placing")
            receiver.wait(
                "the state's sentence",
                lambda line: line == f"STATUS={snapshot.state.sentence}",
            )
            cell.finish()

            receiver.listen(0.05)  # what came while nobody read has lost its times
            seen = len(receiver.heard)
            receiver.listen(4 * WATCHDOG_S)
            pings = [when_s for when_s, line in receiver.heard[seen:] if line == "WATCHDOG=1"]
            gaps = [after - before for before, after in itertools.pairwise(pings)]
            assert sorted(gaps)[len(gaps) // 2] < WATCHDOG_S / 2
            assert max(gaps) < WATCHDOG_S

            daemon = _daemon()
            daemon.send_signal(signal.SIGSTOP)
            try:
                receiver.listen(0.1)
                assert receiver.listen(1.5 * WATCHDOG_S) == []
            finally:
                daemon.send_signal(signal.SIGCONT)
            receiver.wait("a ping again", lambda line: line == "WATCHDOG=1")
            ended = len(receiver.heard)
        receiver.listen(0.1)
        last = [line for _, line in receiver.heard[ended:]]
        assert "STOPPING=1" in last
        assert "READY=1" not in last


def _last_extension(lines: list[str]) -> str:
    return next(line for line in reversed(lines) if line.startswith("EXTEND_TIMEOUT_USEC="))


def _daemon() -> psutil.Process:
    return next(
        child
        for child in psutil.Process().children()
        if "run" in child.cmdline() and "cellctl" in child.cmdline()
    )
