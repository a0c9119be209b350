"""``cellctl screen``: what the cell does, in large, on a screen of its own."""

from __future__ import annotations

import typer
from rich.align import Align
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.panel import Panel
from rich.progress_bar import ProgressBar
from rich.text import Text

from cellctl.assembly import Role
from cellctl.cli.options import ConfigOption, client
from cellctl.cli.replies import state_words
from cellctl.client import CellClient, NoDaemonError
from cellctl.messages import Snapshot

_LOOK_AGAIN_S = 2.0
"""The picture is drawn anew at least this often (wall time)."""
_ANSWER_S = 3.0


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def screen(config: ConfigOption = None) -> None:
        """Fill a terminal with what the cell does, and wait for a daemon that is not there."""
        console = Console(highlight=False)
        with Live(console=console, screen=True, auto_refresh=False) as live:
            while True:
                # A client of its own for each life of the daemon.
                with client(config, Role.VISITOR) as cell:
                    live.update(_waiting(), refresh=True)
                    _follow(cell, live)


def _follow(cell: CellClient, live: Live) -> None:
    """Show what one daemon does until it does not answer."""
    try:
        cell.subscribe()
        snapshot = cell.wait_ready(_ANSWER_S)
        while True:
            live.update(picture(snapshot), refresh=True)
            for message in cell.messages(_LOOK_AGAIN_S):
                if message.topic != "arm":  # the arm tells of itself many times a second
                    break
            snapshot = cell.wait_ready(_ANSWER_S)
    except NoDaemonError:
        return


def _waiting() -> RenderableType:
    return _page("Please wait", "The cell is not at work.", "yellow", None)


def picture(snapshot: Snapshot) -> RenderableType:
    """One page for the people in the room: state, sentence, how far the object is."""
    state = snapshot.state.state
    top = state.split("_", maxsplit=1)[0]
    colour = {"fault": "red", "paused": "yellow", "idle": "green"}.get(top, "cyan")
    sentence = snapshot.state.sentence
    if snapshot.dialogue.waits is not None:
        sentence = snapshot.dialogue.waits.text
    job = snapshot.job
    bar: RenderableType | None = None
    if job is not None and job.parts_total and not job.outcome:
        bar = Group(
            Align.center(Text(f"{job.parts_placed} of {job.parts_total} parts")),
            Align.center(ProgressBar(job.parts_total, job.parts_placed, width=50)),
        )
    return _page(state_words(state), sentence, colour, bar)


def _page(title: str, sentence: str, colour: str, bar: RenderableType | None) -> RenderableType:
    lines: list[RenderableType] = [
        Align.center(Text(title, style=f"bold {colour}")),
        Text(),
        Align.center(Text(sentence, justify="center")),
    ]
    if bar is not None:
        lines += [Text(), bar]
    return Panel(Align.center(Group(*lines), vertical="middle"), border_style=colour)
