"""``cellctl boards``: which serial adapters are plugged in, who is on them, and names for them."""

from __future__ import annotations

import asyncio
import json as json_module
import re
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table
from serial.tools import list_ports

from cellctl import logs
from cellctl.boards.constants import BoardRole
from cellctl.boards.session import Board, BoardLostError, BoardPort
from cellctl.cli.options import ConfigOption, JsonOption, configuration
from cellctl.errors import ConfigError, UsageError

_NAMES = ("conveyor", "gripper")
_BAUD = 115200
_REPLY_TIMEOUT_S = 0.3


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def boards(
        rule: str = typer.Option(
            "", metavar="NAME=SERIAL", help="Print the udev rule that names this adapter."
        ),
        identify: bool = typer.Option(
            False, help="Ask on every port, those of the configuration too, which board is there."
        ),
        config: ConfigOption = None,
        json: JsonOption = False,
    ) -> None:
        """List the USB serial adapters with their serial numbers, or print a udev rule for one.

        Asking stops a belt that moves; a port that a daemon holds is left alone.
        """
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
        if identify:
            logs.configure("error")
            found += [
                {"port": port, "serial_number": "", "what": option}
                for port, option in _configured(config).items()
            ]
            for port in found:
                port["board"] = asyncio.run(who_is_on(port["port"]))
        if json:
            typer.echo(json_module.dumps(found, indent=2))
        elif not found:
            typer.echo("No USB serial adapter is plugged in.")
        else:
            table = Table("port", "serial number", "what", *(["board"] if identify else []))
            for port in found:
                serial_number = port["serial_number"] or "none"
                board = [port["board"]] if identify else []
                table.add_row(port["port"], serial_number, port["what"], *board)
            Console(highlight=False).print(table)


async def who_is_on(port: str) -> str:
    """Which of the cell's boards answers on a port, in words."""
    # The role is what is asked for here: any will do.
    where = BoardPort(BoardRole.CONVEYOR, port, _BAUD, _REPLY_TIMEOUT_S, None, "feeder")
    board = Board(where)
    try:
        found = await board.identify()
    except BoardLostError as error:
        return error.message
    finally:
        board.drop()
    return (
        f"{found.role}, serial number {found.serial_number}, firmware {found.firmware_version}, "
        f"protocol {found.protocol_version}"
    )


def _configured(path: Path | None) -> dict[str, str]:
    """The ports of the cell's configuration, and the option that names each; none without one."""
    try:
        config = configuration(path)
    except ConfigError:
        if path is not None:
            raise
        return {}
    ports = {config.feeder.port: "feeder.port"}
    if config.gripper.port is not None:
        ports[config.gripper.port] = "gripper.port"
    return ports


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
