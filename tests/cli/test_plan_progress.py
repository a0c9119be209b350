"""The line that says what planning does, when it takes long."""

from __future__ import annotations

import io
import threading
import time

from rich.console import Console

from cellctl.cli.plan_progress import PlanProgress

_PATIENCE_S = 30.0


def screen_and_console(*, terminal: bool) -> tuple[io.StringIO, Console]:
    screen = io.StringIO()
    return screen, Console(file=screen, force_terminal=terminal, width=100)


def test_a_short_plan_shows_nothing() -> None:
    screen, console = screen_and_console(terminal=True)
    with PlanProgress(console, "reading") as progress:
        progress.stage("discretising")
    assert screen.getvalue() == ""


def test_a_long_plan_says_what_it_does_on_a_terminal() -> None:
    screen, console = screen_and_console(terminal=True)
    deadline_s = time.monotonic() + _PATIENCE_S
    with PlanProgress(console, "reading") as progress:
        progress.stage("discretising")
        while "cutting the shape into parts" not in screen.getvalue():
            assert time.monotonic() < deadline_s


def test_without_a_terminal_nothing_waits_to_be_shown() -> None:
    screen, console = screen_and_console(terminal=False)
    before = threading.active_count()
    with PlanProgress(console, "reading") as progress:
        progress.stage("discretising")
        assert threading.active_count() == before
    assert screen.getvalue() == ""
