"""Status and the two doors: everyone gets an answer, and every message follows its schema."""

from __future__ import annotations

import asyncio
import json
from pathlib import Path

import pytest
import zmq
import zmq.asyncio

from cellctl.assembly import Role
from cellctl.client import CellClient, NoDaemonError
from cellctl.clock import SystemClock
from cellctl.control.bus import Bus
from cellctl.errors import ConfigError, RefusedError
from cellctl.messages import ControlReply, GripperData
from tests.control.served import MAX_AUDIO_S, serving, settings


def client(folder: Path, timeout_s: float = 10.0, role: Role = Role.VISITOR) -> CellClient:
    own = settings(folder)
    return CellClient(own.door(role), own.status, timeout_s)


def test_a_request_gets_its_reply_and_an_attachment_arrives(tmp_path: Path) -> None:
    async def exercise() -> None:
        async with serving(settings(tmp_path)):
            with client(tmp_path) as cell:
                reply = await asyncio.to_thread(cell.hear, "a.wav", b"12345")
                assert reply.message == "visitor sent 5 bytes"
                with pytest.raises(RefusedError, match="Not now"):
                    await asyncio.to_thread(cell.command, "pause")

    asyncio.run(exercise())


@pytest.mark.parametrize(
    ("frame", "says"),
    [
        (b"", "Invalid JSON"),
        (b"\xff\xfe", "Invalid JSON"),
        (b"[]", "should be an object"),
        (b'{"id": "1", "body": {"command": "fly"}}', "fly"),
        (b'{"id": "1", "role": "operator", "body": {"command": "stop"}}', "role"),
        (b'{"id": "1", "body": {"command": "say", "text": ""}}', "text"),
        (b'{"schema_version": 1, "id": "1", "body": {"command": "stop"}}', "schema_version"),
    ],
)
def test_what_is_no_request_gets_a_typed_error(tmp_path: Path, frame: bytes, says: str) -> None:
    async def exercise() -> ControlReply:
        async with serving(settings(tmp_path)):
            context = zmq.asyncio.Context()
            socket = context.socket(zmq.DEALER)
            try:
                socket.connect(settings(tmp_path).visitor)
                await socket.send(frame)
                async with asyncio.timeout(10):
                    return ControlReply.model_validate_json((await socket.recv_multipart())[-1])
            finally:
                context.destroy(linger=0)

    reply = asyncio.run(exercise())
    assert reply.error is not None
    assert reply.error.code == "invalid"
    assert says in reply.error.message


def test_a_plain_req_socket_is_answered(tmp_path: Path) -> None:
    async def exercise() -> ControlReply:
        async with serving(settings(tmp_path)):
            context = zmq.asyncio.Context()
            socket = context.socket(zmq.REQ)
            try:
                socket.connect(settings(tmp_path).visitor)
                await socket.send(b'{"id": "7", "body": {"command": "stop"}}')
                async with asyncio.timeout(10):
                    return ControlReply.model_validate_json(await socket.recv())
            finally:
                context.destroy(linger=0)

    reply = asyncio.run(exercise())
    assert (reply.id, reply.ok) == ("7", True)


def test_status_goes_out_in_order_under_its_topic(tmp_path: Path) -> None:
    async def exercise() -> None:
        async with serving(settings(tmp_path)) as bus:
            with client(tmp_path) as cell:
                cell.subscribe()
                await asyncio.to_thread(cell.hear, "joined", b"1")
                for holding in ("part", "nothing"):
                    bus.publish(GripperData(holding=holding), "idle")
                messages = await asyncio.to_thread(lambda: list(cell.messages(0.5)))
        assert [message.seq for message in messages] == [1, 2]
        assert [message.payload() for message in messages] == [
            GripperData(holding="part"),
            GripperData(holding="nothing"),
        ]
        assert {message.topic for message in messages} == {"gripper"}
        assert json.loads(messages[0].model_dump_json())["schema_version"] == 2

    asyncio.run(exercise())


@pytest.mark.parametrize("kind", ["tcp", "ipc"])
def test_a_second_daemon_on_the_same_end_points_is_refused(tmp_path: Path, kind: str) -> None:
    async def exercise() -> None:
        endpoint = f"tcp://127.0.0.1:{free_port()}" if kind == "tcp" else f"ipc://{tmp_path}/s"
        (tmp_path / "b").mkdir()
        first = Bus(settings(tmp_path, status=endpoint), SystemClock(), MAX_AUDIO_S)
        second = Bus(settings(tmp_path / "b", status=endpoint), SystemClock(), MAX_AUDIO_S)
        try:
            first.open()
            with pytest.raises(ConfigError, match="Another daemon may be running"):
                second.open()
        finally:
            first.close()
            second.close()

    asyncio.run(exercise())


def free_port() -> int:
    with zmq.Context() as context, context.socket(zmq.REP) as socket:
        return socket.bind_to_random_port("tcp://127.0.0.1")


def test_a_client_without_a_daemon_says_what_to_do(tmp_path: Path) -> None:
    with client(tmp_path, timeout_s=0.1) as cell, pytest.raises(NoDaemonError, match="cellctl run"):
        cell.snapshot()
