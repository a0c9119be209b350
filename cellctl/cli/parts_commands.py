"""Commands that tell the cell what became of parts: refill, hand over, missing, counted, ..."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, get_args

import typer

from cellctl.assembly import Cell, Role
from cellctl.cli.inventory_view import show_inventory
from cellctl.cli.options import ConfigOption, JsonOption, KeyOption, RoleOption, client
from cellctl.cli.replies import show_reply
from cellctl.errors import UsageError
from cellctl.messages import (
    Command,
    CountCommand,
    DropWishCommand,
    MissingCommand,
    OwnCommand,
    PartPlace,
    RecoverCommand,
    RefillCommand,
)

COUNTED = ("stock", "belt", "handed_over", "scrap")
"""Places whose parts a person can count; the others are known by what the cell did."""

NoteOption = Annotated[str, typer.Option("--note", help="Kept in the journal with it.")]


def register(app: typer.Typer) -> None:
    """Add the commands."""

    @app.command()
    def refill(
        parts: Annotated[
            int | None, typer.Argument(min=1, help="How many; else as many as the belt takes.")
        ] = None,
        config: ConfigOption = None,
        key: KeyOption = None,
    ) -> None:
        """Tell that parts from the stock were laid on the belt."""
        tell(RefillCommand(parts=parts), config, key)

    @app.command("hand-over")
    def hand_over(
        config: ConfigOption = None, role: RoleOption = Role.VISITOR, key: KeyOption = None
    ) -> None:
        """Tell that somebody takes the finished object along."""
        with client(config, role, key) as cell:
            reply = cell.command("hand_over")
        show_reply(reply)

    @app.command()
    def wishes(
        drop: Annotated[
            int | None, typer.Option("--drop", metavar="N", help="Forget the wish of this number.")
        ] = None,
        config: ConfigOption = None,
        key: KeyOption = None,
    ) -> None:
        """Show the wishes that wait for their turn, or have one of them forgotten."""
        if drop is not None:
            tell(DropWishCommand(ticket=drop), config, key)
            return
        with client(config, Role.VISITOR, key) as cell:
            waiting = cell.snapshot().dialogue.queue
        for entry in waiting:
            typer.echo(f"{entry.ticket}  {entry.wish}  {entry.name}".rstrip())
        if not waiting:
            typer.echo("Nobody waits.")

    @app.command()
    def recover(
        part: Annotated[
            str, typer.Argument(help=f"Where it is: {', '.join(get_args(PartPlace))}.")
        ],
        config: ConfigOption = None,
        key: KeyOption = None,
    ) -> None:
        """Tell where the part is that was on its way when the cell was cut off."""
        if part not in get_args(PartPlace):
            raise UsageError(
                f"{part!r} is no place of a part.", f"Say one of: {', '.join(get_args(PartPlace))}."
            )
        tell(RecoverCommand.model_validate({"part": part}), config, key)

    @app.command()
    def scrap(config: ConfigOption = None, key: KeyOption = None) -> None:
        """Write off the part that was on its way; the build goes on with another one."""
        tell(RecoverCommand(part="scrap"), config, key)

    @app.command()
    def missing(
        cells: Annotated[list[str], typer.Argument(help="Cells as X,Y,Z, for example 2,3,0.")],
        config: ConfigOption = None,
        key: KeyOption = None,
    ) -> None:
        """Tell that parts of the structure are gone; a build that goes on places them again."""
        tell(MissingCommand(cells=tuple(_cell(text) for text in cells)), config, key)

    group = typer.Typer(help="Where the parts are, and corrections of it.")
    app.add_typer(group, name="inventory")

    @group.callback(invoke_without_command=True)
    def inventory(
        context: typer.Context,
        config: ConfigOption = None,
        json: JsonOption = False,
        key: KeyOption = None,
    ) -> None:
        """Show where the parts are, or correct it."""
        if context.invoked_subcommand is None:
            show_inventory(config, key, json)

    @group.command("set")
    def count(
        counted: Annotated[
            list[str], typer.Argument(help=f"PLACE=NUMBER; places: {', '.join(COUNTED)}.")
        ],
        note: NoteOption = "",
        config: ConfigOption = None,
        key: KeyOption = None,
    ) -> None:
        """Tell how many parts were counted somewhere; what is missing then is unknown."""
        tell(CountCommand.model_validate({**_counts(counted), "note": note}), config, key)

    @group.command()
    def own(
        parts: Annotated[
            int,
            typer.Argument(min=1, max=1000, help="How many there are in all, wherever they are."),
        ],
        note: NoteOption = "",
        config: ConfigOption = None,
        key: KeyOption = None,
    ) -> None:
        """Tell how many parts there are in all, after some were bought or given away."""
        tell(OwnCommand(parts=parts, note=note), config, key)


def tell(command: Command, config: Path | None, key: Path | None) -> None:
    """Have the cell write something down, and say what it believes then."""
    with client(config, Role.OPERATOR, key) as cell:
        reply = cell.request(command)
        show_reply(reply)


def _cell(text: str) -> Cell:
    try:
        x, y, z = (int(part) for part in text.split(","))
    except ValueError:
        raise UsageError(f"{text!r} is no cell.", "Write it as X,Y,Z, for example 2,3,0.") from None
    return Cell(x, y, z)


def _counts(texts: list[str]) -> dict[str, int]:
    counts: dict[str, int] = {}
    for text in texts:
        place, _, number = text.partition("=")
        if place not in COUNTED or not number.isdecimal():
            raise UsageError(
                f"{text!r} is no count.", f"Write PLACE=NUMBER; places: {', '.join(COUNTED)}."
            )
        counts[place] = int(number)
    return counts
