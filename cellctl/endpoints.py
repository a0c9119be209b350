"""ZeroMQ end points: what the library itself does not check."""

from __future__ import annotations

import ipaddress
import re
import socket
from pathlib import Path

_IPC = "ipc://"
_TCP = re.compile(r"tcp://(?P<host>[^/;\s]+):(?P<port>[0-9]{1,5})")
_LAST_PORT = 65535


def endpoint_problem(endpoint: str) -> str:
    """What is wrong with the form of an end point, as the end of a sentence; empty for nothing.

    An ipc end point is a file, for a file has a mode: abstract ones keep nobody out.
    """
    if endpoint.startswith(_IPC):
        absolute = endpoint.removeprefix(_IPC).startswith("/")
        return "" if absolute else "must be ipc:// and an absolute path"
    found = _TCP.fullmatch(endpoint)
    if found is None or not 1 <= int(found["port"]) <= _LAST_PORT:
        return "must be ipc:///PATH or tcp://ADDRESS:PORT"
    return ""


def is_wide(endpoint: str) -> bool:
    """Whether more than this machine reaches it: anything but ipc, 127.0.0.0/8 and ::1."""
    if endpoint.startswith(_IPC):
        return False
    found = _TCP.fullmatch(endpoint)
    if found is None:
        return True
    try:
        return not ipaddress.ip_address(found["host"].strip("[]")).is_loopback
    except ValueError:  # a name, an interface or *
        return True


def reachable(endpoint: str) -> str:
    """The end point to connect to, where the one to bind to stands for all addresses."""
    found = _TCP.fullmatch(endpoint)
    own = {"*": "127.0.0.1", "0.0.0.0": "127.0.0.1", "[::]": "[::1]", "::": "[::1]"}  # noqa: S104
    if found is None or found["host"] not in own:
        return endpoint
    return f"tcp://{own[found['host']]}:{found['port']}"


def is_ipv6(endpoint: str) -> bool:
    """Whether its address is an IPv6 address, which ZeroMQ takes on demand only."""
    found = _TCP.fullmatch(endpoint)
    return found is not None and ":" in found["host"]


def socket_file(endpoint: str) -> Path | None:
    """The file of an ipc end point; None for others."""
    return Path(endpoint.removeprefix(_IPC)) if endpoint.startswith(_IPC) else None


def listened_on(endpoint: str) -> bool:
    """Whether somebody listens on an ``ipc://`` end point; ZeroMQ would take it away from them.

    Other kinds of end points are refused by ``bind`` itself; for them the answer is False.
    """
    file = socket_file(endpoint)
    if file is None:
        return False
    with socket.socket(socket.AF_UNIX) as probe:
        try:
            probe.connect(str(file))
        except OSError:
            return False
        return True
