"""Script intake on port 30003: what the control client uploads, and what it asks for in it.

The emulator does not interpret URScript. It recognises the control program of ``ur_rtde`` by its
name, reads the register offsets and the path that the client has written into it, and runs the same
program re-implemented in ``program``. Any other program ends as soon as it has started.
"""

from __future__ import annotations

import re
import socket
from collections.abc import Callable
from dataclasses import dataclass

from cellctl.sim.ur.net import Connection, Server
from cellctl.sim.ur.options import Six
from cellctl.sim.ur.trajectory import Waypoint

PORT = 30003
_LIMIT_BYTES = 4 << 20
"""A text that has grown to this without an end is thrown away."""

_END = re.compile(rb"^end[ \t\r]*\n", re.MULTILINE)
_NAME = re.compile(r"^\s*def\s+(\w+)\s*\(", re.MULTILINE)
_OFFSET = r"# {} register offset\s*\n\s*(\d+)"
_PATH_MARK = "# inject move path"
_NUMBER = r"[-+0-9.eE]+"
_MOVE = re.compile(
    rf"signal_async_progress\(\s*(?P<number>\d+)\s*\)"
    rf"|(?P<move>move[jlp])\(\s*(?P<pose>p?)\[(?P<target>[^\]]*)\]"
    rf"\s*,\s*a\s*=\s*(?P<a>{_NUMBER})\s*,\s*v\s*=\s*(?P<v>{_NUMBER})"
    rf"(?:\s*,\s*r\s*=\s*(?P<r>{_NUMBER}))?\s*\)"
)


class ScriptError(Exception):
    """A program that the controller would refuse to run."""


@dataclass(frozen=True)
class PathMove:
    """A movement of the injected path, and whether its target has yet to be made joints."""

    waypoint: Waypoint
    needs_inverse: bool = False


@dataclass(frozen=True)
class Script:
    """What matters of an uploaded program."""

    name: str
    int_offset: int = 0
    double_offset: int = 0
    path: tuple[PathMove, ...] = ()

    @property
    def is_control(self) -> bool:
        """Whether it is the client's control program."""
        return self.name == "rtde_control"


def parse_script(text: str) -> Script:
    """Read a program.

    Raises:
        ScriptError: it has no name, or a movement in it cannot be read.
    """
    name = _NAME.search(text)
    if name is None:
        raise ScriptError("a program starts with def")
    if name[1] != "rtde_control":
        return Script(name[1])
    return Script(name[1], _offset(text, "int"), _offset(text, "float"), _parse_path(text))


def _offset(text: str, kind: str) -> int:
    match = re.search(_OFFSET.format(kind), text)
    if match is None:
        raise ScriptError(f"the control program has no {kind} register offset")
    return int(match[1])


def _parse_path(text: str) -> tuple[PathMove, ...]:
    _, mark, rest = text.partition(_PATH_MARK)
    if not mark:
        return ()
    body = rest.partition("\n    end")[0]
    moves: list[PathMove] = []
    number = 0
    for match in _MOVE.finditer(body):
        if match["number"] is not None:
            number = int(match["number"])
        else:
            moves.append(_parse_move(match, number))
    if len(moves) != len(re.findall(r"\bmove[jlpc]\(", body)):
        raise ScriptError("a movement of the path cannot be read")
    return tuple(moves)


def _parse_move(match: re.Match[str], number: int) -> PathMove:
    try:
        values = [float(value) for value in match["target"].split(",")]
        speed, acceleration = float(match["v"]), float(match["a"])
        blend_m = float(match["r"] or 0.0)
        x, y, z, rx, ry, rz = values
    except ValueError as error:
        raise ScriptError(f"a movement of the path cannot be read: {error}") from error
    if not (speed > 0.0 and acceleration > 0.0 and blend_m >= 0.0):
        raise ScriptError("a movement needs a speed and an acceleration greater than 0")
    target: Six = (x, y, z, rx, ry, rz)
    joint = match["move"] == "movej"
    is_pose = match["pose"] == "p"
    waypoint = Waypoint("joint" if joint else "line", target, speed, acceleration, blend_m, number)
    return PathMove(waypoint, needs_inverse=is_pose and joint)


class ScriptConnection(Connection):
    """A client that uploads programs; nothing is ever sent to it."""

    def __init__(
        self, sock: socket.socket, server: Server, uploaded: Callable[[str], None]
    ) -> None:
        super().__init__(sock, server)
        self._uploaded = uploaded
        self._buffer = b""

    def received(self, data: bytes) -> None:
        self._buffer += data
        while match := _END.search(self._buffer):
            text = self._buffer[: match.end()]
            self._buffer = self._buffer[match.end() :]
            self._uploaded(text.decode("utf-8", "replace"))
        if len(self._buffer) > _LIMIT_BYTES:
            self._buffer = b""


def script_server(host: str, uploaded: Callable[[str], None]) -> Server:
    """The service on port 30003; ``uploaded`` takes the text of each complete program."""
    return Server(host, PORT, lambda sock, server: ScriptConnection(sock, server, uploaded))
