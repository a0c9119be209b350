"""``cellctl sim``: the emulated cell, its faults and its truth."""

from __future__ import annotations

import asyncio
import json as json_module
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

from cellctl import logs
from cellctl.cli.options import (
    ConfigOption,
    FirmwareFolderOption,
    FirmwareOption,
    configuration,
    with_boards,
)
from cellctl.config import CellConfig
from cellctl.errors import UsageError
from cellctl.feeding.inventory import Counts
from cellctl.sim.client import SimClient
from cellctl.sim.messages import Argument

SpeedOption = Annotated[
    float | None,
    typer.Option(min=0.1, max=100.0, help="Cell seconds per second; else cell.clock_rate."),
]
FaultArgument = Annotated[str, typer.Argument(help="A fault of docs/emulated-cell.md.")]
WithArgument = Annotated[
    list[str] | None, typer.Argument(help="The fault's arguments, as NAME=VALUE.")
]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    group = typer.Typer(help="The emulated cell: robot, conveyor, gripper and world.")
    app.add_typer(group, name="sim")

    @group.callback(invoke_without_command=True)
    def sim(
        context: typer.Context,
        config: ConfigOption = None,
        speed: SpeedOption = None,
        firmware: FirmwareOption = None,
        firmware_folder: FirmwareFolderOption = None,
    ) -> None:
        """Run the emulated cell until Ctrl-C; `cellctl run` with the same file connects to it."""
        context.obj = settings = configuration(config)
        if context.invoked_subcommand is not None:
            return
        from cellctl.sim.process import run_cell  # noqa: PLC0415 - only this command needs it

        _end_point(settings)
        settings = with_boards(settings, firmware, firmware_folder, speed)
        _forget_the_old_world(settings)
        logs.configure()
        asyncio.run(run_cell(settings, settings.cell.clock_rate))

    @group.command()
    def inject(
        context: typer.Context, fault: FaultArgument, arguments: WithArgument = None
    ) -> None:
        """Make a fault happen in the emulated cell."""
        with SimClient(_end_point(context.obj)) as world:
            world.inject(fault, **_parsed(arguments))

    @group.command()
    def clear(context: typer.Context, fault: FaultArgument, arguments: WithArgument = None) -> None:
        """Mend what a fault broke."""
        with SimClient(_end_point(context.obj)) as world:
            world.clear(fault, **_parsed(arguments))

    @group.command()
    def refill(context: typer.Context) -> None:
        """Fill the belt with parts from the stock."""
        with SimClient(_end_point(context.obj)) as world:
            typer.echo(f"{world.refill()} parts laid on the belt.")

    @group.command("clear-workspace")
    def clear_workspace(context: typer.Context) -> None:
        """Take what stands in the workspace to the stock, as a person would."""
        with SimClient(_end_point(context.obj)) as world:
            typer.echo(f"{world.clear_workspace()} parts taken to the stock.")

    @group.command("hand-over")
    def hand_over(context: typer.Context) -> None:
        """Take what stands in the workspace along, as a visitor would."""
        with SimClient(_end_point(context.obj)) as world:
            typer.echo(f"{world.hand_over()} parts taken along.")

    @group.command()
    def truth(context: typer.Context) -> None:
        """Print what is the case in the emulated cell, as JSON."""
        with SimClient(_end_point(context.obj)) as world:
            typer.echo(world.truth().model_dump_json(indent=2))


def _forget_the_old_world(settings: CellConfig) -> None:
    """The emulated world begins anew, so what a journal says of an earlier one is void."""
    from cellctl.control.journal_lock import JournalLock  # noqa: PLC0415 - heavy
    from cellctl.control.journal_rescue import start_anew  # noqa: PLC0415 - heavy

    path = Path(settings.journal.path)
    if not path.exists():
        return
    if JournalLock(path).holder() is not None:
        typer.echo(
            "A daemon runs already and remembers another world: empty its workspace with "
            "`cellctl clear` and count its parts with `cellctl inventory set`.",
            err=True,
        )
        return
    aside = start_anew(
        path,
        Counts.at_first(settings.limits.inventory_parts, settings.feeder.capacity_parts),
        datetime.now(UTC),
    )
    typer.echo(f"A new world begins: the journal of the last one is {aside} now.", err=True)


def _end_point(settings: CellConfig) -> str:
    if settings.emulation is None:
        raise UsageError(
            f"{settings.cell.name} is a real cell; `cellctl sim` is for emulated ones.",
            "Name another configuration, for example --config config/sim.toml.",
        )
    return settings.emulation.control


def _parsed(arguments: list[str] | None) -> dict[str, Argument]:
    parsed: dict[str, Argument] = {}
    for argument in arguments or []:
        name, separator, value = argument.partition("=")
        if not separator or not name:
            raise UsageError(f"{argument!r} is not of the form NAME=VALUE.")
        try:
            decoded = json_module.loads(value)
        except ValueError:
            decoded = value
        parsed[name] = decoded if isinstance(decoded, str | int | float | bool) else value
    return parsed
