"""``cellctl run``, killed by SIGKILL at a chosen write of its journal.

The product knows nothing of it: SQLite's connections are made such that the process kills itself
just before, or just after, the COMMIT with that number since its start.
"""

from __future__ import annotations

import functools
import multiprocessing
import os
import signal
import sqlite3
import sys
from pathlib import Path
from typing import Any

_COMMIT = "COMMIT"


class _Boundary:
    """Counts the journal's transactions."""

    def __init__(self, when: str, number: int) -> None:
        self._when = when
        self._left = number

    def passes(self, when: str) -> None:
        """Die, if this is the moment."""
        if when == "before":
            self._left -= 1
        if self._left == 0 and when == self._when:
            os.kill(os.getpid(), signal.SIGKILL)


def _connection(boundary: _Boundary) -> type[sqlite3.Connection]:
    class Watched(sqlite3.Connection):
        def execute(self, sql: str, *arguments: Any) -> sqlite3.Cursor:
            if sql != _COMMIT:
                return super().execute(sql, *arguments)
            boundary.passes("before")
            cursor = super().execute(sql, *arguments)
            boundary.passes("after")
            return cursor

    return Watched


def run(config: str, log: str, when: str, number: int) -> None:
    """Be a daemon that dies; the body of a process of its own.

    Args:
        config: its configuration file.
        log: the file that its log is added to.
        when: ``before`` or ``after``.
        number: of the COMMIT.
    """
    sink = os.open(log, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    for stream in (1, 2):
        os.dup2(sink, stream)
    factory = _connection(_Boundary(when, number))
    sqlite3.connect = functools.partial(sqlite3.connect, factory=factory)  # type: ignore[assignment]
    sys.argv = ["cellctl", "run", "--config", config]
    from cellctl.cli.app import main as cellctl  # noqa: PLC0415 - with the connections prepared

    cellctl()


class DyingDaemon:
    """One of them, forked from a process that has everything loaded already: that saves a second
    in each of many lives. It looks like a ``subprocess.Popen`` to whoever watches it."""

    def __init__(self, config: Path, log: Path, when: str, number: int) -> None:
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(["cellctl.cli.app", "cellctl.control.daemon", __name__])
        self._process = context.Process(target=run, args=(str(config), str(log), when, number))
        self._process.start()

    def poll(self) -> int | None:
        """Its exit code; None while it lives."""
        return self._process.exitcode

    def kill(self) -> None:
        """End it at once."""
        self._process.kill()

    def wait(self) -> None:
        """Wait for its end."""
        self._process.join()
        self._process.close()
