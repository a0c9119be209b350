"""ZeroMQ end points: what the library itself does not check."""

from __future__ import annotations

import socket

_IPC = "ipc://"


def listened_on(endpoint: str) -> bool:
    """Whether somebody listens on an ``ipc://`` end point; ZeroMQ would take it away from them.

    Other kinds of end points are refused by ``bind`` itself; for them the answer is False.
    """
    if not endpoint.startswith(_IPC):
        return False
    with socket.socket(socket.AF_UNIX) as probe:
        try:
            probe.connect(endpoint.removeprefix(_IPC))
        except OSError:
            return False
        return True
