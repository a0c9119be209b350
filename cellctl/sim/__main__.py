"""``python -m cellctl.sim --config FILE --speed N``: run the emulated cell."""

from __future__ import annotations

import argparse
import asyncio
import json
import os
import sys
from contextlib import suppress
from pathlib import Path

import structlog

from cellctl import logs
from cellctl.config import CellConfig, load_config, parse_config
from cellctl.errors import CellctlError, ConfigError, ExitStatus
from cellctl.sim.process import run_cell

STANDARD_INPUT = "-"
_NICENESS = -5
"""The robot and the boards that this stands for have computers of their own, which no browser and
no planner holds up; so it goes before those where it may. The arm's process goes first."""


def main(arguments: list[str] | None = None) -> int:
    """Run until told to end; returns the exit status."""
    parser = argparse.ArgumentParser(prog="cellctl.sim", description="Run the emulated cell.")
    parser.add_argument(
        "--config",
        required=True,
        help="a TOML file; - reads one line of JSON from standard input, and the cell ends when "
        "that closes",
    )
    parser.add_argument("--speed", type=float, help="cell seconds per wall second")
    options = parser.parse_args(arguments)
    logs.configure()
    with suppress(PermissionError):
        os.setpriority(os.PRIO_PROCESS, 0, _NICENESS)
    from_stdin = options.config == STANDARD_INPUT
    try:
        config = _read_stdin() if from_stdin else load_config(Path(options.config))
        speed = options.speed if options.speed is not None else config.cell.clock_rate
        if not 0.0 < speed <= 100.0:
            raise ConfigError(f"--speed {speed:g}: must be greater than 0 and at most 100.")
        asyncio.run(run_cell(config, speed, _announce, end_with_stdin=from_stdin))
    except CellctlError as error:
        structlog.get_logger(__name__).error(error.message, hint=error.hint)
        return error.exit_status
    return ExitStatus.DONE


def _read_stdin() -> CellConfig:
    try:
        data = json.loads(sys.stdin.buffer.readline())
    except ValueError as error:
        raise ConfigError(f"standard input: is not one line of JSON: {error}.") from error
    if not isinstance(data, dict):
        raise ConfigError("standard input: must be one JSON object.")
    return parse_config(data, "standard input")


def _announce() -> None:
    sys.stdout.write("ready\n")
    sys.stdout.flush()


if __name__ == "__main__":
    sys.exit(main())
