"""A page of one's own, as a process: for demonstrations, pictures and tests."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from cellctl.config import CellConfig
from cellctl.errors import CellctlError
from cellctl.sim.isolation import write_config

_START_PATIENCE_S = 60.0
_END_PATIENCE_S = 15.0
_LOOK_AGAIN_S = 0.05


@dataclass
class KioskProcess:
    """``cellctl kiosk`` as a process of its own."""

    process: subprocess.Popen[bytes]
    log: Path
    url: str
    """Of the visitor's view, with a slash at its end."""

    def log_tail(self, size: int = 4000) -> str:
        """The end of its log."""
        return self.log.read_text(errors="replace")[-size:]

    def end(self) -> None:
        """End it, and wait for that."""
        self.process.terminate()
        try:
            self.process.wait(_END_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def with_own_page(config: CellConfig) -> CellConfig:
    """The same cell, whose page has a loopback port of its own."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    section = config.kiosk.model_copy(update={"address": "127.0.0.1", "port": port})
    return config.model_copy(update={"kiosk": section})


@contextmanager
def running_kiosk(
    config: CellConfig, folder: Path, environment: Mapping[str, str] | None = None
) -> Iterator[KioskProcess]:
    """Start a page in a process of its own, wait until it is served, and always end it.

    Args:
        config: the cell, whose page nobody else serves.
        folder: for its configuration and log.
        environment: of the process; this one's by default.

    Raises:
        CellctlError: it did not come up; with the end of its log.
    """
    file, log = folder / "kiosk.toml", folder / "kiosk.log"
    write_config(config, file)
    with log.open("ab") as sink:
        process = subprocess.Popen(  # noqa: S603 - our own program
            [sys.executable, "-m", "cellctl", "kiosk", "--config", str(file)],
            stdin=subprocess.DEVNULL,
            stdout=sink,
            stderr=sink,
            env=dict(os.environ if environment is None else environment),
        )
    page = KioskProcess(process, log, f"http://127.0.0.1:{config.kiosk.port}/")
    try:
        _await_served(page, config.kiosk.port)
        yield page
    finally:
        page.end()


def _await_served(page: KioskProcess, port: int) -> None:
    deadline_s = time.monotonic() + _START_PATIENCE_S
    while True:
        if page.process.poll() is not None or time.monotonic() > deadline_s:
            raise CellctlError(f"The page is not served.\n{page.log_tail()}")
        try:
            socket.create_connection(("127.0.0.1", port), timeout=1.0).close()
        except OSError:
            time.sleep(_LOOK_AGAIN_S)
        else:
            return
