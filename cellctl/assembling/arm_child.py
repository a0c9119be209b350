"""The daemon's end of the arm process: starting, talking to, listening to and killing it."""

from __future__ import annotations

import asyncio
import itertools
import socket
import sys
from collections.abc import Callable
from contextlib import suppress

import structlog

from cellctl.assembling.arm import ArmState
from cellctl.assembling.arm_messages import (
    ANSWERS,
    LINE_LIMIT_BYTES,
    STOPPED_CODE,
    Close,
    Connect,
    Done,
    Failed,
    Follow,
    Heartbeat,
    MoveJoints,
    Prepare,
    Report,
    SetOutput,
    Stop,
    Verify,
    WaitInput,
    encode,
)
from cellctl.errors import CellFault

SILENCE_S = 4.0
"""A connected arm process that says nothing for so long (wall time) hangs; it reports its state
some 80 times a second, and a path's upload is the longest that it may be silent."""

_log = structlog.get_logger(__name__)


class ChildLostError(Exception):
    """The arm process is gone or was found hanging; the message says how."""


class StoppedError(Exception):
    """A movement was ended by an order to stop."""


class ArmChild:
    """One life of the arm process. Made by ``start``; ends with ``kill``, or by itself.

    Attributes:
        state: the newest state; None before the first, and after the end.
    """

    def __init__(
        self,
        process: asyncio.subprocess.Process,
        reader: asyncio.StreamReader,
        writer: asyncio.StreamWriter,
        heartbeat_s: float,
        chosen: Callable[[float], None],
    ) -> None:
        self.state: ArmState | None = None
        self._chosen = chosen
        self._process = process
        self._writer = writer
        self._numbers = itertools.count(1)
        self._waiting: dict[int, asyncio.Future[Done]] = {}
        self._lost: str | None = None
        self._watched = False
        self._tasks = [
            asyncio.create_task(self._read(reader), name="arm-read"),
            asyncio.create_task(self._beat(heartbeat_s), name="arm-heartbeat"),
            asyncio.create_task(self._log_output(), name="arm-log"),
        ]

    @classmethod
    async def start(cls, heartbeat_s: float, chosen: Callable[[float], None]) -> ArmChild:
        """Start an arm process.

        Args:
            heartbeat_s: how often it hears that this event loop is alive (wall time).
            chosen: hears where the speed slider is while no movement is being started.
        """
        ours, theirs = socket.socketpair()
        try:
            with theirs:
                process = await asyncio.create_subprocess_exec(
                    sys.executable,
                    "-m",
                    "cellctl.assembling.arm_worker",
                    str(theirs.fileno()),
                    pass_fds=[theirs.fileno()],
                    stdin=asyncio.subprocess.DEVNULL,
                    stdout=asyncio.subprocess.PIPE,
                    stderr=asyncio.subprocess.STDOUT,
                )
        except BaseException:
            ours.close()
            raise
        reader, writer = await asyncio.open_connection(sock=ours, limit=LINE_LIMIT_BYTES)
        return cls(process, reader, writer, heartbeat_s, chosen)

    @property
    def alive(self) -> bool:
        """Whether it can be asked anything."""
        return self._lost is None

    @property
    def pid(self) -> int:
        """Process id."""
        return self._process.pid

    async def ask(
        self,
        order: Connect
        | Prepare
        | Follow
        | MoveJoints
        | Stop
        | SetOutput
        | WaitInput
        | Verify
        | Close,
    ) -> Done:
        """Send an order and wait for its answer; the number is filled in here.

        Raises:
            CellFault: the order failed.
            StoppedError: it was a movement, and an order to stop ended it.
            ChildLostError: the process is gone.
        """
        if self._lost is not None:
            raise ChildLostError(self._lost)
        number = next(self._numbers)
        answer: asyncio.Future[Done] = asyncio.get_running_loop().create_future()
        self._waiting[number] = answer
        try:
            self._writer.write(encode(order.model_copy(update={"number": number})))
            return await answer
        finally:
            del self._waiting[number]

    def watch(self) -> None:
        """From now on silence means that the process hangs, and ends it."""
        self._watched = True

    async def kill(self) -> None:
        """End the process, whatever it does, and everything that belongs to it here."""
        self._lose("It was ended.")
        with suppress(ProcessLookupError):
            self._process.kill()
        await self._process.wait()
        for task in self._tasks:
            task.cancel()
        await asyncio.gather(*self._tasks, return_exceptions=True)
        self._writer.close()
        with suppress(OSError):
            await self._writer.wait_closed()

    async def _read(self, reader: asyncio.StreamReader) -> None:
        try:
            while True:
                async with asyncio.timeout(SILENCE_S if self._watched else None):
                    line = await reader.readline()
                if not line:
                    break
                self._take(line)
        except TimeoutError:
            self._lose(f"It was silent for {SILENCE_S:.0f} s.")
        except OSError as error:
            self._lose(f"Its socket failed: {error}.")
        except ValueError as error:
            # Also what pydantic and an over-long line raise.
            self._lose(f"It sent what cannot be read: {error}.")
        else:
            self._lose("It ended by itself.")

    def _take(self, line: bytes) -> None:
        message = ANSWERS.validate_json(line)
        if isinstance(message, Report):
            self.state = message.state
            self._chosen(message.speed_fraction)
            return
        waiting = self._waiting.get(message.number)
        if waiting is None or waiting.done():
            return
        if isinstance(message, Done):
            waiting.set_result(message)
        elif isinstance(message, Failed) and message.code == STOPPED_CODE:
            waiting.set_exception(StoppedError())
        else:
            waiting.set_exception(CellFault(message.code, message.detail))

    def _lose(self, how: str) -> None:
        if self._lost is not None:
            return
        self._lost = how
        self.state = None
        for waiting in self._waiting.values():
            if not waiting.done():
                waiting.set_exception(ChildLostError(how))

    async def _beat(self, period_s: float) -> None:
        while self._lost is None:
            self._writer.write(encode(Heartbeat()))
            await asyncio.sleep(period_s)

    async def _log_output(self) -> None:
        """What ur_rtde prints; the pipe must never fill up."""
        assert self._process.stdout is not None
        async for line in self._process.stdout:
            _log.info("arm_output", line=line.decode("utf-8", "replace").rstrip())
