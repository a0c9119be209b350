"""The line that says what planning does, when it takes long."""

from __future__ import annotations

import io
import time

from rich.console import Console

from cellctl.cli.plan_progress import SILENT_S, PlanProgress


def shown(seconds: float, *, terminal: bool) -> str:
    screen = io.StringIO()
    console = Console(file=screen, force_terminal=terminal, width=100)
    with PlanProgress(console, "reading") as progress:
        progress.stage("discretising")
        time.sleep(seconds)
    return screen.getvalue()


def test_a_short_plan_shows_nothing() -> None:
    assert shown(0.0, terminal=True) == ""


def test_a_long_plan_says_what_it_does_on_a_terminal_only() -> None:
    assert "cutting the shape into parts" in shown(SILENT_S + 0.5, terminal=True)
    assert shown(SILENT_S + 0.2, terminal=False) == ""
