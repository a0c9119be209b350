"""One door of the daemon: a ROUTER socket whose requests all have the role of the door.

Whoever knocks gets an answer, malformed requests and too many of them included; nobody can make the
daemon keep more than a bounded number of requests, or starve the other door.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Any

import zmq
import zmq.asyncio
from pydantic import ValidationError

from cellctl.assembly import Role
from cellctl.messages import (
    MAX_REQUEST,
    SCHEMA_VERSION,
    ControlReply,
    ControlRequest,
    ReplyError,
)


@dataclass(frozen=True)
class Answer:
    """A reply, and the file that goes with it as a second frame."""

    reply: ControlReply
    file: zmq.Frame | None = None


Handler = Callable[[ControlRequest, bytes | None, Role], Awaitable[Answer]]

PER_CLIENT = 8
"""How many requests of one client may be under way at a time."""
IN_ALL = 64
"""How many requests may be under way at one door."""
RESERVED_FOR_STOP = 16
"""How many more may be, when they say stop; a client's own limit does not count for them."""
_UNREAD = 16
"""Messages of one client that wait to be read; then the client's own side has to wait."""
_UNSENT = 1000
"""Replies that wait for one client to take them; what is beyond is dropped."""


class Door:
    """A ROUTER socket and the role of those who use it.

    Args:
        role: of everyone who asks here.
        socket: not yet bound; it gets its limits here and closes with the door.
        attachment_limit: largest file of a request, in bytes.
        admits: whether the client with a public key may still use the door; None for a door
            without keys.
    """

    def __init__(
        self,
        role: Role,
        socket: zmq.asyncio.Socket,
        attachment_limit: int,
        admits: Callable[[str, Role], bool] | None = None,
    ) -> None:
        self.role = role
        self.socket = socket
        self._admits = admits
        self._attachment_limit = attachment_limit
        self._pending: set[asyncio.Task[None]] = set()
        self._under_way: Counter[bytes] = Counter()
        # A file that is somewhat too large gets an answer; one far too large is cut off.
        socket.setsockopt(zmq.MAXMSGSIZE, 2 * attachment_limit)
        socket.setsockopt(zmq.RCVHWM, _UNREAD)
        socket.setsockopt(zmq.SNDHWM, _UNSENT)

    async def serve(self, handler: Handler, state: Callable[[], str]) -> None:
        """Answer requests until cancelled; each is handled in a task of its own."""
        try:
            while True:
                frames: list[zmq.Frame] = await self.socket.recv_multipart(copy=False)
                await self._take(frames, handler, state)
                # Receiving what already waits does not yield; a flood would stop everything else.
                await asyncio.sleep(0)
        finally:
            for task in self._pending:
                task.cancel()
            await asyncio.gather(*self._pending, return_exceptions=True)

    async def _take(
        self, frames: list[zmq.Frame], handler: Handler, state: Callable[[], str]
    ) -> None:
        """Begin to answer one request, or refuse it at once."""
        connection, *body = [frame.bytes for frame in frames]
        client = connection
        if self._admits is not None:
            # A connection outlives its key: who was revoked since is not heard any more.
            key = str(frames[-1].get("User-Id"))
            if not self._admits(key, self.role):
                return
            client = key.encode()
        envelope = [connection]
        if body and not body[0]:
            # A REQ socket puts an empty frame before its message, and wants one before the reply.
            envelope.append(body.pop(0))
        try:
            request, attachment = self._decode(body)
            self._refuse_if_busy(request, client)
        except _NotTakenError as refusal:
            reply = ControlReply(id=refusal.id, ok=False, state=state(), error=refusal.error)
            await self._send(envelope, Answer(reply))
            return
        self._under_way[client] += 1
        task = asyncio.create_task(
            self._answer(envelope, handler(request, attachment, self.role)), name="request"
        )
        self._pending.add(task)
        task.add_done_callback(lambda done: self._ended(done, client))

    def _ended(self, task: asyncio.Task[None], client: bytes) -> None:
        self._pending.discard(task)
        self._under_way[client] -= 1
        if not self._under_way[client]:
            del self._under_way[client]

    async def _answer(self, envelope: list[bytes], answer: Awaitable[Answer]) -> None:
        await self._send(envelope, await answer)

    async def _send(self, envelope: list[bytes], answer: Answer) -> None:
        frames: list[bytes | zmq.Frame] = [*envelope, answer.reply.model_dump_json().encode()]
        if answer.file is not None:
            frames.append(answer.file)
        with contextlib.suppress(zmq.ZMQError):  # the one who asked has gone
            # Without a copy: replies that wait for slow clients share the memory of a file.
            await self.socket.send_multipart(frames, copy=answer.file is None)

    def _decode(self, body: list[bytes]) -> tuple[ControlRequest, bytes | None]:
        document = body[0] if body else b""
        if len(document) > MAX_REQUEST:
            size = f"request: has {len(document)} bytes; {MAX_REQUEST} are taken at most"
            raise _NotTakenError("?", "invalid", size, "Send a file as the second frame.")
        name = _id_of(document)
        if len(body) > 2:
            count = f"request: has {len(body)} frames"
            raise _NotTakenError(name, "invalid", count, "Send one frame, or two with a file.")
        try:
            request = ControlRequest.model_validate_json(document)
        except ValidationError as error:
            first = error.errors(include_url=False, include_context=False)[0]
            hint = ""
            if first["loc"] == ("schema_version",):
                hint = f"This cell speaks schema version {SCHEMA_VERSION}."
            raise _NotTakenError(name, "invalid", _explain(first), hint) from error
        attachment = body[1] if len(body) > 1 else None
        if attachment is not None and len(attachment) > self._attachment_limit:
            raise _NotTakenError(
                name,
                "usage",
                f"The file has {len(attachment) / 1e6:.1f} MB; "
                f"{self._attachment_limit / 1e6:.1f} MB are taken at the {self.role}'s door.",
            )
        return request, attachment

    def _refuse_if_busy(self, request: ControlRequest, client: bytes) -> None:
        if request.body.command == "stop":
            busy = len(self._pending) >= IN_ALL + RESERVED_FOR_STOP
        else:
            busy = len(self._pending) >= IN_ALL or self._under_way[client] >= PER_CLIENT
        if busy:
            raise _NotTakenError(
                request.id, "busy", "Too many requests are under way.", "Ask again in a moment."
            )

    def close(self) -> None:
        """Close the socket."""
        self.socket.close()


class _NotTakenError(Exception):
    """A request that is answered without being handled."""

    def __init__(self, request_id: str, code: Any, message: str, hint: str = "") -> None:
        super().__init__(message)
        self.id = request_id
        self.error = ReplyError(code=code, message=message, hint=hint)


def _id_of(document: bytes) -> str:
    """The id of a request, however wrong the rest of it may be; else a question mark."""
    try:
        found = json.loads(document)
    except (ValueError, RecursionError):
        return "?"
    name = found.get("id") if isinstance(found, dict) else None
    return name if isinstance(name, str) and 1 <= len(name) <= 64 else "?"


def _explain(error: Any) -> str:
    where = ".".join(str(part) for part in error["loc"]) or "request"
    return f"{where}: {error['msg']}"
