"""``cellctl doctor``: is everything here that the cell needs?"""

from __future__ import annotations

from datetime import UTC, datetime
from pathlib import Path

import typer
from rich.console import Console
from rich.text import Text

from cellctl import __version__, logs
from cellctl.cli import (
    doctor_boards,
    doctor_devices,
    doctor_software,
    doctor_sound,
    doctor_system,
)
from cellctl.cli.commissioning import commissioning
from cellctl.cli.findings import DoctorReport, Finding, Level, ok, problem
from cellctl.cli.options import ConfigOption, JsonOption, KeyOption, named_key
from cellctl.config import CellConfig, find_config, load_config
from cellctl.errors import ConfigError, ExitStatus

_STYLES = {Level.OK: "green", Level.WARNING: "yellow", Level.PROBLEM: "bold red"}


def register(app: typer.Typer) -> None:
    """Add the command."""

    @app.command()
    def doctor(
        config: ConfigOption = None, json: JsonOption = False, key: KeyOption = None
    ) -> None:
        """Look whether everything is here that the cell needs, with or without a daemon.

        Nothing is moved, set or disturbed. The status is 0 when there is no problem, else 7.
        """
        logs.configure("error")
        report = examine(config, key)
        if json:
            typer.echo(report.model_dump_json(indent=2))
        else:
            _show(report)
        raise typer.Exit(int(ExitStatus.DONE if report.healthy else ExitStatus.UNFIT))


def examine(explicit: Path | None, key: Path | None = None) -> DoctorReport:
    """Look at everything; takes some seconds.

    Args:
        explicit: the configuration that was named; else it is looked up.
        key: the key file for a daemon that is elsewhere.
    """
    findings: list[Finding] = []
    path = ""
    try:
        file = find_config(explicit)
        path = str(file)
        config = load_config(file)
    except ConfigError as error:
        findings.append(problem("configuration", error.message, error.hint or "Correct it."))
        findings += [*doctor_software.packages(), *doctor_system.clock()]
    else:
        text = f"{path}: {config.cell.name} ({config.cell.kind}), {config.robot.model}"
        findings.append(ok("configuration", text))
        findings += _with(config, key)
    return DoctorReport(
        time=datetime.now(UTC), version=__version__, config=path, findings=tuple(findings)
    )


def _with(config: CellConfig, key: Path | None) -> list[Finding]:
    record_findings, record = commissioning(config)
    daemon_findings, snapshot = doctor_devices.daemon(config, named_key(key))
    return [
        *doctor_software.packages(),
        *daemon_findings,
        *doctor_software.recogniser(config, snapshot),
        *doctor_sound.microphone(config, snapshot),
        *doctor_sound.loudspeaker(config, snapshot),
        *doctor_boards.conveyor(config, snapshot),
        *doctor_boards.gripper(config, snapshot),
        *doctor_devices.robot(config, record),
        *doctor_system.journal(config),
        *doctor_system.disk(config),
        *doctor_system.clock(),
        *doctor_system.service(config),
        *record_findings,
    ]


def _show(report: DoctorReport) -> None:
    console = Console(highlight=False, soft_wrap=True)
    for finding in report.findings:
        line = Text(f"{finding.level.value:<8}", style=_STYLES[finding.level])
        line.append(f" {finding.topic}: {finding.found}", style="default")
        console.print(line)
        if finding.advice:
            console.print(Text(f"         what to do: {finding.advice}"))
    problems = sum(finding.level is Level.PROBLEM for finding in report.findings)
    warnings = sum(finding.level is Level.WARNING for finding in report.findings)
    console.print(f"{problems} problems, {warnings} warnings.")
