"""The RTDE service on port 30004: recipes, the state stream, and inputs with their owners."""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from cellctl.sim.ur import wire
from cellctl.sim.ur.net import Connection, Server
from cellctl.sim.ur.registers import Getter, Registers, input_type, output_variable
from cellctl.sim.ur.wire import Kind

PORT = 30004
_BACKLOG_PACKAGES = 4
"""A connection that has so many packages unread gets no newer ones until it reads."""

InputValue = float | int | tuple[float, ...]
InputWriter = Callable[[Mapping[str, InputValue]], None]


@dataclass
class Traffic:
    """What went over RTDE, for reports."""

    packages_sent: int = 0
    packages_received: int = 0
    malformed: int = 0
    refused_inputs: int = 0


@dataclass
class InputOwners:
    """Which connection may write which input variable, until it closes."""

    owner: dict[str, RtdeConnection] = field(default_factory=dict)

    def claim(self, names: list[str], by: RtdeConnection) -> list[str]:
        """The names that another connection owns already; if there are none, all are taken."""
        taken = [name for name in names if self.owner.get(name, by) is not by]
        if not taken:
            self.owner.update(dict.fromkeys(names, by))
        return taken

    def release(self, by: RtdeConnection) -> None:
        """Free everything that a connection owned."""
        self.owner = {name: owner for name, owner in self.owner.items() if owner is not by}


class _OutputRecipe:
    """The variables that one connection asked for, and how they are packed."""

    def __init__(self, number: int, variables: list[tuple[str, Getter]], period_s: float) -> None:
        self.number = number
        self.period_s = period_s
        self._getters = [(getter, kind.startswith("VECTOR")) for kind, getter in variables]
        self._struct = struct.Struct(
            ">B" + "".join(wire.STRUCT_OF_TYPE[kind] for kind, _ in variables)
        )

    def pack(self, registers: Registers) -> bytes:
        values: list[float] = [self.number]
        for getter, is_vector in self._getters:
            if is_vector:
                values.extend(getter(registers))
            else:
                values.append(getter(registers))
        return wire.package(Kind.DATA, self._struct.pack(*values))

    @property
    def size(self) -> int:
        return self._struct.size + 3


class _InputRecipe:
    """The variables that one kind of package writes."""

    def __init__(self, names: list[str], kinds: list[str]) -> None:
        self._names = names
        self._counts = [6 if kind.startswith("VECTOR6") else 1 for kind in kinds]
        self._struct = struct.Struct(">" + "".join(wire.STRUCT_OF_TYPE[kind] for kind in kinds))

    def unpack(self, payload: bytes) -> dict[str, InputValue]:
        """Raises struct.error when the payload has another length."""
        flat = self._struct.unpack(payload)
        values: dict[str, InputValue] = {}
        at = 0
        for name, count in zip(self._names, self._counts, strict=True):
            values[name] = flat[at] if count == 1 else flat[at : at + count]
            at += count
        return values


class RtdeConnection(Connection):
    """One RTDE client."""

    def __init__(self, sock: socket.socket, server: Server, service: RtdeService) -> None:
        super().__init__(sock, server)
        self._service = service
        self._reader = wire.PackageReader()
        self._output: _OutputRecipe | None = None
        self._inputs: list[_InputRecipe] = []
        self._started = False
        self._due_s = 0.0

    def received(self, data: bytes) -> None:
        try:
            for kind, payload in self._reader.feed(data):
                self._handle(kind, payload)
                if self.closed:
                    return
        except wire.WireError:
            self._service.traffic.malformed += 1
            self.close()

    def lost(self) -> None:
        self._service.owners.release(self)

    def stream(self, elapsed_s: float) -> None:
        """Send the state when it is due; ``elapsed_s`` is wall time since the last call.

        Packages that a late tick has missed are not made up for.
        """
        recipe = self._output
        if not self._started or recipe is None:
            return
        self._due_s -= elapsed_s
        if self._due_s > elapsed_s / 2.0:  # the next tick is nearer
            return
        self._due_s = max(self._due_s + recipe.period_s, 0.0)
        if self.backlog > _BACKLOG_PACKAGES * recipe.size:
            self.flush()
            return
        self.send(recipe.pack(self._service.registers))
        self._service.traffic.packages_sent += 1

    def _handle(self, kind: int, payload: bytes) -> None:
        service = self._service
        if kind == Kind.DATA:
            self._write_inputs(payload)
        elif kind == Kind.PROTOCOL_VERSION:
            accepted = len(payload) == 2 and struct.unpack(">H", payload)[0] in (1, 2)
            self._reply(Kind.PROTOCOL_VERSION, bytes([accepted]))
        elif kind == Kind.CONTROL_VERSION:
            self._reply(Kind.CONTROL_VERSION, struct.pack(">4I", *service.version))
        elif kind == Kind.SETUP_OUTPUTS:
            self._set_up_outputs(payload)
        elif kind == Kind.SETUP_INPUTS:
            self._set_up_inputs(payload)
        elif kind == Kind.START:
            self._started = self._output is not None
            self._due_s = 0.0
            self._reply(Kind.START, bytes([self._started]))
        elif kind == Kind.PAUSE:
            self._started = False
            self._reply(Kind.PAUSE, b"\x01")
        else:
            service.traffic.malformed += 1

    def _reply(self, kind: Kind, payload: bytes) -> None:
        self.send(wire.package(kind, payload))

    def _set_up_outputs(self, payload: bytes) -> None:
        service = self._service
        if len(payload) < 8:
            service.traffic.malformed += 1
            return
        (frequency_hz,) = struct.unpack_from(">d", payload)
        found = [output_variable(name, service.version) for name in _names(payload[8:])]
        known = [variable for variable in found if variable is not None]
        accepted = len(known) == len(found) and frequency_hz > 0.0
        if accepted:
            period_s = max(1.0 / frequency_hz, service.period_s)
            self._output = _OutputRecipe(1, known, period_s)
        kinds = ",".join("NOT_FOUND" if variable is None else variable[0] for variable in found)
        self._reply(Kind.SETUP_OUTPUTS, bytes([accepted]) + kinds.encode())

    def _set_up_inputs(self, payload: bytes) -> None:
        service = self._service
        names = _names(payload)
        kinds = [input_type(name) for name in names]
        taken = service.owners.claim(
            [name for name, kind in zip(names, kinds, strict=True) if kind is not None], self
        )
        known = [kind for kind in kinds if kind is not None]
        shown = [
            "IN_USE" if name in taken else kind or "NOT_FOUND"
            for name, kind in zip(names, kinds, strict=True)
        ]
        if taken:
            service.traffic.refused_inputs += 1
        accepted = not taken and len(known) == len(names)
        if accepted:
            self._inputs.append(_InputRecipe(names, known))
        number = len(self._inputs) if accepted else 0
        self._reply(Kind.SETUP_INPUTS, bytes([number]) + ",".join(shown).encode())

    def _write_inputs(self, payload: bytes) -> None:
        traffic = self._service.traffic
        number = payload[0] if payload else 0
        if not 1 <= number <= len(self._inputs):
            traffic.malformed += 1
            return
        try:
            values = self._inputs[number - 1].unpack(payload[1:])
        except struct.error:
            traffic.malformed += 1
            return
        traffic.packages_received += 1
        self._service.write(values)


class RtdeService:
    """RTDE for any number of clients.

    Args:
        host: address to listen on.
        registers: what is streamed.
        version: the controller's version, four numbers.
        period_s: the shortest time between two packages (wall time).
        write: takes what a client has written, by variable name.
    """

    def __init__(
        self,
        host: str,
        registers: Registers,
        version: tuple[int, int, int, int],
        period_s: float,
        write: InputWriter,
    ) -> None:
        self.registers = registers
        self.version = version
        self.period_s = period_s
        self.write = write
        self.owners = InputOwners()
        self.traffic = Traffic()
        self.server = Server(host, PORT, lambda sock, server: RtdeConnection(sock, server, self))

    def stream(self, elapsed_s: float) -> None:
        """Send the state to every client for whom it is due."""
        if self.server.frozen:
            return
        for connection in list(self.server.connections):
            assert isinstance(connection, RtdeConnection)
            connection.stream(elapsed_s)


def _names(payload: bytes) -> list[str]:
    return [name for name in payload.decode("latin-1").split(",") if name]
