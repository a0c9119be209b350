"""A machine with systemd of its own, to run the real units on."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import sysconfig
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil

from tests.leaks import REPOSITORY

SYSTEMD = Path("/lib/systemd/systemd")
_TOOLS = ("unshare", "nsenter", "ip", "systemd-sysusers", "systemd-tmpfiles")
_PATIENCE_S = 90.0


def service_python() -> Path:
    """A Python like ours outside of home folders, which the units hide."""
    return Path(f"/usr/bin/python{sys.version_info.major}.{sys.version_info.minor}")


def why_not() -> str:
    """Why no machine can be had here; empty when one can."""
    if os.geteuid() != 0:
        return "needs root, to make a machine with namespaces"
    if not SYSTEMD.exists():
        return "systemd is not installed"
    if missing := [tool for tool in _TOOLS if shutil.which(tool) is None]:
        return f"{', '.join(missing)} missing"
    if not service_python().exists():
        return f"{service_python()} is missing, and home folders are hidden from the service"
    if _cgroup2() is None:
        return "no cgroup2 is mounted"
    tried = subprocess.run(
        ["unshare", "--pid", "--fork", "--mount", "--cgroup", "--ipc", "--uts", "--net", "true"],
        capture_output=True,
        check=False,
        timeout=30,
    )
    return "" if tried.returncode == 0 else "the kernel allows no namespaces here"


class Machine:
    """A machine that runs; commands run in it as root.

    Args:
        first: its first process, systemd.
        services_log: the file in the machine that its services write to.
    """

    def __init__(self, first: psutil.Process, services_log: str) -> None:
        self._first = first
        self._services_log = services_log

    def run(
        self, *command: str, timeout_s: float = 60.0, check: bool = True
    ) -> subprocess.CompletedProcess[str]:
        """Run a command in the machine and wait for its end."""
        result = subprocess.run(
            [
                *("nsenter", f"--target={self._first.pid}"),
                *("-m", "-p", "-C", "-n", "-i", "-u", "-r", "-w"),
                *command,
            ],
            env={"PATH": "/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
            timeout=timeout_s,
        )
        assert result.returncode == 0 or not check, (
            f"{command}: {result.stdout}{result.stderr}\n{self.log_tail()}"
        )
        return result

    def log_tail(self, size: int = 6000) -> str:
        """The end of what the services wrote."""
        log = self.path(self._services_log)
        return log.read_text(errors="replace")[-size:] if log.exists() else ""

    def property_of(self, unit: str, name: str) -> str:
        """A property of a unit, as systemd tells it."""
        return self.run("systemctl", "show", "--value", f"--property={name}", unit).stdout.strip()

    def path(self, path: str) -> Path:
        """A file of the machine, as this system sees it."""
        return Path(f"/proc/{self._first.pid}/root{path}")


@contextmanager
def machine(installed: Path, services_log: str) -> Iterator[Machine]:
    """Start a machine on which the files of a folder are installed; always end it."""
    hierarchy = _cgroup2()
    assert hierarchy is not None
    cgroup = hierarchy / f"cellctl-test-{os.getpid()}"
    cgroup.mkdir()
    log = installed.parent / "machine.log"
    script = (
        'echo $$ >"$0/cgroup.procs" && exec unshare --pid --fork --kill-child --mount --cgroup '
        '--ipc --uts --net bash "$@"'
    )
    with log.open("wb") as sink:
        process = subprocess.Popen(
            [
                *("bash", "-c", script, str(cgroup), str(REPOSITORY / "tests/service/machine.sh")),
                *(str(installed), str(REPOSITORY), sysconfig.get_path("purelib")),
                str(service_python()),
            ],
            stdin=subprocess.DEVNULL,
            stdout=sink,
            stderr=sink,
        )
    try:
        yield _ready(process, log, services_log)
    finally:
        with suppress(psutil.NoSuchProcess):  # it may have ended by itself
            for child in psutil.Process(process.pid).children():
                child.kill()  # the first process takes all others of its machine along
        process.kill()
        process.wait()
        _remove(cgroup)


def _ready(process: subprocess.Popen[bytes], log: Path, services_log: str) -> Machine:
    deadline_s = time.monotonic() + _PATIENCE_S
    while True:
        assert process.poll() is None, log.read_text()
        assert time.monotonic() < deadline_s, f"the machine does not start\n{log.read_text()}"
        for child in psutil.Process(process.pid).children():
            with suppress(psutil.NoSuchProcess, psutil.AccessDenied):
                if Path(child.exe()).name == "systemd":
                    made = Machine(child, services_log)
                    state = made.run("systemctl", "is-active", "bare.target", check=False)
                    if state.stdout.strip() == "active":
                        return made
        time.sleep(0.05)


def _cgroup2() -> Path | None:
    for line in Path("/proc/mounts").read_text().splitlines():
        _, where, kind, *_ = line.split()
        if kind == "cgroup2":
            return Path(where)
    return None


def _remove(cgroup: Path) -> None:
    deadline_s = time.monotonic() + _PATIENCE_S
    while cgroup.exists():
        folders = sorted((p for p in cgroup.rglob("*") if p.is_dir()), reverse=True)
        with suppress(OSError):  # the last process in it may still be ending
            for folder in (*folders, cgroup):
                folder.rmdir()
        assert time.monotonic() < deadline_s, f"{cgroup}: cannot be removed"
        time.sleep(0.02)
