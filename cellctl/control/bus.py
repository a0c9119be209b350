"""The daemon's sockets: status goes out to whoever listens, requests come in by two doors.

The role of the one who asks follows from the door, never from what is asked. A slow or dead
listener never holds the daemon up: ZeroMQ drops what a subscriber does not take.
"""

from __future__ import annotations

import asyncio
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import structlog
import zmq
import zmq.asyncio

from cellctl.assembly import Role
from cellctl.clock import Clock
from cellctl.config import BusSection
from cellctl.control.door import Door, Handler
from cellctl.control.gatekeeper import Gatekeeper
from cellctl.endpoints import is_ipv6, is_wide, listened_on, socket_file
from cellctl.errors import ConfigError
from cellctl.keys import AllowList, require_server_key, server_key
from cellctl.messages import TOPIC_OF, StatusData, StatusMessage, attachment_limit

log = structlog.get_logger(__name__)

_MODES = {"status": 0o666, "visitor": 0o666, "operator": 0o660}
"""Of the files of ipc end points: the folder decides who gets as far as a visitor's, the file's
group who is an operator."""
_UNHEARD = 10_000
"""Status messages that wait for one subscriber; what is beyond is dropped."""
_KEYS_PERIOD_S = 0.5
"""How soon a revoked subscriber hears nothing more (wall time)."""
_REBIND_PATIENCE_S = 5.0
_MAX_SUBSCRIPTION = 1024
"""Longest message that a subscriber may send, in bytes: the name of a topic."""


class Bus:
    """The PUB socket and the two doors of one daemon.

    Args:
        settings: the end points.
        clock: stamps messages.
        max_audio_s: longest recording that is listened to; limits what a visitor may send.

    Raises:
        ConfigError: an end point is wider than ipc and loopback, and the cell has no key
            that can be used.
    """

    def __init__(self, settings: BusSection, clock: Clock, max_audio_s: float) -> None:
        self._settings = settings
        self._clock = clock
        self._max_audio_s = max_audio_s
        folder = Path(settings.keys)
        locked = require_server_key(settings.endpoints, folder)
        key = server_key(folder) if locked else None
        self._context = zmq.asyncio.Context()
        self._context.setsockopt(zmq.LINGER, 200)
        self._plain = zmq.Context(self._context)
        self._pub: zmq.Socket[bytes] | None = None
        self._doors: list[Door] = []
        self._gate: Gatekeeper | None = None
        if key is not None:
            self._gate = Gatekeeper(self._context, key, AllowList(folder))
        self.seq = 0
        """Number of the last message published."""

    def open(self) -> None:
        """Bind all sockets.

        Raises:
            ConfigError: an end point is taken, by another daemon most likely.
        """
        if self._gate is not None:
            self._gate.open()
        self._pub = self._publisher()
        self._bind("status", self._pub)
        for role in Role:
            gate = self._gate if is_wide(self._settings.door(role)) else None
            door = Door(
                role,
                self._context.socket(zmq.ROUTER),
                attachment_limit(role, self._max_audio_s),
                gate.admits if gate is not None else None,
            )
            self._doors.append(door)
            self._bind(role.value, door.socket)

    def _publisher(self) -> zmq.Socket[bytes]:
        socket: zmq.Socket[bytes] = self._plain.socket(zmq.PUB)
        socket.setsockopt(zmq.SNDHWM, _UNHEARD)
        socket.setsockopt(zmq.MAXMSGSIZE, _MAX_SUBSCRIPTION)
        return socket

    def _bind(self, name: str, socket: zmq.Socket[Any]) -> None:
        endpoint = self._settings.endpoints[name]
        if is_wide(endpoint):
            assert self._gate is not None
            self._gate.lock(socket, name)
        problem = "Address already in use" if listened_on(endpoint) else ""
        try:
            if not problem:
                socket.setsockopt(zmq.IPV6, is_ipv6(endpoint))
                with _private_files():
                    socket.bind(endpoint)
        except zmq.ZMQError as error:
            problem = str(error.strerror)
        if problem:
            raise ConfigError(
                f"bus.{name} = {endpoint!r} cannot be used: {problem}.",
                "Another daemon may be running; stop it, or give this one other end points.",
            )
        if file := socket_file(endpoint):
            file.chmod(_MODES[name])

    def publish(self, data: StatusData, state: str) -> None:
        """Send one status message; never blocks."""
        if self._pub is None:
            return
        self.seq += 1
        message = StatusMessage(
            seq=self.seq,
            time=self._clock.wall_time(),
            cell_time_s=self._clock.now_s(),
            state=state,
            topic=TOPIC_OF[type(data)],
            data=data.model_dump(mode="json"),
        )
        # A PUB socket never blocks: it drops what a slow subscriber does not take.
        self._pub.send_multipart([message.topic.encode(), message.model_dump_json().encode()])

    async def serve(self, handler: Handler, state: Callable[[], str]) -> None:
        """Answer requests at both doors until cancelled."""
        async with asyncio.TaskGroup() as tasks:
            if self._gate is not None:
                tasks.create_task(self._gate.serve(), name="gatekeeper")
                if is_wide(self._settings.status):
                    tasks.create_task(self._shut_out(self._gate), name="revoked keys")
            for door in self._doors:
                tasks.create_task(door.serve(handler, state), name=f"{door.role}'s door")

    async def _shut_out(self, gate: Gatekeeper) -> None:
        """Close the ears of those whose key is revoked.

        A subscriber asks nothing, so nothing of it can be refused, and libzmq cannot end one
        connection alone: all are ended, and those that are still allowed come back by themselves.
        What they miss meanwhile shows as a gap in ``seq``.
        """
        before = gate.keys()
        while True:
            await asyncio.sleep(_KEYS_PERIOD_S)
            now = gate.keys()
            if before - now:
                log.info("a key was revoked; subscribers connect anew")
                await self._publish_anew()
            before = now

    async def _publish_anew(self) -> None:
        assert self._pub is not None
        self._pub.close(linger=0)
        self._pub = self._publisher()
        deadline_s = time.monotonic() + _REBIND_PATIENCE_S
        while True:
            try:
                self._bind("status", self._pub)
            except ConfigError:  # libzmq gives an address back some time after the socket closed
                if time.monotonic() > deadline_s:
                    raise
            else:
                return
            await asyncio.sleep(0.01)

    def close(self) -> None:
        """Close all sockets; what was published is sent within 0.2 s."""
        if self._pub is not None:
            self._pub.close()
        for door in self._doors:
            door.close()
        self._pub = None
        self._doors.clear()
        if self._gate is not None:
            self._gate.close()
        self._context.term()


@contextmanager
def _private_files() -> Iterator[None]:
    """Files made meanwhile are nobody else's until their mode is set."""
    before = os.umask(0o177)
    try:
        yield
    finally:
        os.umask(before)
