"""One variable of the controller's state that ur_rtde 1.6.5 has no getter for.

A connection of its own, for one answer: any number of clients may read. Wire format: Universal
Robots, "Real-Time Data Exchange (RTDE) Guide"; big-endian, protocol version 2.
"""

from __future__ import annotations

import select
import socket
import struct
import time
from collections.abc import Generator

from cellctl.errors import CellFault

TOOL_VOLTAGE = "tool_output_voltage"
"""Supply of the tool's connector, in volts, as INT32."""

_PORT = 30004
_HEADER = struct.Struct(">HB")
_VERSION, _OUTPUTS, _START, _DATA = ord("V"), ord("O"), ord("S"), ord("U")
_FREQUENCY_HZ = 125.0
_TIMEOUT_S = 1.0
"""For each answer (wall time)."""


def read_integer(host: str, variable: str) -> Generator[None, None, int]:
    """Read one INT32 variable; each ``yield`` gives the caller's loop a round.

    Raises:
        CellFault: ``robot_lost`` when the controller does not answer as it should.
    """
    try:
        with socket.create_connection((host, _PORT), timeout=_TIMEOUT_S) as connection:
            yield from _asked(connection, _VERSION, struct.pack(">H", 2))
            recipe = struct.pack(">d", _FREQUENCY_HZ) + variable.encode()
            kinds = yield from _asked(connection, _OUTPUTS, recipe)
            if kinds[1:] != b"INT32":
                raise CellFault("robot_lost", f"The controller's {variable} is {kinds[1:]!r}.")
            _send(connection, _START, b"")
            data = yield from _answer(connection, _DATA)
    except OSError as error:
        where = f"{host}:{_PORT}"
        raise CellFault("robot_lost", f"{where}: {error.strerror or error}.") from error
    value: int = struct.unpack(">i", data[1:5])[0]
    return value


def _asked(connection: socket.socket, kind: int, payload: bytes) -> Generator[None, None, bytes]:
    _send(connection, kind, payload)
    return (yield from _answer(connection, kind))


def _send(connection: socket.socket, kind: int, payload: bytes) -> None:
    connection.sendall(_HEADER.pack(_HEADER.size + len(payload), kind) + payload)


def _answer(connection: socket.socket, kind: int) -> Generator[None, None, bytes]:
    """The next package of a kind; others, such as text messages, are passed over."""
    deadline_s = time.monotonic() + _TIMEOUT_S
    while time.monotonic() < deadline_s:
        if not select.select([connection], [], [], 0.0)[0]:
            yield
            continue
        size, found = _HEADER.unpack(_exactly(connection, _HEADER.size))
        payload = _exactly(connection, size - _HEADER.size)
        if found == kind:
            return payload
    raise CellFault("robot_lost", f"No answer to RTDE's {chr(kind)} within {_TIMEOUT_S:.0f} s.")


def _exactly(connection: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size:
        more = connection.recv(size - len(data))
        if not more:
            raise ConnectionError("it closed the connection")
        data += more
    return data
