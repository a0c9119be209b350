"""What planning is doing, on a terminal, when it takes more than a moment."""

from __future__ import annotations

import threading
from types import TracebackType
from typing import Final, Self

from rich.console import Console
from rich.progress import Progress, SpinnerColumn, TextColumn, TimeElapsedColumn

SILENT_S: Final = 1.0
"""Nothing is shown before this (wall time)."""

_WORDS: Final = {
    "discretising": "cutting the shape into parts",
    "checking": "looking for the nearest shape that holds",
    "sequencing": "finding an order that holds, and the arm's ways",
}


class PlanProgress:
    """A line with a spinner that says which stage is under way; it goes when planning ends.

    It is shown on a terminal only, and only when planning takes longer than ``SILENT_S``.

    Args:
        console: where to show it; best that of standard error, so that output stays clean.
        first: what is done first, in words.
    """

    def __init__(self, console: Console, first: str) -> None:
        self._line = Progress(
            SpinnerColumn(),
            TextColumn("{task.description}"),
            TimeElapsedColumn(),
            console=console,
            transient=True,
        )
        self._task = self._line.add_task(first, total=None)
        self._timer = threading.Timer(SILENT_S, self._show)
        self._timer.daemon = True
        self._shows = console.is_terminal
        self._lock = threading.Lock()
        self._ended = False

    def __enter__(self) -> Self:
        if self._shows:
            self._timer.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._timer.cancel()
        with self._lock:  # it may just now be about to show
            self._ended = True
            if self._line.live.is_started:
                self._line.stop()
        if self._timer.is_alive():
            self._timer.join()

    def stage(self, name: str) -> None:
        """Tell which stage has begun: by the planner's name for it, or in words."""
        self._line.update(self._task, description=_WORDS.get(name, name))

    def _show(self) -> None:
        with self._lock:
            if not self._ended:
                self._line.start()
