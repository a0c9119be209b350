"""``Ears``: the daemon's end of the process that owns the microphone.

PortAudio may hang or crash with its sound server, so it never runs in the daemon. The process tells
four times a second that it is alive; one that falls silent is killed and started anew.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import sys
import time
from collections import deque
from contextlib import suppress

import structlog
from pydantic import ValidationError

from cellctl.config import HearingSection
from cellctl.listening.ears.events import (
    LINE_LIMIT_BYTES,
    Alive,
    Condition,
    EarsEvent,
    Expect,
    Expecting,
    FromEars,
    Listen,
    Mute,
    Order,
    Segment,
    encode,
)

START_TIMEOUT_S = 20.0
"""For the process to start and to load its detectors (wall time)."""
DOUBT_S = 1.5
"""A process that is silent for so long is told to be lost (wall time) ..."""
SILENCE_S = 6.0
"""... and killed after so long."""
RESTART_WAITS_S = (0.5, 1.0, 2.0, 5.0)
"""Before the process is started again; the last one for ever. Begins anew after a minute's life."""
_LONG_LIFE_S = 60.0
EVENTS_LIMIT = 50
"""Events that wait for the daemon; the oldest utterance is dropped first."""

log = structlog.get_logger(__name__)


class Ears:
    """Live ears: run ``run`` as a task, take events from ``next_event``.

    Args:
        settings: the ``[hearing]`` table; its microphone is not ``none``.
    """

    def __init__(self, settings: HearingSection) -> None:
        self._settings = settings
        self._events: deque[EarsEvent] = deque()
        self._arrived = asyncio.Event()
        self._writer: asyncio.StreamWriter | None = None
        self._process: asyncio.subprocess.Process | None = None
        self._heard_s = 0.0
        self._started = False
        self._doubted = False
        self._condition: Condition | None = None
        """The newest that the process told."""
        self._expecting: Expecting = "request"
        self._muted = False

    @property
    def pid(self) -> int | None:
        """Process id of the ears, while they run."""
        return self._process.pid if self._process is not None else None

    def expect(self, what: Expecting) -> None:
        """Tell what may be said now: that decides how much silence ends an utterance."""
        if what != self._expecting:
            self._expecting = what
            self._send(Expect(what=what))

    def listen(self) -> None:
        """Take what is said next for a request, as after the wake word."""
        self._send(Listen())

    def mute(self, muted: bool) -> None:
        """Close the microphone until further notice, or open it again."""
        self._muted = muted
        self._send(Mute(muted=muted))

    async def next_event(self) -> EarsEvent:
        """Wait for the next event."""
        while not self._events:
            self._arrived.clear()
            await self._arrived.wait()
        return self._events.popleft()

    async def run(self) -> None:
        """Keep the process at work until cancelled."""
        attempts = 0
        while True:
            began_s = time.monotonic()
            try:
                why = await self._live()
            except OSError as error:
                why = f"The ears' process cannot be started: {error}."
            log.warning("ears lost", reason=why)
            self._put(Condition(state="lost", sentence=why))
            if time.monotonic() - began_s > _LONG_LIFE_S:
                attempts = 0
            await asyncio.sleep(RESTART_WAITS_S[min(attempts, len(RESTART_WAITS_S) - 1)])
            attempts += 1

    async def _live(self) -> str:
        """One life of the process; returns how it ended."""
        ours, theirs = socket.socketpair()
        try:
            with theirs:
                process = await asyncio.create_subprocess_exec(
                    *(sys.executable, "-m", "cellctl.listening.ears.child"),
                    *(str(theirs.fileno()), self._settings.model_dump_json()),
                    pass_fds=[theirs.fileno()],
                    stdin=asyncio.subprocess.DEVNULL,
                    stdout=asyncio.subprocess.DEVNULL,
                    stderr=asyncio.subprocess.PIPE,
                )
        except BaseException:
            ours.close()
            raise
        reader, writer = await asyncio.open_connection(sock=ours, limit=LINE_LIMIT_BYTES)
        self._process, self._writer = process, writer
        self._heard_s, self._started, self._doubted = time.monotonic(), False, False
        output = asyncio.create_task(_log_output(process), name="ears-log")
        try:
            self._send(Expect(what=self._expecting))
            self._send(Mute(muted=self._muted))
            return await self._take_in(reader)
        finally:
            self._process = self._writer = None
            with suppress(ProcessLookupError):
                process.kill()
            await process.wait()
            output.cancel()
            await asyncio.gather(output, return_exceptions=True)
            writer.close()
            with suppress(OSError):
                await writer.wait_closed()

    async def _take_in(self, reader: asyncio.StreamReader) -> str:
        """Take in events until the process ends or hangs; returns which."""
        while True:
            line = asyncio.ensure_future(reader.readline())
            try:
                while not (await asyncio.wait({line}, timeout=DOUBT_S / 3))[0]:
                    if self._hangs():
                        return "The ears' process did not answer any more and was ended."
                data = line.result()
            except ValueError:
                return "The ears' process sent more than it may."
            except ConnectionError:
                data = b""
            finally:
                line.cancel()
                with suppress(asyncio.CancelledError, Exception):
                    await line
            if not data.endswith(b"\n"):
                return "The ears' process has ended."
            self._heard_s = time.monotonic()
            if self._doubted and self._condition is not None:
                self._put(self._condition)
            self._doubted = False
            try:
                event = FromEars.validate_json(data)
            except ValidationError as error:
                return f"The ears' process sent something unreadable: {error}."
            if isinstance(event, Alive):
                self._started = True
            else:
                if isinstance(event, Condition):
                    self._condition = event
                self._put(event)

    def _hangs(self) -> bool:
        silent_s = time.monotonic() - self._heard_s
        if not self._started:
            return silent_s > START_TIMEOUT_S
        if silent_s > DOUBT_S and not self._doubted:
            self._doubted = True
            self._put(Condition(state="lost", sentence="The ears' process does not answer."))
        return silent_s > SILENCE_S

    def _put(self, event: EarsEvent) -> None:
        if len(self._events) >= EVENTS_LIMIT:
            log.warning("too much was said at once; the oldest is dropped")
            oldest = next((e for e in self._events if isinstance(e, Segment)), self._events[0])
            self._events.remove(oldest)
        self._events.append(event)
        self._arrived.set()

    def _send(self, order: Order) -> None:
        if self._writer is not None and not self._writer.is_closing():
            with contextlib.suppress(OSError):
                self._writer.write(encode(order))


async def _log_output(process: asyncio.subprocess.Process) -> None:
    """What the sound libraries print is for those who look for trouble."""
    assert process.stderr is not None
    while data := await process.stderr.read(4096):
        log.debug("ears", output=data.decode(errors="replace").rstrip())
