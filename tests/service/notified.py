"""The service manager's end of the notify socket, as a test may hold it."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self


class NotifyReceiver:
    """A real datagram socket, and everything that came in on it with the time of its arrival."""

    def __init__(self, address: str) -> None:
        self.address = address
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self._socket.bind(f"\0{address[1:]}" if address.startswith("@") else address)
        self.heard: list[tuple[float, str]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._socket.close()
        if not self.address.startswith("@"):
            Path(self.address).unlink()

    def listen(self, duration_s: float) -> list[str]:
        """Take in what comes within a time; returns the new lines."""
        before, deadline_s = len(self.heard), time.monotonic() + duration_s
        while (left_s := deadline_s - time.monotonic()) > 0:
            self._socket.settimeout(left_s)
            try:
                datagram = self._socket.recv(65536)
            except TimeoutError:
                break
            self.heard += [(time.monotonic(), line) for line in datagram.decode().splitlines()]
        return [line for _, line in self.heard[before:]]

    def wait(self, what: str, holds: Callable[[str], bool], patience_s: float = 60.0) -> str:
        """Wait for a new line that is as wanted."""
        deadline_s = time.monotonic() + patience_s
        while True:
            for line in self.listen(0.05):
                if holds(line):
                    return line
            assert time.monotonic() < deadline_s, f"waited in vain for {what}; heard {self.heard}"


@contextmanager
def backlog_full(receiver: NotifyReceiver) -> Iterator[None]:
    """Fill the socket until it takes no more; empty again afterwards."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:
        sender.setblocking(False)
        address = receiver.address
        try:
            while True:
                sender.sendto(b"FILL=1", f"\0{address[1:]}" if address[0] == "@" else address)
        except BlockingIOError:
            yield
    receiver.listen(0.05)
