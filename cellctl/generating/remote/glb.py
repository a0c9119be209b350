"""Whether bytes are a binary glTF, before anything reads them as one."""

from __future__ import annotations

import struct

from cellctl.errors import DesignError

_MAGIC = b"glTF"
_HEADER = struct.Struct("<4sII")
_SHOWN = 8


def check_glb(content: bytes, origin: str) -> None:
    """See that a download is a whole GLB of version 2, by its header (glTF 2.0, section 4.4.2).

    Raises:
        DesignError: it is something else, or it is cut off.
    """
    if len(content) < _HEADER.size or not content.startswith(_MAGIC):
        raise DesignError(
            f"{origin} sent no GLB: {len(content)} bytes that begin with {content[:_SHOWN]!r}.",
            "Please ask again, or for something else.",
        )
    _, version, length = _HEADER.unpack_from(content)
    if version != 2:
        raise DesignError(f"{origin} sent a GLB of version {version}; only 2 can be read.")
    if length != len(content):
        raise DesignError(
            f"{origin} sent a broken GLB: {len(content)} of {length} bytes.",
            "Please ask again.",
        )
