"""RTDE packages: ``uint16 size, uint8 kind, payload``, big-endian; the size counts the header.

Source: Universal Robots, "Real-Time Data Exchange (RTDE) Guide".
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from enum import IntEnum

_HEADER = struct.Struct(">HB")

STRUCT_OF_TYPE = {
    "BOOL": "?",
    "UINT8": "B",
    "UINT32": "I",
    "UINT64": "Q",
    "INT32": "i",
    "DOUBLE": "d",
    "VECTOR3D": "3d",
    "VECTOR6D": "6d",
    "VECTOR6INT32": "6i",
}


class Kind(IntEnum):
    """What a package is for; a reply has the kind of its request."""

    PROTOCOL_VERSION = ord("V")
    CONTROL_VERSION = ord("v")
    TEXT = ord("M")
    DATA = ord("U")
    SETUP_OUTPUTS = ord("O")
    SETUP_INPUTS = ord("I")
    START = ord("S")
    PAUSE = ord("P")


class WireError(Exception):
    """A stream of bytes that cannot be RTDE packages."""


def package(kind: Kind, payload: bytes) -> bytes:
    """One package with its header."""
    return _HEADER.pack(_HEADER.size + len(payload), kind) + payload


class PackageReader:
    """Cuts a stream of bytes into packages, however it was segmented."""

    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> Iterator[tuple[int, bytes]]:
        """Kind and payload of every package that is complete now.

        Raises:
            WireError: a package claims to be shorter than its own header.
        """
        self._buffer += data
        while len(self._buffer) >= _HEADER.size:
            size, kind = _HEADER.unpack_from(self._buffer)
            if size < _HEADER.size:
                raise WireError(f"a package of {size} bytes is shorter than its header")
            if len(self._buffer) < size:
                return
            payload = self._buffer[_HEADER.size : size]
            self._buffer = self._buffer[size:]
            yield kind, payload
