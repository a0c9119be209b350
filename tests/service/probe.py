"""Runs in place of the daemon, under its unit's restrictions; writes down what it may do.

Needs no cellctl: it asks the kernel.
"""

from __future__ import annotations

import ctypes
import importlib
import json
import multiprocessing
import os
import socket
import sys
from collections.abc import Callable
from pathlib import Path

AF_PACKET = 17


def answer(act: Callable[[], object]) -> str:
    """``yes``, or the name of the error that refused it."""
    try:
        act()
    except OSError as error:
        return type(error).__name__
    return "yes"


def send(address: str) -> None:
    """Send a datagram; a filter refuses it at once."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        sender.sendto(b"hello", (address, 9))


def callback_works() -> bool:
    """Whether C can call back into Python, as the sound library does."""
    import cffi  # type: ignore[import-untyped]  # noqa: PLC0415 - only here

    ffi = cffi.FFI()
    return int(ffi.callback("int(int)", lambda number: number + 1)(41)) == 42


def imported(name: str) -> str:
    """``yes``, or why a library does not load."""
    try:
        importlib.import_module(name)
    except Exception as error:  # noqa: BLE001 - that it fails is the finding
        return repr(error)
    return "yes"


def main() -> None:
    """Ask, and write the answers to the file named first."""
    status = dict(
        line.split(":\t", 1)
        for line in Path("/proc/self/status").read_text().splitlines()
        if ":\t" in line
    )
    child = multiprocessing.get_context("spawn").Process(target=print)
    child.start()
    child.join(30)
    found = {
        "uid": os.getuid(),
        # In a user namespace the groups have no names, but they count.
        "audio": answer(lambda: Path("/srv/audio").open().close()),
        "dialout": answer(lambda: Path("/srv/dialout").open().close()),
        "capabilities": int(status["CapEff"], 16) | int(status["CapBnd"], 16),
        "no_new_privileges": status["NoNewPrivs"],
        "seccomp": status["Seccomp"],
        "write_etc": answer(lambda: Path("/etc/cellctl/x").write_text("")),
        "write_program": answer(lambda: Path("/opt/cellctl/x").write_text("")),
        "write_state": answer(lambda: Path("/var/lib/cellctl/x").write_text("")),
        "write_run": answer(lambda: Path("/run/cellctl/x").write_text("")),
        "write_tmp": answer(lambda: Path("/tmp/x").write_text("")),  # noqa: S108 - a private one
        "see_home": answer(lambda: list(Path("/root").iterdir())),
        "read_configuration": answer(lambda: Path("/etc/cellctl/cell.toml").read_text()),
        "reach_loopback": answer(lambda: send("127.0.0.1")),
        "reach_private": answer(lambda: send("192.168.7.7")),
        "reach_internet": answer(lambda: send("203.0.113.7")),
        "socket_packet": answer(lambda: socket.socket(AF_PACKET, socket.SOCK_DGRAM)),
        "socket_ipv6": answer(lambda: socket.socket(socket.AF_INET6)),
        "other_device": answer(lambda: os.open("/dev/tty0", os.O_RDWR)),
        "mount": ctypes.CDLL(None).mount(b"none", b"/tmp", b"tmpfs", 0, None),
        "more_priority": answer(lambda: os.setpriority(os.PRIO_PROCESS, 0, -11)),
        "child_process": child.exitcode,
        "callback": callback_works(),
        "libraries": {name: imported(name) for name in sys.argv[2:]},
    }
    Path(sys.argv[1]).write_text(json.dumps(found))


if __name__ == "__main__":
    main()
