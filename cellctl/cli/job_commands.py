"""Commands to a running daemon: say, build, yes and no, pause, resume, stop, cancel, ..."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from cellctl.assembly import Role
from cellctl.cli.following import await_question, follow_job
from cellctl.cli.options import ConfigOption, KeyOption, RoleOption, client
from cellctl.cli.replies import show_reply
from cellctl.client import CellClient
from cellctl.errors import ExitStatus, UsageError
from cellctl.messages import ControlReply

WaitOption = Annotated[
    bool, typer.Option("--wait", help="Stay until the job has ended, and show its progress.")
]

_PLAIN = {
    "pause": "Stop at the next safe point.",
    "resume": "Go on after a pause, a stop or a reset.",
    "stop": "Brake now; the part stays in the gripper. This is no emergency stop.",
    "cancel": "End the job; what stands stays.",
    "reset": "Clear a fault; the cell is paused then, and nothing moves.",
    "clear": "Tell that you took apart what stood; its parts are in the stock again.",
}


def read_file(path: Path) -> bytes:
    """The file's content.

    Raises:
        UsageError: it cannot be read, or is empty.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise UsageError(f"{path}: cannot be read: {error.strerror}.") from error
    if not content:
        raise UsageError(f"{path}: the file is empty.")
    return content


def register(app: typer.Typer) -> None:
    """Add the commands."""

    @app.command()
    def say(
        text: Annotated[str | None, typer.Argument(help="What you would say.")] = None,
        wav: Annotated[Path | None, typer.Option(help="A recording to listen to.")] = None,
        wait: WaitOption = False,
        config: ConfigOption = None,
        role: RoleOption = Role.VISITOR,
        key: KeyOption = None,
    ) -> None:
        """Ask the cell for something, in words or with a recording."""
        if (text is None) == (wav is None):
            raise UsageError("Give either TEXT or --wav FILE.")
        with client(config, role, key) as cell:
            cell.subscribe()
            if wav is not None:
                reply = cell.hear(wav.name, read_file(wav))
            else:
                assert text is not None
                reply = cell.say(text)
            show_reply(reply)
            raise typer.Exit(int(_see(cell, reply, wait)))

    @app.command()
    def build(
        file: Annotated[Path, typer.Argument(help="A mesh (glb, stl, obj, ply) or a plan (json).")],
        wait: WaitOption = False,
        config: ConfigOption = None,
        role: RoleOption = Role.OPERATOR,
        key: KeyOption = None,
    ) -> None:
        """Build a mesh or a plan from a file."""
        with client(config, role, key) as cell:
            cell.subscribe()
            reply = cell.build(file.name, read_file(file))
            show_reply(reply)
            raise typer.Exit(int(_see(cell, reply, wait)))

    @app.command()
    def yes(
        config: ConfigOption = None, role: RoleOption = Role.VISITOR, key: KeyOption = None
    ) -> None:
        """Answer "Shall I build it?" with yes."""
        with client(config, role, key) as cell:
            show_reply(cell.confirm(True))

    @app.command()
    def no(
        config: ConfigOption = None, role: RoleOption = Role.VISITOR, key: KeyOption = None
    ) -> None:
        """Answer "Shall I build it?" with no."""
        with client(config, role, key) as cell:
            show_reply(cell.confirm(False))

    @app.command()
    def take_apart(
        wait: WaitOption = False,
        config: ConfigOption = None,
        role: RoleOption = Role.VISITOR,
        key: KeyOption = None,
    ) -> None:
        """Have the arm take apart what stands; its parts go back to the belt."""
        with client(config, role, key) as cell:
            cell.subscribe()
            reply = cell.command("take_apart")
            show_reply(reply)
            raise typer.Exit(int(_see(cell, reply, wait)))

    @app.command()
    def another(
        config: ConfigOption = None, role: RoleOption = Role.VISITOR, key: KeyOption = None
    ) -> None:
        """Answer "Shall I build it?" with: show me another one."""
        with client(config, role, key) as cell:
            cell.subscribe()
            reply = cell.command("another")
            show_reply(reply)
            raise typer.Exit(int(await_question(cell, reply.job_id)))

    for name, text in _PLAIN.items():
        app.command(name, help=text)(_plain(name))


def _plain(name: str) -> Callable[..., None]:
    def command(
        config: ConfigOption = None, role: RoleOption = Role.OPERATOR, key: KeyOption = None
    ) -> None:
        with client(config, role, key) as cell:
            show_reply(cell.command(name))

    return command


def _see(cell: CellClient, reply: ControlReply, wait: bool) -> ExitStatus:
    """Show what becomes of a wish: to the end, or until the cell asks or begins."""
    if wait:
        return follow_job(cell, reply.job_id)
    if reply.state.partition("_")[0] in {"listening", "generating", "validating"}:
        return await_question(cell, reply.job_id)
    return ExitStatus.DONE
