"""The child's end of a sound process: orders in, events out, one line of JSON each."""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
from collections.abc import Callable
from typing import Literal, Never

from cellctl.assembly import Value

LINE_LIMIT_BYTES = 2 << 20
"""Longest line; the longest segment, 12 s in base64, takes 0.5 MB."""
ALIVE_EVERY_S = 0.25
"""How often the daemon hears that the loop goes round (wall time)."""
_SEND_TIMEOUT_S = 5.0
"""A daemon that takes nothing for so long is dead or hangs, and this process with it."""


class Alive(Value):
    """The process goes round its loop."""

    kind: Literal["alive"] = "alive"


def encode(message: Value) -> bytes:
    """One line."""
    return message.model_dump_json().encode() + b"\n"


class ChildLine:
    """This process's end of the socket pair; the process ends when the other end closes.

    Args:
        descriptor: of the socket.
        take: gets each order, as it was sent, in a thread of its own.
    """

    def __init__(self, descriptor: int, take: Callable[[bytes], None]) -> None:
        self._connection = socket.socket(fileno=descriptor)
        self._connection.settimeout(_SEND_TIMEOUT_S)
        self._take = take
        self._sending = threading.Lock()
        threading.Thread(target=self._read, name="orders", daemon=True).start()

    def send(self, message: Value) -> None:
        """Tell the daemon; safe from any thread."""
        try:
            with self._sending:
                self._connection.sendall(encode(message))
        except OSError:  # the daemon is gone, or hangs
            os._exit(0)

    def _read(self) -> None:
        rest = b""
        while True:
            try:
                data = self._connection.recv(65_536)
            except TimeoutError:
                continue
            except OSError:
                data = b""
            if not data or len(rest) > LINE_LIMIT_BYTES:
                # At once, whatever the other threads wait for.
                os._exit(0)
            *lines, rest = (rest + data).split(b"\n")
            for line in lines:
                self._take(line)

    def stay_lost(self) -> Never:
        """Go on saying that the process lives, for as long as the daemon does: nothing but an
        installation helps."""
        while True:
            self.send(Alive())
            threading.Event().wait(ALIVE_EVERY_S)


def arguments() -> tuple[int, str]:
    """What the process was started with: its descriptor, and its settings as JSON."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    return int(sys.argv[1]), sys.argv[2]
