"""``cellctl run``, killed by SIGKILL at a chosen write of its journal.

    python -m tests.cell.dying_daemon CONFIG (before|after) NUMBER

The product knows nothing of it: SQLite's connections are made such that the process kills itself
just before, or just after, the COMMIT with that number since its start.
"""

from __future__ import annotations

import functools
import os
import signal
import sqlite3
import sys
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


def main() -> None:
    """Run the daemon with the arguments of the command line."""
    config, when, number = sys.argv[1:]
    factory = _connection(_Boundary(when, int(number)))
    sqlite3.connect = functools.partial(sqlite3.connect, factory=factory)  # type: ignore[assignment]
    sys.argv = ["cellctl", "run", "--config", config, "--log-level", "info"]
    from cellctl.cli.app import main as cellctl  # noqa: PLC0415 - with the connections prepared

    cellctl()


if __name__ == "__main__":
    main()
