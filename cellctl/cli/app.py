"""The command ``cellctl``: one sub-command for each thing a person may want.

Every command ends with a status of ``ExitStatus``; errors go to standard error and say what is
wrong, where, and what to do about it.
"""

from __future__ import annotations

import importlib
import os
import sys
import traceback

import typer
from rich.console import Console
from rich.text import Text

from cellctl import __version__
from cellctl.errors import CellctlError, ExitStatus

COMMANDS: dict[str, tuple[str, ...]] = {
    "run_command": ("run",),
    "demo_command": ("demo",),
    "understand_command": ("understand",),
    "design_command": ("design",),
    "catalogue_command": ("catalogue",),
    "plan_command": ("plan",),
    "paper_command": ("paper",),
    "job_commands": (
        "say",
        "build",
        "yes",
        "no",
        "take-apart",
        "another",
        "pause",
        "resume",
        "stop",
        "cancel",
        "reset",
        "clear",
    ),
    "parts_commands": ("refill", "hand-over", "wishes", "recover", "scrap", "missing", "inventory"),
    "gripper_commands": ("gripper",),
    "hand_commands": ("hand",),
    "status_commands": ("status", "watch"),
    "faults_command": ("faults",),
    "history_commands": ("history",),
    "doctor_command": ("doctor",),
    "commission_command": ("commission",),
    "calibrate_command": ("calibrate",),
    "ears_commands": ("listen", "mute", "unmute", "microphone"),
    "voice_commands": ("voice",),
    "sim_commands": ("sim",),
    "config_commands": ("config",),
    "journal_commands": ("journal",),
    "keys_commands": ("keys",),
    "kiosk_command": ("kiosk",),
    "backup_commands": ("backup", "restore"),
    "models_commands": ("models",),
    "boards_command": ("boards",),
    "screen_command": ("screen",),
}
"""The modules in this folder in the order of the help, and what commands each of them has."""


def command_line(wanted: str | None = None) -> typer.Typer:
    """The command line.

    Args:
        wanted: only the module of this command is loaded, if there is one: to load them all takes
            longer than what most of them do.
    """
    app = typer.Typer(
        name="cellctl",
        help="Runs a robot cell that builds spoken wishes from reusable magnetic voxels.",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode="rich",
    )
    app.callback()(_root)
    modules = [module for module, names in COMMANDS.items() if wanted in names] or COMMANDS
    for module in modules:
        importlib.import_module(f"cellctl.cli.{module}").register(app)
    return app


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"cellctl {__version__}")
        raise typer.Exit


def _root(
    version: bool = typer.Option(
        False, "--version", callback=_version, is_eager=True, help="Show the version and exit."
    ),
) -> None:
    """Runs a robot cell that builds spoken wishes from reusable magnetic voxels."""


def main() -> None:
    """Entry point of the console script."""
    completing = "_CELLCTL_COMPLETE" in os.environ
    try:
        command_line(sys.argv[1] if len(sys.argv) > 1 and not completing else None)()
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
