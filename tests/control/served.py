"""A bus that serves, with a handler that tells who asked: for tests of the doors."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import zmq
import zmq.asyncio

from cellctl.assembly import Role
from cellctl.clock import SystemClock
from cellctl.config import BusSection
from cellctl.control.bus import Bus
from cellctl.control.door import Answer, Handler
from cellctl.messages import ControlReply, ControlRequest, ReplyError

MAX_AUDIO_S = 1.0
PATIENCE_S = 60.0
"""How long a test waits for anything (wall time)."""


async def handler(request: ControlRequest, attachment: bytes | None, role: Role) -> Answer:
    """Refuses to pause, and tells the role and the size of the file for everything else."""
    if request.body.command == "pause":
        error = ReplyError(code="refused", message="Not now.")
        return Answer(ControlReply(id=request.id, ok=False, state="idle", error=error))
    size = len(attachment or b"")
    message = f"{role} sent {size} bytes"
    return Answer(ControlReply(id=request.id, ok=True, state="idle", message=message))


def settings(folder: Path, **options: str) -> BusSection:
    """End points in a folder, and what else is to be set."""
    own = {name: f"ipc://{folder}/{name}" for name in ("status", "visitor", "operator")}
    return BusSection.model_validate({**own, **options})


@asynccontextmanager
async def serving(own: BusSection, handle: Handler = handler) -> AsyncIterator[Bus]:
    """An open bus that answers."""
    bus = Bus(own, SystemClock(), MAX_AUDIO_S)
    bus.open()
    task = asyncio.create_task(bus.serve(handle, lambda: "idle"))
    try:
        yield bus
    finally:
        task.cancel()
        await asyncio.gather(task, return_exceptions=True)
        bus.close()


@asynccontextmanager
async def knocking(endpoint: str) -> AsyncIterator[zmq.asyncio.Socket]:
    """A bare socket at a door."""
    context = zmq.asyncio.Context()
    try:
        socket = context.socket(zmq.DEALER)
        socket.connect(endpoint)
        yield socket
    finally:
        context.destroy(linger=0)


async def reply(socket: zmq.asyncio.Socket) -> ControlReply:
    """The next reply."""
    async with asyncio.timeout(PATIENCE_S):
        return ControlReply.model_validate_json((await socket.recv_multipart())[-1])


def request(name: str, command: str = "snapshot") -> bytes:
    """The first frame of a request."""
    return f'{{"id": "{name}", "body": {{"command": "{command}"}}}}'.encode()
