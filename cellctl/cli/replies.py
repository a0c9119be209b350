"""What a cell answers, and the state that it is in, as people read them."""

from __future__ import annotations

import typer

from cellctl.messages import ControlReply


def state_words(state: str) -> str:
    """``listening: interpreting`` of ``listening_interpreting``."""
    return state.replace("_", ": ")


def show_reply(reply: ControlReply) -> None:
    """Print what was answered, and the state that came of it."""
    typer.echo(f"{reply.message} [{state_words(reply.state)}]")
