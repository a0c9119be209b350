"""A second process beside one that computes, which takes a share of what can be done at once.

Work is shared out only where somebody stands by: ``with Beside():`` around what computes. Without
it, and on a computer with one processor, everything is done where it is asked for; what comes out
is the same. The second process ends with the first, however that ends.
"""

from __future__ import annotations

import contextlib
import ctypes
import itertools
import os
import signal
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Sequence
from contextvars import ContextVar, Token
from importlib import import_module
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import Any, NamedTuple, Self

_AHEAD = 2
"""So many tasks are given to the second process at once, so that it need not wait for the next."""
_EXIT_PATIENCE_S = 2.0
_PR_SET_PDEATHSIG = 1
"""Of prctl(2)."""
_BODY = "from cellctl.beside import serve; serve()"
_GIVES_WAY = 5
"""Niceness of the second process: what listens and what moves the arm go first."""


class Task(NamedTuple):
    """A call of a pure function that is importable by name; arguments and result pickle. It is made
    again where a process died that had it."""

    function: Callable[..., Any]
    arguments: tuple[object, ...]


_Outcome = tuple[Any, Exception | None]
"""What a task returned, or what it raised."""


def share(tasks: Sequence[Task]) -> list[Any]:
    """Do tasks, some of them in the process that stands by, if one does.

    Args:
        tasks: independent of each other, of some milliseconds each. They are begun here in this
            order, and there from the last one.

    Returns:
        What each returned.

    Raises:
        Whatever the first of them raises that fails, in their order.
    """
    beside = _standing_by.get()
    if beside is not None:
        return beside.share(tasks)
    return [task.function(*task.arguments) for task in tasks]


def stand_by(module: str) -> None:
    """Have the process that stands by, if one does, begin to load a module that will be needed."""
    beside = _standing_by.get()
    if beside is not None:
        beside.start(module)


class Beside:
    """A second process that stands by while this is entered; it is started when it is first asked.

    To be used in one thread of the first process at a time.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._connection: Connection | None = None
        self._loaded: set[str] = set()
        self._loading: set[int] = set()
        self._numbers = itertools.count()
        self._token: Token[Beside | None] | None = None

    def __enter__(self) -> Self:
        self._token = _standing_by.set(self)
        return self

    def __exit__(self, *_: object) -> None:
        assert self._token is not None, "it was entered"
        _standing_by.reset(self._token)
        self._end()

    def start(self, module: str) -> None:
        """Start the process, if there is a processor for it, and load a module there."""
        if len(os.sched_getaffinity(0)) < 2:
            return
        if self._connection is None:
            ours, theirs = Pipe()
            with theirs:
                self._process = subprocess.Popen(  # noqa: S603 - a fixed command
                    [sys.executable, "-c", _BODY, str(theirs.fileno()), str(os.getpid())],
                    pass_fds=[theirs.fileno()],
                    stdin=subprocess.DEVNULL,
                )
            self._connection = ours
        if module not in self._loaded:
            self._loaded.add(module)
            self._loading.add(self._give(Task(_load, (module,))))

    def share(self, tasks: Sequence[Task]) -> list[Any]:
        """See ``share``."""
        found: dict[int, _Outcome] = {}
        left = deque(range(len(tasks)))
        given: dict[int, int] = {}
        while left or given:
            self._collect(found, given, wait=not left)
            if self._connection is None:
                # It has died; what it had is done here.
                left.extend(sorted(given.values()))
                given.clear()
            while left and self._ready and len(given) < _AHEAD:
                index = left.pop()
                given[self._give(tasks[index])] = index
            if left:
                index = left.popleft()
                found[index] = _done(tasks[index])
            if failed := [index for index, (_, error) in found.items() if error is not None]:
                left = deque(index for index in left if index < min(failed))
        return [_value(found[index]) for index in sorted(found)]

    @property
    def _ready(self) -> bool:
        return self._connection is not None and not self._loading

    def _give(self, task: Task) -> int:
        """Number of a task that is done there now; if it has died, that is seen on collecting."""
        number = next(self._numbers)
        if self._connection is not None:
            with contextlib.suppress(BrokenPipeError, ConnectionResetError):
                self._connection.send((number, task))
        return number

    def _collect(self, found: dict[int, _Outcome], given: dict[int, int], *, wait: bool) -> None:
        """Take what has been done there; wait for one where there is nothing else to do."""
        try:
            while self._connection is not None and self._connection.poll(None if wait else 0):
                number, outcome = self._connection.recv()
                self._loading.discard(number)
                if number in given:
                    found[given.pop(number)] = outcome
                    wait = False
        except (EOFError, ConnectionResetError):
            self._end()

    def _end(self) -> None:
        process, connection = self._process, self._connection
        self._process = self._connection = None
        self._loaded.clear()
        self._loading.clear()
        if connection is not None:
            connection.close()
        if process is not None:
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(_EXIT_PATIENCE_S)
            process.kill()
            process.wait()


_standing_by: ContextVar[Beside | None] = ContextVar("standing_by", default=None)


def die_with(parent_pid: int) -> None:
    """End this process when the thread that started it ends, however that does."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if parent_pid != os.getppid():
        os._exit(1)  # it has ended already


def serve() -> None:
    """Body of the second process: tasks in, outcomes out, until the pipe closes.

    Its arguments are the number of its end of the pipe and the process id of the first.
    """
    connection, parent_pid = Connection(int(sys.argv[1])), int(sys.argv[2])
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    die_with(parent_pid)
    os.nice(_GIVES_WAY)
    given: SimpleQueue[tuple[int, Task] | None] = SimpleQueue()
    # Tasks are always taken, also while an outcome waits to be: or both would wait for the other,
    # where one of each is too large for the pipe.
    threading.Thread(target=_take, args=(connection, given), daemon=True).start()
    with contextlib.suppress(BrokenPipeError, ConnectionResetError):
        while (entry := given.get()) is not None:
            number, task = entry
            connection.send((number, _done(task)))


def _take(connection: Connection, given: SimpleQueue[tuple[int, Task] | None]) -> None:
    try:
        while True:
            given.put(connection.recv())
    except (EOFError, ConnectionResetError):
        given.put(None)


def _load(module: str) -> None:
    import_module(module)


def _done(task: Task) -> _Outcome:
    try:
        return task.function(*task.arguments), None
    except Exception as error:  # noqa: BLE001 - raised where the outcome is looked at
        return None, error


def _value(outcome: _Outcome) -> Any:
    value, error = outcome
    if error is not None:
        raise error
    return value
