"""Starts an emulated cell in a process of its own, and always ends it."""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from cellctl.config import CellConfig
from cellctl.errors import CellctlError, UsageError
from cellctl.sim.client import NoEmulatedCellError, SimClient

TERMINATE_TIMEOUT_S = 5.0
"""How long the process may take to end when told to (wall time); then it is killed."""
_ASK_AGAIN_S = 0.25


class StartError(CellctlError):
    """The emulated cell did not come up."""


@contextmanager
def emulated_cell(
    config: CellConfig,
    speed: float = 1.0,
    start_timeout_s: float = 30.0,
    log_path: Path | None = None,
) -> Iterator[SimClient]:
    """Run an emulated cell for the duration of a ``with`` block.

    The process ends with the block however that is left, and also when this process dies.

    Args:
        config: with addresses that no other cell on this machine uses.
        speed: cell seconds per wall second; goes before ``cell.clock_rate``.
        start_timeout_s: how long it may take to come up (wall time).
        log_path: where its log is appended; None keeps it for the error message only.

    Yields:
        A client of its control socket.

    Raises:
        UsageError: the configuration is of a real cell.
        StartError: it did not come up; with the end of its log.
    """
    if config.emulation is None:
        raise UsageError(
            f"The cell {config.cell.name!r} is a real one and cannot be emulated.",
            'Name a configuration with cell.kind = "emulated".',
        )
    # Raw text both ways: the log is read back from where this process has opened it.
    with tempfile.TemporaryFile() if log_path is None else log_path.open("ab+") as log:
        process = subprocess.Popen(  # noqa: S603 - this very interpreter and package
            [sys.executable, "-m", "cellctl.sim", "--config", "-", "--speed", str(speed)],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=log,
        )
        try:
            # Its standard input stays open: when it closes, the process ends.
            assert process.stdin is not None
            process.stdin.write(config.model_dump_json().encode() + b"\n")
            process.stdin.flush()
            with SimClient(config.emulation.control) as client:
                _wait_until_ready(process, client, start_timeout_s, log)
                yield client
        except BrokenPipeError as error:
            raise StartError(f"The emulated cell ended at once.\n{_tail(log)}") from error
        finally:
            _end(process)


def _wait_until_ready(
    process: subprocess.Popen[bytes], client: SimClient, timeout_s: float, log: IO[bytes]
) -> None:
    deadline_s = time.monotonic() + timeout_s
    while True:
        try:
            pong = client.wait_ready(_ASK_AGAIN_S)
        except NoEmulatedCellError:
            pong = None
        if process.poll() is not None:
            raise StartError(
                f"The emulated cell ended with status {process.returncode} before it was ready.\n"
                f"{_tail(log)}"
            )
        if pong is not None and pong.pid == process.pid:
            return
        if time.monotonic() > deadline_s:
            raise StartError(
                f"The emulated cell was not ready within {timeout_s:g} s.\n{_tail(log)}"
            )


def _end(process: subprocess.Popen[bytes]) -> None:
    assert process.stdin is not None
    process.terminate()
    try:
        process.wait(TERMINATE_TIMEOUT_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    finally:
        process.stdin.close()


def _tail(log: IO[bytes], size: int = 2000) -> str:
    log.seek(0, 2)
    log.seek(max(0, log.tell() - size))
    return log.read().decode(errors="replace").strip()
