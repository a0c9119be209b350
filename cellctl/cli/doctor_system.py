"""The doctor's look at the computer: journal, disk, clock, service manager. Read-only."""

from __future__ import annotations

import ctypes
import os
import shutil
import sqlite3
import subprocess
import time
from pathlib import Path

from cellctl.cli.findings import Finding, ok, problem, warning
from cellctl.config import CellConfig

_CHECK_LIMIT_S = 20.0
_LITTLE_BYTES = 1 << 30
_TOO_LITTLE_BYTES = 100 << 20
_ADJTIMEX_BYTES = 512
"""More than struct timex has on any machine; all zeros only asks."""
_TIME_ERROR = 5
"""What adjtimex returns while the clock is not synchronised (adjtimex(2))."""
_SYSTEMD = Path("/run/systemd/system")
_UDEV_RULES = (Path("/etc/udev/rules.d"), Path("/usr/lib/udev/rules.d"))
_SYSTEMCTL_TIMEOUT_S = 5.0
_UNIT = "cellctl.service"


def journal(config: CellConfig) -> list[Finding]:
    """Whether the journal is there and whole."""
    path = Path(config.journal.path)
    try:
        size = path.stat().st_size
    except FileNotFoundError:
        return [_no_journal(path)]
    except OSError as error:
        return [_unreadable(path, error.strerror or str(error))]
    try:
        trouble = _quick_check(path)
    except sqlite3.DatabaseError as error:
        if isinstance(error, sqlite3.OperationalError) and "interrupted" in str(error):
            text = f"{path} was not checked to its end within {_CHECK_LIMIT_S:.0f} s"
            return [warning("journal", text, "Try again while the cell is idle.")]
        if isinstance(error, sqlite3.OperationalError):
            return [_unreadable(path, str(error))]
        trouble = str(error)
    if trouble:
        return [
            problem(
                "journal",
                f"{path} is damaged: {trouble}",
                "Stop the daemon, keep the file, and restore the last backup (`cellctl restore`).",
            )
        ]
    return [ok("journal", f"{path}, {size / 1e6:.1f} MB, whole")]


def disk(config: CellConfig) -> list[Finding]:
    """Room for the journal."""
    folder = _existing(Path(config.journal.path).parent)
    free = shutil.disk_usage(folder).free
    text = f"{free / 1e9:.1f} GB free for {folder}"
    advice = "Make room: without it the journal cannot be written, and nothing is moved."
    if free < _TOO_LITTLE_BYTES:
        return [problem("disk", text, advice)]
    if free < _LITTLE_BYTES:
        return [warning("disk", text, advice)]
    return [ok("disk", text)]


def clock() -> list[Finding]:
    """Whether the system's clock is kept right; only the kernel is asked."""
    state = ctypes.CDLL(None, use_errno=True).adjtimex(ctypes.create_string_buffer(_ADJTIMEX_BYTES))
    if state < 0:
        return [warning("clock", f"cannot be asked: {os.strerror(ctypes.get_errno())}")]
    if state == _TIME_ERROR:
        return [
            warning(
                "clock",
                "the system's clock is not synchronised",
                "Let systemd-timesyncd or chrony keep it, or the journal's dates will be wrong.",
            )
        ]
    return [ok("clock", "synchronised")]


def service(config: CellConfig) -> list[Finding]:
    """What the service manager knows of the daemon, and whether the boards have fixed names."""
    if not _SYSTEMD.is_dir() or shutil.which("systemctl") is None:
        return [ok("service", "no systemd runs here")]
    shown = _systemctl_show()
    if shown is None:
        return [warning("service", "systemctl does not answer")]
    if shown.get("LoadState") != "loaded":
        text = f"{_UNIT} is not installed"
        found = [warning("service", text, "`sudo make install` runs the cell as a service.")]
    elif shown.get("ActiveState") == "failed":
        found = [problem("service", f"{_UNIT} has failed", f"Look at `journalctl -u {_UNIT}`.")]
    else:
        text = f"{_UNIT} is {shown.get('ActiveState')} ({shown.get('SubState')})"
        text += f", started again {shown.get('NRestarts', '?')} times"
        found = [ok("service", text)]
    port = config.feeder.port
    if config.cell.kind == "real" and port.startswith(("/dev/ttyUSB", "/dev/ttyACM")):
        named = any(folder.glob("*cellctl*.rules") for folder in _UDEV_RULES if folder.is_dir())
        found.append(
            warning(
                "udev",
                f"feeder.port = {port} changes with the order of plugging"
                + ("" if named else ", and no rules of cellctl are installed"),
                "Name the board by its serial number in a udev rule, and use that name.",
            )
        )
    return found


def _quick_check(path: Path) -> str:
    """What SQLite finds wrong; empty when nothing is.

    Raises:
        sqlite3.DatabaseError: it is no database, cannot be read, or takes too long.
    """
    until_s = time.monotonic() + _CHECK_LIMIT_S
    connection = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)
    try:
        connection.set_progress_handler(lambda: time.monotonic() > until_s, 10_000)
        rows = [str(row[0]) for row in connection.execute("PRAGMA quick_check(5)")]
    finally:
        connection.close()
    return "" if rows == ["ok"] else "; ".join(rows)


def _no_journal(path: Path) -> Finding:
    folder = _existing(path.parent)
    if os.access(folder, os.W_OK):
        return ok("journal", f"{path} does not exist yet; the daemon makes it")
    return warning(
        "journal",
        f"{path} does not exist yet, and this user cannot make it in {folder}",
        "Let the daemon's user own that folder.",
    )


def _unreadable(path: Path, why: str) -> Finding:
    advice = "Ask as the daemon's user, for example with `sudo -u cellctl cellctl doctor`."
    return warning("journal", f"{path} cannot be read: {why}", advice)


def _existing(folder: Path) -> Path:
    while not folder.exists():
        folder = folder.parent
    return folder


def _systemctl_show() -> dict[str, str] | None:
    names = "LoadState,ActiveState,SubState,NRestarts"
    try:
        done = subprocess.run(  # noqa: S603 - a fixed command
            ["systemctl", "show", _UNIT, f"--property={names}"],  # noqa: S607 - found on the path
            capture_output=True,
            text=True,
            timeout=_SYSTEMCTL_TIMEOUT_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return dict(line.split("=", 1) for line in done.stdout.splitlines() if "=" in line)
