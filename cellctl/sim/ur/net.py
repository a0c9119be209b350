"""Listening sockets and their connections, driven by the event loop's readers.

Plain non-blocking sockets instead of streams: the emulator must be able to read what is pending at
a moment of its own choosing (before its watchdog trips), to stop answering without closing, and to
break connections off.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import struct
from abc import ABC, abstractmethod
from collections.abc import Callable

_CHUNK = 65536
_BACKLOG_LIMIT = 1 << 20
"""Bytes that a peer may leave unread before it is cut off."""


class Connection(ABC):
    """One accepted connection."""

    def __init__(self, sock: socket.socket, server: Server) -> None:
        self._socket = sock
        self._server = server
        self._backlog = b""
        self.closed = False

    @abstractmethod
    def received(self, data: bytes) -> None:
        """Bytes have arrived."""

    def opened(self) -> None:  # noqa: B027 - most services say nothing first
        """The connection was accepted."""

    def lost(self) -> None:  # noqa: B027 - most services keep nothing of a connection
        """The connection is gone, by whichever side."""

    def send(self, data: bytes) -> None:
        """Queue bytes; a peer that reads too slowly is disconnected."""
        if self.closed:
            return
        self._backlog += data
        if not self._server.frozen:
            self.flush()

    def flush(self) -> None:
        """Hand as much of the queue to the network as it takes."""
        if self.closed or not self._backlog:
            return
        try:
            sent = self._socket.send(self._backlog)
        except BlockingIOError:
            sent = 0
        except OSError:
            self.close()
            return
        self._backlog = self._backlog[sent:]
        if len(self._backlog) > _BACKLOG_LIMIT:
            self.close()

    @property
    def backlog(self) -> int:
        """Bytes that the network has not taken yet."""
        return len(self._backlog)

    def read(self) -> None:
        """Take in what is there without waiting."""
        while not (self.closed or self._server.frozen):
            try:
                data = self._socket.recv(_CHUNK)
            except BlockingIOError:
                return
            except OSError:
                data = b""
            if not data:
                self.close()
                return
            self.received(data)
            if len(data) < _CHUNK:
                return

    def close(self, *, reset: bool = False) -> None:
        """End the connection; ``reset`` breaks it off without the closing handshake."""
        if self.closed:
            return
        self.closed = True
        self._server.forget(self)
        if reset:
            with contextlib.suppress(OSError):
                self._socket.setsockopt(
                    socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0)
                )
        self._socket.close()
        self.lost()

    def fileno(self) -> int:
        """The socket's descriptor, for the event loop."""
        return self._socket.fileno()


class Server:
    """A listening port and the connections that were accepted on it.

    Args:
        host: address to listen on.
        port: port to listen on.
        make: makes a connection's handler.
    """

    def __init__(
        self, host: str, port: int, make: Callable[[socket.socket, Server], Connection]
    ) -> None:
        self.host = host
        self.port = port
        self.frozen = False
        self.connections: list[Connection] = []
        self._make = make
        self._listener: socket.socket | None = None
        self._loop: asyncio.AbstractEventLoop | None = None

    def open(self) -> None:
        """Start to listen on the running event loop; no effect if it listens already.

        Raises:
            OSError: the address cannot be listened on.
        """
        if self._listener is not None:
            return
        self._loop = asyncio.get_running_loop()
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind((self.host, self.port))
            listener.listen()
            listener.setblocking(False)
        except OSError as error:
            listener.close()
            raise OSError(
                error.errno, f"cannot listen on {self.host}:{self.port}: {error.strerror}"
            ) from error
        self._listener = listener
        self._loop.add_reader(listener, self._accept)

    def refuse(self) -> None:
        """Stop to listen: new connections are refused, the present ones stay."""
        if self._listener is not None:
            assert self._loop is not None
            self._loop.remove_reader(self._listener)
            self._listener.close()
            self._listener = None

    def freeze(self, frozen: bool) -> None:
        """Neither read nor write while frozen; every socket stays open."""
        if frozen == self.frozen:
            return
        self.frozen = frozen
        assert self._loop is not None
        for connection in self.connections:
            if frozen:
                self._loop.remove_reader(connection)
            else:
                self._loop.add_reader(connection, connection.read)
                connection.flush()

    def read_pending(self) -> None:
        """Take in what has arrived on every connection."""
        for connection in list(self.connections):
            connection.read()

    def drop(self, *, reset: bool) -> None:
        """End every connection."""
        for connection in list(self.connections):
            connection.close(reset=reset)

    def close(self) -> None:
        """Stop to listen and end every connection."""
        self.refuse()
        self.drop(reset=False)

    def forget(self, connection: Connection) -> None:
        """Called by a connection that closes."""
        assert self._loop is not None
        self._loop.remove_reader(connection)
        self.connections.remove(connection)

    def _accept(self) -> None:
        assert self._listener is not None
        assert self._loop is not None
        try:
            sock, _ = self._listener.accept()
        except OSError:
            return  # the peer has given up meanwhile
        sock.setblocking(False)
        sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection = self._make(sock, self)
        self.connections.append(connection)
        if not self.frozen:
            self._loop.add_reader(connection, connection.read)
        connection.opened()
