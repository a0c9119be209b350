"""``cellctl hand``: move something by hand while the cell is paused."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from cellctl.assembly import Cell, Role
from cellctl.cli.options import ConfigOption, KeyOption, client
from cellctl.cli.replies import show_reply
from cellctl.messages import HandCommand

PATIENCE_S = 130.0
"""For the longest movement (wall time)."""

_PLAIN: dict[str, str] = {
    "home": "Bring the arm home, by a way that keeps clear of everything.",
    "rise": "Raise the arm, slowly and straight, above everything that stands.",
    "retreat": "Raise the arm until nothing that stands is as high.",
    "close": "Close the latch, when nothing is in it.",
    "index": "Bring one part to the pick station.",
    "check-lines": "Open and close the empty latch, and see that both its lines work.",
    "above-station": "Bring the arm above the pick station, to look at it.",
}

SpeedOption = Annotated[
    float, typer.Option("--speed", min=1.0, max=100.0, help="Percent of the speed of a build.")
]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    group = typer.Typer(
        help="Move something by hand; the cell must be paused. Every way is checked before.",
        no_args_is_help=True,
    )
    app.add_typer(group, name="hand")
    for name, text in _PLAIN.items():
        group.command(name, help=text)(_plain(name.replace("-", "_")))

    @group.command("open")
    def open_latch(
        part_held: Annotated[
            bool,
            typer.Option(help="Somebody holds the part in it, and takes it to the stock."),
        ] = False,
        config: ConfigOption = None,
        key: KeyOption = None,
    ) -> None:
        """Open the latch."""
        order(HandCommand(move="open", part_held=part_held), config, key)

    @group.command("above-cell")
    def above_cell(
        x: int, y: int, z: int,
        speed: SpeedOption = 100.0, config: ConfigOption = None, key: KeyOption = None,
    ) -> None:  # fmt: skip
        """Bring the arm above a cell of the workspace, to look at it."""
        command = HandCommand(move="above_cell", cell=Cell(x, y, z), speed_fraction=speed / 100.0)
        order(command, config, key)

    @group.command(context_settings={"ignore_unknown_options": True})
    def jog(
        x_mm: Annotated[float, typer.Argument(help="Along x of the cell frame.")] = 0.0,
        y_mm: Annotated[float, typer.Argument(help="Along its y.")] = 0.0,
        z_mm: Annotated[float, typer.Argument(help="Upward.")] = 0.0,
        turn: Annotated[float, typer.Option(help="Degrees about the vertical.")] = 0.0,
        config: ConfigOption = None,
        key: KeyOption = None,
    ) -> None:
        """Move the arm slowly by one step, along one axis or about the vertical."""
        command = HandCommand(
            move="jog",
            delta_m=(x_mm / 1000.0, y_mm / 1000.0, z_mm / 1000.0),
            turn_rad=math.radians(turn),
        )
        order(command, config, key)


def _plain(move: str) -> Callable[..., None]:
    def command(
        speed: SpeedOption = 100.0, config: ConfigOption = None, key: KeyOption = None
    ) -> None:
        order(
            HandCommand.model_validate({"move": move, "speed_fraction": speed / 100.0}),
            config,
            key,
        )

    return command


def order(command: HandCommand, config: Path | None, key: Path | None) -> None:
    """Have the cell carry a movement out, and tell what it did."""
    with client(config, Role.OPERATOR, key) as cell:
        reply = cell.request(command, timeout_s=PATIENCE_S)
        show_reply(reply)
