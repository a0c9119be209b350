"""The daemon's end of a process that owns PortAudio.

PortAudio may hang or crash with its sound server, so it never runs in the daemon. The process tells
four times a second that it is alive; one that falls silent is killed and started anew.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import sys
import time
from collections.abc import Iterable
from contextlib import suppress
from typing import Protocol

import structlog
from pydantic import ValidationError

from cellctl.assembly import Value
from cellctl.sound.line import LINE_LIMIT_BYTES, Alive, encode

START_TIMEOUT_S = 20.0
"""For the process to start and to load its models (wall time)."""
DOUBT_S = 1.5
"""A process that is silent for so long is told to be lost (wall time) ..."""
SILENCE_S = 4.5
"""... and killed after so much longer."""
RESTART_WAITS_S = (0.5, 1.0, 2.0, 5.0)
"""Before the process is started again; the last one for ever. Begins anew after a minute's life."""
_LONG_LIFE_S = 60.0
_ALIVE = encode(Alive())

log = structlog.get_logger(__name__)


class Owner(Protocol):
    """Whom a sound process belongs to."""

    def started(self) -> Iterable[Value]:
        """The orders that each new process begins with."""
        ...

    def take(self, line: bytes) -> None:
        """Take what the process told, one line of JSON.

        Raises:
            ValidationError: it is unreadable.
        """
        ...

    def lost(self, why: str) -> None:
        """The process ended, or does not answer."""
        ...

    def answers_again(self) -> None:
        """It did not answer, and does now."""
        ...


class SoundProcess:
    """One supervised process: run ``run`` as a task.

    Args:
        name: for people, as in "The {name}' process has ended."
        module: the process's program, started with the descriptor of its socket and ``settings``.
        settings: JSON.
        owner: gets what it tells.
        doubt_s: how long it may be silent (wall time).
    """

    def __init__(
        self, name: str, module: str, settings: str, owner: Owner, *, doubt_s: float = DOUBT_S
    ) -> None:
        self._name = name
        self._module = module
        self._settings = settings
        self._owner = owner
        self._doubt_s = doubt_s
        self._writer: asyncio.StreamWriter | None = None
        self._process: asyncio.subprocess.Process | None = None
        self._heard_s = 0.0
        self._alive = False
        self._doubted = False

    @property
    def pid(self) -> int | None:
        """Process id, while it runs."""
        return self._process.pid if self._process is not None else None

    def send(self, order: Value) -> None:
        """Give an order; lost while there is no process, for ``Owner.started`` gives the lasting
        ones."""
        if self._writer is not None and not self._writer.is_closing():
            with contextlib.suppress(OSError):
                self._writer.write(encode(order))

    async def run(self) -> None:
        """Keep the process at work until cancelled."""
        attempts = 0
        while True:
            began_s = time.monotonic()
            try:
                why = await self._live()
            except OSError as error:
                why = f"{self._subject} cannot be started: {error}."
            log.warning("sound process lost", process=self._name, reason=why)
            self._owner.lost(why)
            if time.monotonic() - began_s > _LONG_LIFE_S:
                attempts = 0
            await asyncio.sleep(RESTART_WAITS_S[min(attempts, len(RESTART_WAITS_S) - 1)])
            attempts += 1

    @property
    def _subject(self) -> str:
        return f"The process of the {self._name}"

    async def _live(self) -> str:
        """One life of the process; returns how it ended."""
        ours, theirs = socket.socketpair()
        try:
            with theirs:
                process = await asyncio.create_subprocess_exec(
                    *(sys.executable, "-m", self._module),
                    *(str(theirs.fileno()), self._settings),
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
        self._heard_s, self._alive, self._doubted = time.monotonic(), False, False
        output = asyncio.create_task(self._log_output(process), name=f"{self._name} log")
        try:
            for order in self._owner.started():
                self.send(order)
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
                        return f"{self._subject} did not answer any more and was ended."
                data = line.result()
            except ValueError:
                return f"{self._subject} sent more than it may."
            except ConnectionError:
                data = b""
            finally:
                line.cancel()
                with suppress(asyncio.CancelledError, Exception):
                    await line
            if not data.endswith(b"\n"):
                return f"{self._subject} has ended."
            self._heard_s = time.monotonic()
            if self._doubted:
                self._owner.answers_again()
            self._doubted = False
            if data == _ALIVE:
                self._alive = True
                continue
            try:
                self._owner.take(data)
            except ValidationError as error:
                return f"{self._subject} sent something unreadable: {error}."

    def _hangs(self) -> bool:
        silent_s = time.monotonic() - self._heard_s
        if not self._alive:
            return silent_s > START_TIMEOUT_S
        if silent_s > self._doubt_s and not self._doubted:
            self._doubted = True
            self._owner.lost(f"{self._subject} does not answer.")
        return silent_s > self._doubt_s + SILENCE_S

    async def _log_output(self, process: asyncio.subprocess.Process) -> None:
        """What the sound libraries print is for those who look for trouble."""
        assert process.stderr is not None
        while data := await process.stderr.read(4096):
            log.debug(self._name, output=data.decode(errors="replace").rstrip())
