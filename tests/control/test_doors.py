"""The two doors: the role is the door's, everybody gets an answer, nothing grows without end."""

from __future__ import annotations

import asyncio
import stat
import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from cellctl.assembly import Role
from cellctl.control.door import IN_ALL, PER_CLIENT, Answer
from cellctl.messages import (
    MAX_REQUEST,
    ControlReply,
    ControlRequest,
    attachment_limit,
)
from tests.control.served import (
    MAX_AUDIO_S,
    handler,
    knocking,
    reply,
    request,
    serving,
    settings,
)

HEAR = b'{"id": "h", "body": {"command": "hear", "name": "a.wav"}}'


@pytest.mark.parametrize("role", list(Role))
def test_the_role_is_that_of_the_door(tmp_path: Path, role: Role) -> None:
    async def exercise() -> ControlReply:
        own = settings(tmp_path)
        async with serving(own), knocking(own.door(role)) as socket:
            await socket.send(request("1", "reset"))
            return await reply(socket)

    assert asyncio.run(exercise()).message == f"{role} sent 0 bytes"


def test_the_files_mode_keeps_the_operators_door_for_its_group(tmp_path: Path) -> None:
    def modes() -> dict[str, int]:
        return {file.name: stat.S_IMODE(file.stat().st_mode) for file in tmp_path.iterdir()}

    async def exercise() -> dict[str, int]:
        async with serving(settings(tmp_path)):
            return modes()

    assert asyncio.run(exercise()) == {"status": 0o666, "visitor": 0o666, "operator": 0o660}


def test_what_a_visitor_sends_is_as_long_as_a_recording_at_most(tmp_path: Path) -> None:
    limit = attachment_limit(Role.VISITOR, MAX_AUDIO_S)

    async def exercise(role: Role, size: int) -> ControlReply:
        own = settings(tmp_path)
        async with serving(own), knocking(own.door(role)) as socket:
            await socket.send_multipart([HEAR, bytes(size)])
            return await reply(socket)

    assert asyncio.run(exercise(Role.VISITOR, limit)).ok
    assert asyncio.run(exercise(Role.OPERATOR, limit + 1)).ok
    refused = asyncio.run(exercise(Role.VISITOR, limit + 1))
    assert (refused.id, refused.error and refused.error.code) == ("h", "usage")
    assert refused.error is not None
    assert "visitor's door" in refused.error.message


@pytest.mark.parametrize(
    ("frames", "name", "says"),
    [
        ([b" " * (MAX_REQUEST + 1)], "?", "are taken at most"),
        ([request("a"), b"", b""], "a", "has 3 frames"),
        ([b'{"schema_version": 1, "id": "b", "body": {"command": "stop"}}'], "b", "version 2"),
        ([b'{"id": "c", "body": {"command": "fly"}}'], "c", "fly"),
        ([b"[" * 5000], "?", "request"),
    ],
)
def test_a_malformed_request_is_told_what_is_wrong_with_it(
    tmp_path: Path, frames: list[bytes], name: str, says: str
) -> None:
    async def exercise() -> ControlReply:
        own = settings(tmp_path)
        async with serving(own), knocking(own.visitor) as socket:
            await socket.send_multipart(frames)
            return await reply(socket)

    answer = asyncio.run(exercise())
    assert answer.error is not None
    assert (answer.id, answer.error.code) == (name, "invalid")
    assert says in answer.error.message + answer.error.hint


_NEAR = st.sampled_from([request("1"), request("2", "stop"), request("3", "say"), HEAR])
_CUT = st.tuples(_NEAR, st.integers(0, 60)).map(lambda pair: pair[0][: pair[1]])
_FRAMES = st.lists(st.one_of(st.binary(max_size=40), _NEAR, _CUT), min_size=1, max_size=4)


@hypothesis_settings(max_examples=25, deadline=None)
@given(st.lists(_FRAMES, min_size=1, max_size=30))
def test_whatever_comes_in_gets_one_answer_each(messages: list[list[bytes]]) -> None:
    async def exercise(folder: Path) -> ControlReply:
        own = settings(folder)
        async with serving(own), knocking(own.visitor) as socket:
            for frames in messages:
                await socket.send_multipart(frames)
            for _ in messages:
                await reply(socket)
            await socket.send(request("last"))
            return await reply(socket)

    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        last = asyncio.run(exercise(Path(name)))
    assert (last.id, last.ok) == ("last", True)


def test_too_many_requests_are_told_so_and_stop_is_heard_all_the_same(tmp_path: Path) -> None:
    async def exercise() -> None:
        release = asyncio.Event()

        async def slow(asked: ControlRequest, file: bytes | None, role: Role) -> Answer:
            if asked.body.command != "stop":
                await release.wait()
            return await handler(asked, file, role)

        own = settings(tmp_path)
        async with serving(own, slow), knocking(own.visitor) as socket:
            for number in range(PER_CLIENT + 2):
                await socket.send(request(str(number)))
            busy = [await reply(socket), await reply(socket)]
            await socket.send(request("halt", "stop"))
            assert (await reply(socket)).id == "halt"
            release.set()
            done = {(await reply(socket)).id for _ in range(PER_CLIENT)}
        assert {answer.error.code for answer in busy if answer.error} == {"busy"}
        assert {answer.id for answer in busy} | done == {str(n) for n in range(PER_CLIENT + 2)}

    asyncio.run(exercise())


def test_a_crowd_at_one_door_leaves_the_other_free(tmp_path: Path) -> None:
    async def exercise() -> None:
        release = asyncio.Event()

        async def slow(asked: ControlRequest, file: bytes | None, role: Role) -> Answer:
            if role is Role.VISITOR:
                await release.wait()
            return await handler(asked, file, role)

        own = settings(tmp_path)
        async with (
            serving(own, slow),
            asyncio.TaskGroup() as crowd,
            knocking(own.visitor) as late,
            knocking(own.operator) as operator,
        ):
            here = asyncio.Semaphore(0)

            async def visitor() -> None:
                async with knocking(own.visitor) as socket:
                    for number in range(PER_CLIENT + 1):
                        await socket.send(request(str(number)))
                    await reply(socket)  # the one that is too many: the others have been taken
                    here.release()
                    for _ in range(PER_CLIENT):
                        await reply(socket)

            for _ in range(IN_ALL // PER_CLIENT):
                crowd.create_task(visitor())
            for _ in range(IN_ALL // PER_CLIENT):
                await here.acquire()
            await late.send(request("late"))
            answer = await reply(late)
            assert answer.error is not None
            assert answer.error.code == "busy"
            await operator.send(request("operator"))
            assert (await reply(operator)).ok
            release.set()

    asyncio.run(exercise())


def test_a_thousand_quick_requests_are_all_answered_and_hold_nobody_up(tmp_path: Path) -> None:
    async def exercise() -> None:
        own = settings(tmp_path)
        async with (
            serving(own),
            knocking(own.visitor) as socket,
            knocking(own.operator) as operator,
        ):
            for number in range(1000):
                await socket.send(request(str(number)))
            await operator.send(request("operator"))
            assert (await reply(operator)).ok
            answers = [await reply(socket) for _ in range(1000)]
        assert {answer.id for answer in answers} == {str(number) for number in range(1000)}
        assert {answer.error.code for answer in answers if answer.error} <= {"busy"}
        assert any(answer.ok for answer in answers)

    asyncio.run(exercise())
