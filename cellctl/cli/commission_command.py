"""``cellctl commission``: take a new or changed cell into use, step by step, with a person."""

from __future__ import annotations

import getpass
import sys
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path

import typer

from cellctl import __version__
from cellctl.assembling.arm_dashboard import Dashboard
from cellctl.assembly import Role
from cellctl.cli.commission_steps import Answer, Walk
from cellctl.cli.commissioning import (
    CommissionRecord,
    StepRecord,
    fingerprint,
    write_record,
)
from cellctl.cli.options import ConfigOption, KeyOption, client, configuration
from cellctl.client import CellClient
from cellctl.config import CellConfig
from cellctl.errors import ExitStatus, RefusedError, UsageError
from cellctl.messages import Snapshot

_ANSWERS: dict[str, Answer] = {"y": "yes", "n": "no", "s": "skip"}


class Terminal:
    """The ``Operator`` at this terminal."""

    def tell(self, text: str) -> None:
        typer.echo(text)

    def ask(self, question: str) -> Answer:
        while True:
            typed: str = typer.prompt(f"{question} [y]es, [n]o, [s]kip")
            answer = _ANSWERS.get(typed.strip().lower()[:1])
            if answer is not None:
                return answer


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def commission(config: ConfigOption = None, key: KeyOption = None) -> None:
        """Take a new or changed cell into use: lines, latch, belt, frames, a dry run.

        Asks a person at the cell before and after each movement, and keeps a record. The daemon
        must run, with nothing in the workspace or in the gripper. The cell stays paused at the end.
        The status is 0 when every step passed, else 7.
        """
        if not (sys.stdin.isatty() and sys.stdout.isatty()):
            raise UsageError(
                "`cellctl commission` asks a person who stands at the cell and looks.",
                "Run it by hand in a terminal; it cannot be scripted.",
            )
        raise typer.Exit(int(_commission(configuration(config), config, key)))


def _commission(config: CellConfig, path: Path | None, key: Path | None) -> ExitStatus:
    with client(path, Role.OPERATOR, key) as cell:
        _refuse_unready(cell.snapshot())
        # Before anything moves: who stands here, and that what is found can be kept.
        record = _begun(config, typer.prompt("Your name", default=getpass.getuser()))
        file = write_record(config, record)
        typer.echo("Pausing the cell. Stop it at any time with Ctrl-C.")
        cell.command("pause")
        steps: list[StepRecord] = []
        try:
            for step in Walk(config, cell, Terminal()).run():
                steps.append(step)
                record = record.model_copy(update={"steps": tuple(steps)})
                write_record(config, record)
        except (KeyboardInterrupt, typer.Abort):
            _stop(cell)
            broken_off = StepRecord(name="end", outcome="failed", note="broken off")
            write_record(config, record.model_copy(update={"steps": (*steps, broken_off)}))
            raise
    typer.echo(f"\nThe record is in {file}. The cell is paused: `cellctl resume` when it is free.")
    for step in steps:
        typer.echo(f"{step.outcome:<8} {step.name} {step.note}".rstrip())
    return ExitStatus.DONE if record.passed else ExitStatus.UNFIT


def _stop(cell: CellClient) -> None:
    """Whatever still moves was begun here."""
    typer.echo("\nStopping.")
    cell.command("stop")


def _refuse_unready(snapshot: Snapshot) -> None:
    """Raises RefusedError unless the cell is at rest and empty."""
    state = snapshot.state.state
    if state not in {"idle", "paused_resting"}:
        raise RefusedError(
            f"The cell is {state.replace('_', ': ')}; it must be idle or paused.",
            "Wait, or stop it; reset a fault first.",
        )
    if snapshot.standing or snapshot.gripper.holding != "nothing":
        raise RefusedError(
            "Something stands in the workspace or is in the gripper.",
            "Take it out and say `cellctl clear`; cancel the job if there is one.",
        )


def _begun(config: CellConfig, who: str) -> CommissionRecord:
    """A record without steps yet.

    Raises:
        CellFault: the robot does not answer or is another one.
    """
    with closing(Dashboard(config.robot)) as dashboard:
        identity = dashboard.identity(config.robot.model)
    return CommissionRecord(
        cell=config.cell.name,
        kind=config.cell.kind,
        time=datetime.now(UTC),
        who=who,
        version=__version__,
        config_sha256=fingerprint(config),
        robot=identity,
    )
