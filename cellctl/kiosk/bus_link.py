"""The page's end of the bus: a thread that listens, and requests that wait elsewhere.

The bus client is synchronous, so that it has a thread of its own; what it hears is handed to the
event loop in its order. It asks for the whole picture when messages were lost, when the daemon was
started again, and after messages that change more than they tell.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
import time
from collections.abc import AsyncIterator, Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Final, TypeVar

import structlog

from cellctl.assembly import Role
from cellctl.client import CellClient
from cellctl.config import CellConfig
from cellctl.errors import CellctlError
from cellctl.kiosk.mirror import Mirror, Sequence
from cellctl.messages import (
    Command,
    ControlReply,
    DialogueData,
    FileData,
    FileKind,
    StatusMessage,
)

log = structlog.get_logger(__name__)

_ANSWER_S: Final = 2.0
_REQUEST_S: Final = 10.0
_AGAIN_S: Final = 0.5
"""Between two attempts to reach a daemon."""
_LOOK_S: Final = 0.05
"""How long is listened before something else is looked after."""
_REFRESH_S: Final = 0.25
"""Not more often is the whole picture asked for, however much happens."""
_TELLS_LESS: Final = frozenset({"state", "part", "job"})
"""Topics after which something has changed that no message tells: plan, inventory, doubt."""
_END_PATIENCE_S: Final = 5.0
_AT_ONCE: Final = 24
"""Requests that wait for the cell at the same time; more wait for these."""
_STOPS_AT_ONCE: Final = 4

T = TypeVar("T")


class BusLink:
    """Follows one cell and asks it things.

    Args:
        config: says where its bus is.
        key: the page's key file, for a bus that is locked.
    """

    def __init__(self, config: CellConfig, key: Path | None = None) -> None:
        self._config = config
        self._key = key
        self._ended = threading.Event()
        self._asking = ThreadPoolExecutor(_AT_ONCE, thread_name_prefix="ask")
        # However many ask, and however slowly they are answered: a stop goes out at once.
        self._stopping = ThreadPoolExecutor(_STOPS_AT_ONCE, thread_name_prefix="stop")
        self.mirror = Mirror(patience_s=max(2.0, 3.0 * config.bus.heartbeat_s))

    async def ask(
        self,
        body: Command,
        attachment: bytes | None = None,
        *,
        role: Role = Role.VISITOR,
        visitor: str = "",
        timeout_s: float = _REQUEST_S,
    ) -> ControlReply:
        """Send one request by that role's door and wait for the reply.

        Args:
            body: what is asked.
            attachment: the request's second frame.
            role: whose door it goes to.
            visitor: the secret of the browser that asks; empty for whoever stands before the cell.
            timeout_s: longest wait (wall time).

        Raises:
            CellctlError: what the cell, or the way to it, says against it.
        """
        pool = self._stopping if body.command == "stop" else self._asking
        return await _in(pool, lambda: self._ask(body, attachment, role, visitor, timeout_s))

    async def file(
        self, kind: FileKind, job_id: str, *, role: Role = Role.VISITOR
    ) -> tuple[FileData, bytes]:
        """A file of a job.

        Raises:
            CellctlError: there is none, that role may not have it, or the cell does not answer.
        """

        def ask() -> tuple[FileData, bytes]:
            with CellClient.for_role(self._config, role, _REQUEST_S, self._key) as cell:
                return cell.file(kind, job_id)

        return await _in(self._asking, ask)

    def _ask(
        self,
        body: Command,
        attachment: bytes | None,
        role: Role,
        visitor: str,
        timeout_s: float,
    ) -> ControlReply:
        with CellClient.for_role(self._config, role, timeout_s, self._key) as cell:
            cell.visitor = visitor
            return cell.request(body, attachment)

    @contextlib.asynccontextmanager
    async def following(self) -> AsyncIterator[None]:
        """Keep the mirror up to date for as long as the context lasts."""
        loop = asyncio.get_running_loop()
        thread = threading.Thread(target=self._follow, args=(loop,), name="bus", daemon=True)
        thread.start()
        ticking = asyncio.create_task(self._tick(), name="ages")
        try:
            yield
        finally:
            ticking.cancel()
            self._ended.set()
            await asyncio.gather(ticking, return_exceptions=True)
            await asyncio.to_thread(thread.join, _END_PATIENCE_S)
            for pool in (self._asking, self._stopping):
                pool.shutdown(wait=False, cancel_futures=True)

    async def _tick(self) -> None:
        while True:
            await asyncio.sleep(1.0)
            self.mirror.tick()

    def _follow(self, loop: asyncio.AbstractEventLoop) -> None:
        """Body of the thread: one client after another, for as long as the page lives."""
        while not self._ended.is_set():
            try:
                with CellClient.for_role(self._config, Role.VISITOR, _ANSWER_S, self._key) as cell:
                    _Listener(cell, self.mirror, loop, self._ended).listen(
                        silence_s=3.0 * self._config.bus.heartbeat_s
                    )
            except CellctlError as error:
                log.debug("the cell does not answer", reason=str(error))
            except Exception:
                if loop.is_closed():  # the page ends
                    return
                # Without this thread the page would never again be anything but stale.
                log.exception("the cell cannot be followed")
            self._ended.wait(_AGAIN_S)


async def _in(pool: ThreadPoolExecutor, work: Callable[[], T]) -> T:
    """What waits elsewhere, and the page goes on."""
    return await asyncio.get_running_loop().run_in_executor(pool, work)


class _Listener:
    """One client that listens until it hears nothing more."""

    def __init__(
        self,
        cell: CellClient,
        mirror: Mirror,
        loop: asyncio.AbstractEventLoop,
        ended: threading.Event,
    ) -> None:
        self._cell = cell
        self._mirror = mirror
        self._loop = loop
        self._ended = ended
        self._sequence = Sequence()
        self._refreshed_s = 0.0
        self._due = False
        self._asked = ""

    def listen(self, silence_s: float) -> None:
        """Follow the cell until it has been silent for so long and does not answer.

        Raises:
            CellctlError: it does not answer.
        """
        self._cell.subscribe()
        self._refresh()
        heard_s = time.monotonic()
        while not self._ended.is_set():
            for message in self._cell.messages(_LOOK_S):
                heard_s = time.monotonic()
                self._take(message)
                if self._ended.is_set():
                    return
            if self._due and time.monotonic() - self._refreshed_s > _REFRESH_S:
                self._refresh()
            if time.monotonic() - heard_s > silence_s:
                # The status stream may be broken while the door answers: begin anew then, too.
                self._refresh()
                return

    def _take(self, message: StatusMessage) -> None:
        place = self._sequence.place(message.seq)
        if place == "gap":
            self._refresh()
            return
        if place == "known":
            return
        if self._asks_anew(message):
            # A yes must stand beside the plan that it is for, which comes with the whole picture.
            self._refresh()
            return
        self._loop.call_soon_threadsafe(self._mirror.take, message)
        if message.topic in _TELLS_LESS:
            self._due = True
        if self._due and time.monotonic() - self._refreshed_s > _REFRESH_S:
            self._refresh()

    def _asks_anew(self, message: StatusMessage) -> bool:
        if message.topic != "dialogue":
            return False
        data = message.payload()
        return isinstance(data, DialogueData) and data.asked != self._asked

    def _refresh(self) -> None:
        snapshot = self._cell.snapshot()
        self._asked = snapshot.dialogue.asked
        self._sequence.snapshot(snapshot.seq)
        self._refreshed_s, self._due = time.monotonic(), False
        self._loop.call_soon_threadsafe(self._mirror.take_snapshot, snapshot)
