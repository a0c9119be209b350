"""``cellctl status`` and ``cellctl watch``: what the cell is doing."""

from __future__ import annotations

import typer
from rich.console import Console
from rich.table import Table

from cellctl.assembly import Role
from cellctl.cli.following import follower
from cellctl.cli.options import ConfigOption, JsonOption, KeyOption, client
from cellctl.cli.replies import state_words
from cellctl.errors import CellctlError
from cellctl.messages import BoardData, Snapshot

_SILENCE_S = 15.0


def register(app: typer.Typer) -> None:
    """Add the commands."""

    @app.command()
    def status(
        config: ConfigOption = None, json: JsonOption = False, key: KeyOption = None
    ) -> None:
        """Show what the cell is doing, once."""
        with client(config, Role.VISITOR, key) as cell:
            snapshot = cell.snapshot()
        if json:
            typer.echo(snapshot.model_dump_json(indent=2))
        else:
            _show(Console(highlight=False), snapshot)

    @app.command()
    def watch(config: ConfigOption = None, json: JsonOption = False, key: KeyOption = None) -> None:
        """Show what the cell does, as it happens, until Ctrl-C."""
        console = Console(highlight=False)
        with client(config, Role.VISITOR, key) as cell:
            cell.subscribe()
            if json:
                for message in cell.messages(_SILENCE_S):
                    typer.echo(message.model_dump_json())
            else:
                _show(console, cell.snapshot())
                with follower(console) as view:
                    for message in cell.messages(_SILENCE_S):
                        view.show(message)
        raise CellctlError("The daemon has fallen silent.", "Look at its log.")


def board_line(board: BoardData) -> str:
    """Who a board is, on one line."""
    return (
        f"{board.port}: serial number {board.serial_number}, firmware {board.firmware_version}, "
        f"protocol {board.protocol_version}"
    )


def _show(console: Console, snapshot: Snapshot) -> None:
    table = Table.grid(padding=(0, 2))
    table.add_row("[bold]cell[/]", f"{snapshot.cell} ({snapshot.kind}), cellctl {snapshot.version}")
    table.add_row("[bold]state[/]", state_words(snapshot.state.state))
    table.add_row("", snapshot.state.sentence)
    job = snapshot.job
    if job is not None:
        heard = job.utterance.text if job.utterance is not None else "a file"
        table.add_row("[bold]job[/]", f"{job.job_id}: {job.title or heard} {job.outcome}")
        if job.pace is not None:
            table.add_row("", f"a trial of {job.pace}")
        if job.parts_total:
            table.add_row("", f"{job.parts_placed} of {job.parts_total} parts placed")
    if snapshot.fault.entry is not None:
        table.add_row("[bold red]fault[/]", f"{snapshot.fault.entry.code} {snapshot.fault.detail}")
        for line in snapshot.fault.later:
            table.add_row("", f"then: {line}")
    held = ", ".join(f"{count} {place}" for place, count in snapshot.inventory.items() if count)
    table.add_row("[bold]parts[/]", held)
    arm = f"{snapshot.arm.safety}, {'moving' if snapshot.arm.moving else 'at rest'}"
    table.add_row("[bold]robot[/]", arm if snapshot.arm.connected else "not connected")
    if snapshot.carrying is not None:
        measured = snapshot.carrying_measured or "not measured"
        table.add_row("[bold]carrying[/]", f"at most {snapshot.carrying} ({measured})")
    gripper, belt = snapshot.gripper, snapshot.conveyor
    table.add_row("[bold]gripper[/]", f"holds {gripper.holding}")
    if gripper.board is not None:
        table.add_row("", board_line(gripper.board))
    if gripper.notice is not None:
        table.add_row("", f"{gripper.notice.title} {gripper.notice.remedy}")
    table.add_row("[bold]belt[/]", belt.activity if belt.connected else "not connected")
    if belt.board is not None:
        table.add_row("", board_line(belt.board))
    ears = f"{snapshot.ears.state} {snapshot.ears.device}".strip()
    table.add_row("[bold]ears[/]", f"{ears}; recogniser: {snapshot.recogniser}")
    if snapshot.ears.sentence:
        table.add_row("", snapshot.ears.sentence)
    voice = snapshot.voice
    table.add_row("[bold]voice[/]", f"{voice.state} {voice.device} {voice.voice}".strip())
    if voice.notice is not None:
        table.add_row("", f"{voice.sentence} {voice.notice.remedy}".strip())
    blocked_ms = snapshot.health.loop_blocked_p99_s * 1000
    table.add_row("[bold]daemon[/]", f"control loop blocked for {blocked_ms:.1f} ms at most (p99)")
    console.print(table)
