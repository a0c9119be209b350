"""The daemon's two sockets: status goes out to whoever listens, requests come in and are answered.

A slow or dead listener never holds the daemon up: ZeroMQ drops what a subscriber does not take.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Awaitable, Callable
from typing import Any

import zmq
import zmq.asyncio
from pydantic import ValidationError

from cellctl.clock import Clock
from cellctl.endpoints import listened_on
from cellctl.errors import ConfigError
from cellctl.messages import (
    MAX_ATTACHMENT,
    TOPIC_OF,
    ControlReply,
    ControlRequest,
    ReplyError,
    StatusData,
    StatusMessage,
)

Handler = Callable[[ControlRequest, bytes | None], Awaitable[ControlReply]]


class Bus:
    """The PUB and ROUTER sockets of one daemon.

    Args:
        status: end point to publish on.
        control: end point to take requests on.
        clock: stamps messages.
    """

    def __init__(self, status: str, control: str, clock: Clock) -> None:
        self._clock = clock
        self._endpoints = {"status": status, "control": control}
        self._context = zmq.asyncio.Context()
        self._context.setsockopt(zmq.LINGER, 200)
        self._plain = zmq.Context(self._context)
        self._pub: zmq.Socket[bytes] | None = None
        self._router: zmq.asyncio.Socket | None = None
        self._pending: set[asyncio.Task[None]] = set()
        self.seq = 0
        """Number of the last message published."""

    def open(self) -> None:
        """Bind both sockets.

        Raises:
            ConfigError: an end point is taken, by another daemon most likely.
        """
        self._pub = self._plain.socket(zmq.PUB)
        self._pub.setsockopt(zmq.SNDHWM, 10_000)
        self._router = self._context.socket(zmq.ROUTER)
        self._router.setsockopt(zmq.MAXMSGSIZE, MAX_ATTACHMENT)
        for name, socket in (("status", self._pub), ("control", self._router)):
            endpoint = self._endpoints[name]
            problem = "Address already in use" if listened_on(endpoint) else ""
            try:
                if not problem:
                    socket.bind(endpoint)
            except zmq.ZMQError as error:
                problem = str(error.strerror)
            if problem:
                raise ConfigError(
                    f"bus.{name} = {endpoint!r} cannot be used: {problem}.",
                    "Another daemon may be running; stop it, or give this one other end points.",
                )

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
        """Answer requests until cancelled; each is handled in a task of its own."""
        assert self._router is not None
        try:
            while True:
                frames: list[bytes] = await self._router.recv_multipart()
                task = asyncio.create_task(self._answer(frames, handler, state))
                self._pending.add(task)
                task.add_done_callback(self._pending.discard)
        finally:
            for task in self._pending:
                task.cancel()
            await asyncio.gather(*self._pending, return_exceptions=True)

    async def _answer(
        self, frames: list[bytes], handler: Handler, state: Callable[[], str]
    ) -> None:
        identity, body = frames[0], frames[1:]
        envelope = [identity]
        if body and not body[0]:
            # A REQ socket puts an empty frame before its message, and wants one before the reply.
            envelope.append(body.pop(0))
        try:
            request = ControlRequest.model_validate_json(body[0] if body else b"")
        except ValidationError as error:
            reply = ControlReply(
                id="?",
                ok=False,
                state=state(),
                error=ReplyError(code="invalid", message=_explain(error.errors())),
            )
        else:
            reply = await handler(request, body[1] if len(body) > 1 else None)
        assert self._router is not None
        with contextlib.suppress(zmq.ZMQError):  # the one who asked has gone
            await self._router.send_multipart([*envelope, reply.model_dump_json().encode()])

    def close(self) -> None:
        """Close both sockets; what was published is sent within 0.2 s."""
        for socket in (self._pub, self._router):
            if socket is not None:
                socket.close()
        self._pub = self._router = None
        self._context.term()


def _explain(errors: list[Any]) -> str:
    first = errors[0]
    where = ".".join(str(part) for part in first["loc"]) or "request"
    return f"{where}: {first['msg']}"
