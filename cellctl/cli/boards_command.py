"""``cellctl boards``: which serial adapters are plugged in, and how to give one a name."""

from __future__ import annotations

import json as json_module
import re

import typer
from rich.console import Console
from rich.table import Table
from serial.tools import list_ports

from cellctl.cli.options import JsonOption
from cellctl.errors import UsageError

_NAMES = ("conveyor", "gripper")


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def boards(
        rule: str = typer.Option(
            "", metavar="NAME=SERIAL", help="Print the udev rule that names this adapter."
        ),
        json: JsonOption = False,
    ) -> None:
        """List the USB serial adapters with their serial numbers, or print a udev rule for one."""
        if rule:
            typer.echo(udev_rule(rule))
            return
        found = [
            {
                "port": port.device,
                "serial_number": port.serial_number or "",
                "what": port.description or "",
            }
            for port in sorted(list_ports.comports())
            if port.vid is not None
        ]
        if json:
            typer.echo(json_module.dumps(found, indent=2))
        elif not found:
            typer.echo("No USB serial adapter is plugged in.")
        else:
            table = Table("port", "serial number", "what")
            for port in found:
                table.add_row(port["port"], port["serial_number"] or "none", port["what"])
            Console(highlight=False).print(table)


def udev_rule(wish: str) -> str:
    """The rule for ``NAME=SERIAL``.

    Raises:
        UsageError: it is not of that form.
    """
    name, _, serial_number = wish.partition("=")
    # Both go into a rule between quotation marks.
    if name not in _NAMES or not re.fullmatch(r"[A-Za-z0-9_.:-]{1,64}", serial_number):
        raise UsageError(
            f"--rule {wish!r}: must be NAME=SERIAL, with the name {' or '.join(_NAMES)}.",
            "`cellctl boards` lists the serial numbers.",
        )
    return (
        f'SUBSYSTEM=="tty", ENV{{ID_SERIAL_SHORT}}=="{serial_number}", '
        f'SYMLINK+="cellctl-{name}", GROUP="dialout", MODE="0660"'
    )
