"""A daemon of one's own, as a process: for demonstrations, benchmarks and tests."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from cellctl.client import CellClient, NoDaemonError
from cellctl.config import CellConfig
from cellctl.errors import CellctlError, CellFault
from cellctl.sim.isolation import write_config

_START_PATIENCE_S = 60.0
_END_PATIENCE_S = 15.0


class DaemonProcess:
    """``cellctl run`` as a process of its own.

    Args:
        process: the running process.
        log: the file that its log goes to.
    """

    def __init__(self, process: subprocess.Popen[bytes], log: Path) -> None:
        self.process = process
        self._log = log

    def log_tail(self, size: int = 4000) -> str:
        """The end of its log."""
        return self._log.read_text(errors="replace")[-size:]

    def check(self) -> None:
        """Make sure that it still runs.

        Raises:
            CellctlError: it does not.
        """
        if self.process.poll() is not None:
            raise CellctlError(
                f"The daemon ended by itself with status {self.process.returncode}.\n"
                f"{self.log_tail()}"
            )


@contextmanager
def running_daemon(config: CellConfig, folder: Path) -> Iterator[DaemonProcess]:
    """Start a daemon in a process of its own, and always end it.

    Raises:
        CellctlError: it ended before it was asked to.
    """
    file, log = folder / "cell.toml", folder / "daemon.log"
    write_config(config, file)
    with log.open("wb") as sink:
        process = subprocess.Popen(  # noqa: S603 - our own program
            [sys.executable, "-m", "cellctl", "run", "--config", str(file)],
            stdin=subprocess.DEVNULL,
            stdout=sink,
            stderr=sink,
        )
    daemon = DaemonProcess(process, log)
    try:
        yield daemon
        daemon.check()
    finally:
        process.terminate()
        try:
            process.wait(_END_PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def wait_idle(cell: CellClient, daemon: DaemonProcess) -> None:
    """Wait until the cell has started.

    Raises:
        CellFault: it is in a fault.
        CellctlError: it takes too long, or has ended.
    """
    deadline_s = time.monotonic() + _START_PATIENCE_S
    while True:
        daemon.check()
        try:
            snapshot = cell.wait_ready(1.0)
        except NoDaemonError:
            if time.monotonic() > deadline_s:
                raise
            continue
        if snapshot.state.state == "idle":
            return
        if snapshot.state.state.startswith("fault") or time.monotonic() > deadline_s:
            entry = snapshot.fault.entry
            if entry is not None:
                raise CellFault(entry.code, snapshot.fault.detail)
            raise CellctlError("The cell takes too long to start.")
        time.sleep(0.05)
