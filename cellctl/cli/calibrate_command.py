"""``cellctl calibrate``: measure what the configuration says of a cell, with a person at it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from cellctl.assembling.poses import Matrix, inverse, to_matrix
from cellctl.assembly import Pace, Role
from cellctl.cli.frames_walk import MEASURED, FramesWalk, Touch
from cellctl.cli.job_commands import read_file
from cellctl.cli.options import ConfigOption, KeyOption, client
from cellctl.cli.speed_walk import PAPERS, SpeedWalk, best, beyond, column, values_of
from cellctl.client import CellClient
from cellctl.config import CellConfig, find_config, load_config
from cellctl.config.rewriting import NewValues, difference, replace_file, rewritten
from cellctl.errors import ExitStatus, RefusedError, UsageError
from cellctl.messages import CalibratedCommand

PinOption = Annotated[
    float,
    typer.Option(
        "--pin-m",
        min=0.0,
        max=0.5,
        help="How far the tip that touches is below the TCP; 0: the gripper's own face touches.",
    ),
]
ObjectOption = Annotated[
    Path | None,
    typer.Option(
        "--object", help="A mesh, plan or cells to build, as for `cellctl build`; a column of two."
    ),
]
TimesOption = Annotated[int, typer.Option(min=1, max=100, help="How often each pace is tried.")]
PacesOption = Annotated[
    list[str] | None,
    typer.Option(
        "--pace",
        metavar="V,A",
        help="A pace to try, in m/s and m/s2, such as 1.5,0.75; may be given again and again. "
        "Without any: the eight of the paper's table.",
    ),
]


def register(app: typer.Typer) -> None:
    """Add the commands."""
    calibrate = typer.Typer(help="Measure what the configuration says of the cell.")
    app.add_typer(calibrate, name="calibrate")

    @calibrate.command()
    def frames(config: ConfigOption = None, key: KeyOption = None, pin_m: PinOption = 0.1) -> None:
        """Measure tool, base, pedestal and feeder by touching known points.

        Pause the cell first. Guide the arm by hand, on the pendant, or with `cellctl hand jog`;
        nothing moves by itself.
        Shows what would change in the configuration, and changes it only after a yes. The file as
        it was is kept beside it.
        """
        _need_terminal("frames")
        path = find_config(config)
        settings = load_config(path)
        with client(config, Role.OPERATOR, key) as cell:
            prepare(path, settings, cell)
            measured = FramesWalk(settings, Terminal(settings, cell), pin_m).run()
            written = offer(path, measured.values, typer.confirm)
            note = f"frames measured and {'written' if written else 'not written'}: "
            note += "; ".join(measured.report)
            cell.request(CalibratedCommand(what="frames", note=note[:1000]))

    @calibrate.command()
    def speed(
        config: ConfigOption = None,
        key: KeyOption = None,
        thing: ObjectOption = None,
        times: TimesOption = 1,
        pace: PacesOption = None,
    ) -> None:
        """Find out how fast parts may be carried and set down, by building at several paces.

        The paper's trial: at each speed and acceleration the object is built on the square path and
        taken apart. Stay at the emergency stop: parts fall. Pause, stop and cancel work as ever;
        Ctrl-C cancels the trial. The quickest pace at which everything stood each time is shown as
        the limit for movements with a part, and is written only after a yes. Paces beyond what
        the cell was commissioned with are tried only after a yes.
        """
        _need_terminal("speed")
        path = find_config(config)
        settings = load_config(path)
        paces = [read_pace(text) for text in pace] if pace else PAPERS
        name = thing.name if thing is not None else "column of two.json"
        content = read_file(thing) if thing is not None else column(settings.voxel.pitch_m)
        need_consent(paces, settings, typer.confirm)
        with client(config, Role.OPERATOR, key) as cell:
            walk = SpeedWalk(cell, _Standing(), name=name, content=content, times=times)
            try:
                found = walk.run(paces)
            except (KeyboardInterrupt, typer.Abort):
                _cancel(cell)
                raise
            chosen = best(found)
            if chosen is None:
                typer.echo("At no pace, with all slower ones, did everything stand.")
                typer.echo("Nothing was changed.")
                raise typer.Exit(int(ExitStatus.DIFFERS))
            written = False
            try:
                written = offer(path, values_of(chosen, name), typer.confirm)
            finally:
                note = f"limit for carrying {'written' if written else 'not written'}: {chosen}"
                cell.request(CalibratedCommand(what="speed", note=note))


def _cancel(cell: CellClient) -> None:
    """End the trial under way; where that is not possible, say so."""
    try:
        typer.echo(f"Cancelling the trial. {cell.command('cancel').message}")
    except RefusedError as refused:
        typer.echo(f"The trial was not cancelled. {refused}")


def need_consent(
    paces: Sequence[Pace], settings: CellConfig, agreed: Callable[[str], bool]
) -> None:
    """Name the paces that exceed what the cell was commissioned with, and ask whether to try them.

    Args:
        paces: what is to be tried.
        settings: the cell as it is configured.
        agreed: asks a question that is answered with yes or no.

    Raises:
        RefusedError: no.
    """
    robot = settings.robot
    limit = Pace(speed_m_s=robot.travel_speed_m_s, acceleration_m_s2=robot.travel_acceleration_m_s2)
    faster = beyond(paces, limit)
    if not faster:
        return
    typer.echo(f"The cell was commissioned with {limit}. With a part, these trials exceed that:")
    for pace in faster:
        typer.echo(f"   {pace}")
    if not agreed("Is everybody out of reach, and may the arm go so fast?"):
        raise RefusedError(
            "Paces beyond the limits of the cell are tried only after a yes; nothing was tried.",
            "Name slower ones with --pace.",
        )


def read_pace(text: str) -> Pace:
    """A speed and an acceleration as they are written on a command line.

    Raises:
        UsageError: that is none.
    """
    try:
        speed_m_s, acceleration_m_s2 = (float(part) for part in text.split(","))
        return Pace(speed_m_s=speed_m_s, acceleration_m_s2=acceleration_m_s2)
    except ValueError as error:
        raise UsageError(
            f"{text!r} is no pace.",
            "Write speed and acceleration in m/s (at most 3) and m/s2 (at most 20): 1.5,0.75.",
        ) from error


class _Standing:
    """Somebody who stands at the cell, at this terminal."""

    def tell(self, text: str) -> None:
        typer.echo(text)

    def agreed(self, question: str) -> bool:
        return typer.confirm(question)

    def removed(self, what: str) -> bool:
        typer.echo(what)
        return typer.confirm("Take away what fell and lay it with the stock. Done?")


class Terminal:
    """The ``Guide`` at this terminal.

    Args:
        config: the cell as it is configured, whose tool the robot's TCP is.
        cell: tells where the arm is.
    """

    def __init__(self, config: CellConfig, cell: CellClient) -> None:
        self._flange_from_tcp = inverse(to_matrix(config.tool.frame))
        self._cell = cell

    def tell(self, text: str) -> None:
        typer.echo(text)

    def touched(self, frame: str, touch: Touch) -> Matrix | None:
        while True:
            answer = typer.prompt(f"{frame}: touch {touch.what}. There? [y]es, [s]kip")
            match answer.strip().lower()[:1]:
                case "s":
                    return None
                case "y":
                    return self.flange()

    def flange(self) -> Matrix:
        """Where the flange is, 4x4 in the base frame.

        Raises:
            RefusedError: the robot does not say, or the arm moves.
        """
        arm = self._cell.snapshot().arm
        if not arm.connected or len(arm.tcp_pose) != 6:
            raise RefusedError("The robot does not say where it is.", "Look at `cellctl status`.")
        if arm.moving:
            raise RefusedError("The arm moves.", "Let it come to rest at the point.")
        x, y, z, rx, ry, rz = arm.tcp_pose
        return to_matrix((x, y, z, rx, ry, rz)) @ self._flange_from_tcp


def prepare(path: Path, settings: CellConfig, cell: CellClient) -> None:
    """See that nothing moves while somebody touches, and that what is found can be written.

    Raises:
        RefusedError: the arm might set out.
        ConfigError: the file cannot be changed.
    """
    state = cell.snapshot().state.state
    if state != "paused_resting" and not state.startswith("fault"):
        raise RefusedError(
            "The cell is not paused: the arm might set out while you are at it.",
            "Say `cellctl pause` first.",
        )
    frames = {(table, "frame"): getattr(settings, table).frame for table in MEASURED}
    rewritten(path.read_text(encoding="utf-8"), frames, str(path))


def offer(path: Path, values: NewValues, agreed: Callable[[str], bool]) -> bool:
    """Show what changes in a configuration, and change it if somebody agrees.

    Args:
        path: the file.
        values: what is to be in it.
        agreed: asks a question that is answered with yes or no.

    Raises:
        ConfigError: it cannot be changed so.
    """
    old = path.read_text(encoding="utf-8")
    new, _ = rewritten(old, values, str(path))
    if new == old:
        typer.echo("The configuration says so already.")
        return False
    typer.echo(difference(old, new, path))
    if not agreed("Write this?"):
        typer.echo("Nothing was changed.")
        return False
    kept = replace_file(path, old, new, f".before-{datetime.now():%Y%m%d-%H%M%S}")
    typer.echo(f"Written; the file as it was is {kept}. Restart the daemon to use it.")
    return True


def _need_terminal(what: str) -> None:
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise UsageError(
            f"`cellctl calibrate {what}` asks a person who stands at the cell.",
            "Run it by hand in a terminal; it cannot be scripted.",
        )
