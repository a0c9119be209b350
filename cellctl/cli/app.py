"""The command ``cellctl``: one sub-command for each thing a person may want.

Every command ends with a status of ``ExitStatus``; errors go to standard error and say what is
wrong, where, and what to do about it.
"""

from __future__ import annotations

import sys
import traceback

import typer
from rich.console import Console
from rich.text import Text

from cellctl import __version__
from cellctl.cli import (
    backup_commands,
    boards_command,
    calibrate_command,
    catalogue_command,
    commission_command,
    config_commands,
    demo_command,
    design_command,
    doctor_command,
    ears_commands,
    faults_command,
    gripper_commands,
    hand_commands,
    history_commands,
    job_commands,
    journal_commands,
    keys_commands,
    kiosk_command,
    models_commands,
    paper_command,
    parts_commands,
    plan_command,
    run_command,
    screen_command,
    sim_commands,
    status_commands,
    understand_command,
    voice_commands,
)
from cellctl.errors import CellctlError, ExitStatus

app = typer.Typer(
    name="cellctl",
    help="Runs a robot cell that builds spoken wishes from reusable magnetic voxels.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"cellctl {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Show the version and exit."
    ),
) -> None:
    """Runs a robot cell that builds spoken wishes from reusable magnetic voxels."""


for module in (
    run_command,
    demo_command,
    understand_command,
    design_command,
    catalogue_command,
    plan_command,
    paper_command,
    job_commands,
    parts_commands,
    gripper_commands,
    hand_commands,
    status_commands,
    faults_command,
    history_commands,
    doctor_command,
    commission_command,
    calibrate_command,
    ears_commands,
    voice_commands,
    sim_commands,
    config_commands,
    journal_commands,
    keys_commands,
    kiosk_command,
    backup_commands,
    models_commands,
    boards_command,
    screen_command,
):
    module.register(app)


def main() -> None:
    """Entry point of the console script."""
    try:
        app()
    except CellctlError as error:
        console = Console(stderr=True, highlight=False, soft_wrap=True)
        console.print("[bold red]error:[/]", Text(error.message))
        if error.hint:
            console.print("[bold]what to do:[/]", Text(error.hint))
        sys.exit(int(error.exit_status))
    except KeyboardInterrupt:
        sys.exit(130)
    except Exception:  # noqa: BLE001 - the last resort: show it, end with its status
        traceback.print_exc()
        sys.exit(int(ExitStatus.INTERNAL))
