"""The daemon's sockets: status goes out to whoever listens, requests come in by two doors.

The role of the one who asks follows from the door, never from what is asked. A slow or dead
listener never holds the daemon up: ZeroMQ drops what a subscriber does not take.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import zmq
import zmq.asyncio

from cellctl.assembly import Role
from cellctl.clock import Clock
from cellctl.config import BusSection
from cellctl.control.door import Door, Handler
from cellctl.endpoints import is_ipv6, listened_on, socket_file
from cellctl.errors import ConfigError
from cellctl.messages import TOPIC_OF, StatusData, StatusMessage, attachment_limit

_MODES = {"status": 0o666, "visitor": 0o666, "operator": 0o660}
"""Of the files of ipc end points: the folder decides who gets as far as a visitor's, the file's
group who is an operator."""
_MAX_SUBSCRIPTION = 1024
"""Longest message that a subscriber may send, in bytes: the name of a topic."""


class Bus:
    """The PUB socket and the two doors of one daemon.

    Args:
        settings: the end points.
        clock: stamps messages.
        max_audio_s: longest recording that is listened to; limits what a visitor may send.
    """

    def __init__(self, settings: BusSection, clock: Clock, max_audio_s: float) -> None:
        self._settings = settings
        self._clock = clock
        self._max_audio_s = max_audio_s
        self._context = zmq.asyncio.Context()
        self._context.setsockopt(zmq.LINGER, 200)
        self._plain = zmq.Context(self._context)
        self._pub: zmq.Socket[bytes] | None = None
        self._doors: list[Door] = []
        self.seq = 0
        """Number of the last message published."""

    def open(self) -> None:
        """Bind all sockets.

        Raises:
            ConfigError: an end point is taken, by another daemon most likely.
        """
        self._pub = self._plain.socket(zmq.PUB)
        self._pub.setsockopt(zmq.SNDHWM, 10_000)
        self._pub.setsockopt(zmq.MAXMSGSIZE, _MAX_SUBSCRIPTION)
        self._bind("status", self._pub)
        for role in Role:
            limit = attachment_limit(role, self._max_audio_s)
            door = Door(role, self._context.socket(zmq.ROUTER), limit)
            self._doors.append(door)
            self._bind(role.value, door.socket)

    def _bind(self, name: str, socket: zmq.Socket[Any]) -> None:
        endpoint = self._settings.endpoints[name]
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
            for door in self._doors:
                tasks.create_task(door.serve(handler, state), name=f"{door.role}'s door")

    def close(self) -> None:
        """Close all sockets; what was published is sent within 0.2 s."""
        if self._pub is not None:
            self._pub.close()
        for door in self._doors:
            door.close()
        self._pub = None
        self._doors.clear()
        self._context.term()


@contextmanager
def _private_files() -> Iterator[None]:
    """Files made meanwhile are nobody else's until their mode is set."""
    before = os.umask(0o177)
    try:
        yield
    finally:
        os.umask(before)
