"""``cellctl gripper``: what the gripper's board tells on its serial port, and its calibration."""

from __future__ import annotations

import json as json_module
from typing import Annotated

import typer

from cellctl.assembly import Role
from cellctl.boards.constants import PULSE_MAX_US, PULSE_MIN_US, TRAVEL_MAX_MS, TRAVEL_MIN_MS
from cellctl.cli.options import ConfigOption, JsonOption, KeyOption, client
from cellctl.cli.status_commands import board_line
from cellctl.messages import GripperCommand

_PULSES = f"{PULSE_MIN_US} to {PULSE_MAX_US} us"


def register(app: typer.Typer) -> None:
    """Add the commands."""
    group = typer.Typer(
        help="Ask the gripper's board, and calibrate it; nothing moves.", no_args_is_help=True
    )
    app.add_typer(group, name="gripper")

    @group.command()
    def show(config: ConfigOption = None, json: JsonOption = False, key: KeyOption = None) -> None:
        """Show its calibration, its counters and its supply."""
        with client(config, Role.OPERATOR, key) as cell:
            text = cell.request(GripperCommand(do="show")).message
            gripper = cell.snapshot().gripper
        if json:
            typer.echo(json_module.dumps(gripper.model_dump(mode="json"), indent=2))
            return
        board = gripper.board
        if board is not None:
            typer.echo(board_line(board))
        typer.echo(text)
        typer.echo(f"resets since the daemon began: {gripper.resets}")

    @group.command("test")
    def self_test(config: ConfigOption = None, key: KeyOption = None) -> None:
        """Have it test itself, without moving anything."""
        _ask(GripperCommand(do="test"), config, key)

    @group.command("set")
    def set_calibration(
        latch_pulse: Annotated[
            int | None, typer.Option(help=f"Pulse of the closed latch, {_PULSES}.")
        ] = None,
        unlatch_pulse: Annotated[
            int | None, typer.Option(help=f"Pulse of the open latch, {_PULSES}.")
        ] = None,
        travel: Annotated[
            int | None,
            typer.Option(
                help=f"Time for the servo to turn, {TRAVEL_MIN_MS} to {TRAVEL_MAX_MS} ms."
            ),
        ] = None,
        config: ConfigOption = None,
        key: KeyOption = None,
    ) -> None:
        """Set its calibration, from the next time the latch moves until it loses power."""
        wanted = GripperCommand(
            do="set", latch_pulse_us=latch_pulse, unlatch_pulse_us=unlatch_pulse, travel_ms=travel
        )
        _ask(wanted, config, key)

    @group.command()
    def keep(config: ConfigOption = None, key: KeyOption = None) -> None:
        """Keep the calibration that is set, in its EEPROM."""
        _ask(GripperCommand(do="keep"), config, key)

    @group.command()
    def clear(config: ConfigOption = None, key: KeyOption = None) -> None:
        """Clear a fault that the board has latched."""
        _ask(GripperCommand(do="clear"), config, key)


def _ask(command: GripperCommand, config: ConfigOption, key: KeyOption) -> None:
    with client(config, Role.OPERATOR, key) as cell:
        typer.echo(cell.request(command).message)
