"""A supervised worker process: heavy work beside the event loop, never in it.

One call at a time. A call that takes too long, or whose caller goes away, costs the process: it is
killed and the next call starts a fresh one. Nothing here waits for ever.
"""

from __future__ import annotations

import asyncio
import contextlib
import multiprocessing
import signal
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from cellctl.beside import Beside, die_with
from cellctl.errors import CellctlError

T = TypeVar("T")
Progress = Callable[[str], None]

_EXIT_PATIENCE_S = 2.0


class WorkerError(CellctlError):
    """The worker died, took too long, or met a defect."""


def _serve(connection: Connection) -> None:
    """Body of the worker: calls in, progress and results out, until the pipe closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    die_with(0 if parent is None else parent.pid or 0)
    with Beside():
        _answer_calls(connection)


def _answer_calls(connection: Connection) -> None:
    while True:
        try:
            function, arguments, wants_progress = connection.recv()
        except EOFError:
            return
        try:
            keywords: dict[str, Any] = {}
            if wants_progress:
                keywords["progress"] = lambda name: connection.send(("progress", name))
            answer = ("result", function(*arguments, **keywords))
        except CellctlError as error:
            answer = ("refused", error)
        except Exception:  # noqa: BLE001 - every defect travels to the caller as text
            answer = ("defect", traceback.format_exc())
        try:
            connection.send(answer)
        except BrokenPipeError:
            return


def _reap(process: multiprocessing.process.BaseProcess) -> None:
    """Wait for a killed process, so that nothing of it is left."""
    process.join(_EXIT_PATIENCE_S)
    if process.exitcode is not None:
        process.close()


class WorkerProcess:
    """One process for one kind of work.

    Args:
        name: for the log and the process list.
    """

    def __init__(self, name: str) -> None:
        self._name = name
        self._context = multiprocessing.get_context("spawn")
        self._process: multiprocessing.process.BaseProcess | None = None
        self._connection: Connection | None = None
        self._busy = asyncio.Lock()

    @property
    def pid(self) -> int | None:
        """Process id while it runs."""
        return self._process.pid if self._process is not None else None

    async def call(
        self,
        function: Callable[..., T],
        *arguments: object,
        timeout_s: float,
        progress: Progress | None = None,
    ) -> T:
        """Run ``function(*arguments)`` in the worker and return its result.

        Args:
            function: importable by name; all arguments and the result must pickle.
            timeout_s: wall time, the start of the process included.
            progress: receives each name that the function hands to its ``progress`` argument.

        Raises:
            CellctlError: what the function raised on purpose.
            WorkerError: it took too long, died, or met a defect.
        """
        async with self._busy:
            finished = False
            try:
                async with asyncio.timeout(timeout_s):
                    connection = await self._ensure_started()
                    # Large arguments wait for the worker to read them.
                    call = (function, arguments, progress is not None)
                    await asyncio.to_thread(connection.send, call)
                    kind, value = await self._answer(connection, progress)
                finished = True
            except TimeoutError:
                raise WorkerError(
                    f"The {self._name} took longer than {timeout_s:g} s and was ended."
                ) from None
            except (EOFError, BrokenPipeError, ConnectionResetError):
                raise WorkerError(f"The {self._name} died in the middle of its work.") from None
            finally:
                if not finished:
                    await self._kill()
        if kind == "refused":
            raise value
        if kind == "defect":
            raise WorkerError(f"The {self._name} met a defect:\n{value}")
        result: T = value
        return result

    async def close(self) -> None:
        """End the process; safe to repeat."""
        process, connection = self._process, self._connection
        if process is None or connection is None:
            return
        connection.close()
        await asyncio.to_thread(process.join, _EXIT_PATIENCE_S)
        await self._kill()

    async def _ensure_started(self) -> Connection:
        if self._process is not None and not self._process.is_alive():
            await self._kill()
        if self._connection is None:
            ours, theirs = self._context.Pipe()
            process = self._context.Process(
                target=_serve, args=(theirs,), name=self._name, daemon=True
            )
            process.start()
            theirs.close()
            self._process, self._connection = process, ours
        return self._connection

    async def _answer(self, connection: Connection, progress: Progress | None) -> tuple[str, Any]:
        loop = asyncio.get_running_loop()
        readable = asyncio.Event()
        loop.add_reader(connection.fileno(), readable.set)
        try:
            while True:
                await readable.wait()
                readable.clear()
                while connection.poll():
                    kind, value = connection.recv()
                    if kind != "progress":
                        return kind, value
                    if progress is not None:
                        progress(value)
        finally:
            loop.remove_reader(connection.fileno())

    async def _kill(self) -> None:
        process, connection = self._process, self._connection
        self._process = self._connection = None
        if connection is not None:
            with contextlib.suppress(OSError):
                connection.close()
        if process is not None:
            process.kill()
            # A large process takes its time to go, and the loop must not wait for it.
            await asyncio.shield(asyncio.to_thread(_reap, process))
