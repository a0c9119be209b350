"""Keys: who has none that is allowed gets nothing, and no secret is ever told."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Callable
from pathlib import Path

import pytest
import zmq

from cellctl import keys
from cellctl.assembly import Role
from cellctl.client import CellClient, NoDaemonError
from cellctl.clock import SystemClock
from cellctl.config import BusSection, CellConfig, load_config
from cellctl.control.bus import Bus
from cellctl.errors import CellctlError, ConfigError, RefusedError, UsageError
from cellctl.messages import GripperData, StatusMessage
from tests.cell.harness import CONFIG
from tests.control.served import MAX_AUDIO_S, PATIENCE_S, serving, settings


def free_port() -> int:
    with zmq.Context() as context, context.socket(zmq.REP) as socket:
        return socket.bind_to_random_port("tcp://127.0.0.1")


def wide(folder: Path) -> BusSection:
    """End points on all of this machine's addresses, and a folder with the cell's key."""
    keys.make_server(folder / "keys")
    ports = {name: f"tcp://*:{free_port()}" for name in ("status", "visitor", "operator")}
    return BusSection.model_validate({**ports, "keys": str(folder / "keys")})


def made(folder: Path, name: str, role: Role) -> Path:
    """The key file of a client that is allowed."""
    keys.make_client(folder / "keys", name, role, folder / f"{name}.key")
    return folder / f"{name}.key"


def client(
    own: BusSection, role: Role, key: Path | None, timeout_s: float = PATIENCE_S
) -> CellClient:
    config: CellConfig = load_config(CONFIG).model_copy(update={"bus": own})
    return CellClient.for_role(config, role, timeout_s, key)


def test_a_key_opens_the_doors_of_its_role(tmp_path: Path) -> None:
    own = wide(tmp_path)
    operator = made(tmp_path, "desk", Role.OPERATOR)
    visitor = made(tmp_path, "page", Role.VISITOR)

    async def exercise() -> None:
        async with serving(own):
            for key, role in (
                (operator, Role.OPERATOR),
                (operator, Role.VISITOR),
                (visitor, Role.VISITOR),
            ):
                with client(own, role, key) as cell:
                    reply = await asyncio.to_thread(cell.command, "stop")
                    assert reply.message == f"{role} sent 0 bytes"
            with (
                client(own, Role.OPERATOR, visitor) as cell,
                pytest.raises(RefusedError, match="does not take this key"),
            ):
                await asyncio.to_thread(cell.command, "stop")
            with client(own, Role.VISITOR, None) as cell:
                with pytest.raises(UsageError, match="with a key only"):
                    cell.command("stop")
                with pytest.raises(UsageError, match="with a key only"):
                    cell.subscribe()

    asyncio.run(exercise())


def test_a_client_that_is_not_allowed_gets_nothing(tmp_path: Path) -> None:
    own = wide(tmp_path)
    known = made(tmp_path, "page", Role.VISITOR)
    stranger = made(tmp_path, "stranger", Role.OPERATOR)
    keys.revoke(tmp_path / "keys", "stranger")
    (tmp_path / "other").mkdir()
    wide(tmp_path / "other")
    elsewhere = made(tmp_path / "other", "page", Role.VISITOR)
    door, status = (e.replace("*", "127.0.0.1") for e in (own.visitor, own.status))

    async def exercise() -> None:
        async with serving(own) as bus:
            with (
                CellClient(door, status, PATIENCE_S, known) as one,
                CellClient(door, status, PATIENCE_S, stranger) as two,
                CellClient(door, status, 0.3, elsewhere) as three,
                CellClient(door, status, 0.3) as four,
            ):
                everyone = (one, two, three, four)
                for cell in everyone:
                    cell.subscribe()
                with pytest.raises(RefusedError, match="does not take this key"):
                    await asyncio.to_thread(two.command, "stop")
                for cell in (three, four):
                    with pytest.raises(NoDaemonError):
                        await asyncio.to_thread(cell.command, "stop")
                await heard(bus, one)
                for cell in everyone[1:]:
                    assert await asyncio.to_thread(list, cell.messages(0.1)) == []

    asyncio.run(exercise())


async def heard(bus: Bus, cell: CellClient) -> StatusMessage:
    """What a subscriber hears first of what is published again and again."""
    for _ in range(int(PATIENCE_S / 0.1)):
        bus.publish(GripperData(holding="part"), "idle")
        first = await asyncio.to_thread(lambda: next(cell.messages(0.1), None))
        if first is not None:
            return first
    raise AssertionError("nothing was heard")


def test_a_revoked_client_is_shut_out_at_once_and_the_others_stay(tmp_path: Path) -> None:
    own = wide(tmp_path)
    desk = made(tmp_path, "desk", Role.OPERATOR)
    page = made(tmp_path, "page", Role.VISITOR)

    async def exercise() -> None:
        async with serving(own) as bus:
            with (
                client(own, Role.VISITOR, desk) as stays,
                client(own, Role.VISITOR, page) as goes,
            ):
                await asyncio.to_thread(goes.command, "stop")
                await heard(bus, goes)
                await heard(bus, stays)
                keys.revoke(tmp_path / "keys", "page")
                with pytest.raises(RefusedError, match="does not take this key"):
                    await asyncio.to_thread(goes.command, "stop")
                await asyncio.to_thread(stays.command, "stop")

                def silent() -> bool:
                    bus.publish(GripperData(holding="part"), "idle")
                    return not list(goes.messages(0.05))

                await until(silent)
                before = (await heard(bus, stays)).seq
                assert (await heard(bus, stays)).seq > before
                assert silent()

    asyncio.run(exercise())


async def until(holds: Callable[[], bool]) -> None:
    for _ in range(int(PATIENCE_S / 0.1)):
        if holds():
            return
        await asyncio.sleep(0.05)
    raise AssertionError("waited in vain")


def test_an_open_connection_is_not_heard_any_more_once_its_key_is_revoked(tmp_path: Path) -> None:
    own = wide(tmp_path)
    key = keys.client_key(made(tmp_path, "page", Role.VISITOR))

    async def exercise() -> None:
        async with serving(own):
            context = zmq.asyncio.Context()
            try:
                socket = context.socket(zmq.DEALER)
                socket.curve_secretkey = key.own.secret
                socket.curve_publickey = key.own.public
                socket.curve_serverkey = key.server
                socket.connect(own.visitor.replace("*", "127.0.0.1"))
                await socket.send(b'{"id": "1", "body": {"command": "stop"}}')
                assert await socket.poll(PATIENCE_S * 1000)
                await socket.recv_multipart()
                keys.revoke(tmp_path / "keys", "page")
                await socket.send(b'{"id": "2", "body": {"command": "stop"}}')
                assert not await socket.poll(300)
            finally:
                context.destroy(linger=0)

    asyncio.run(exercise())


def test_a_wide_end_point_without_keys_is_refused(tmp_path: Path) -> None:
    own = settings(tmp_path, visitor="tcp://0.0.0.0:5999", keys=str(tmp_path / "keys"))
    with pytest.raises(ConfigError, match=r"bus\.visitor .*`cellctl keys make`"):
        Bus(own, SystemClock(), MAX_AUDIO_S)


def test_a_secret_that_others_can_read_or_change_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = wide(tmp_path)
    file = made(tmp_path, "desk", Role.OPERATOR)
    secret = tmp_path / "keys" / "server.key"
    assert [path.stat().st_mode & 0o777 for path in (file, secret)] == [0o600, 0o600]
    secret.chmod(0o640)
    with pytest.raises(ConfigError, match=r"others may use.*0640.*chmod 600"):
        Bus(own, SystemClock(), MAX_AUDIO_S)
    file.chmod(0o604)
    with pytest.raises(ConfigError, match="chmod 600"):
        client(own, Role.OPERATOR, file)
    secret.chmod(0o600)
    someone_else = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: someone_else)
    with pytest.raises(ConfigError, match="belongs to another user"):
        Bus(own, SystemClock(), MAX_AUDIO_S)


@pytest.mark.parametrize("change", ["cut", "mixed", "no key", "empty"])
def test_a_damaged_key_file_is_refused_without_telling_what_it_holds(
    tmp_path: Path, change: str
) -> None:
    wide(tmp_path)
    file = made(tmp_path, "desk", Role.OPERATOR)
    text = file.read_text()
    pair = keys.client_key(file).own
    other = keys.client_key(made(tmp_path, "other", Role.OPERATOR)).own
    file.write_text(
        {
            "cut": text.replace(pair.secret.decode(), pair.secret.decode()[:-1]),
            "mixed": text.replace(pair.secret.decode(), other.secret.decode()),
            "no key": text.replace(pair.secret.decode(), pair.secret.decode()[:-1] + "~"),
            "empty": "",
        }[change]
    )
    with pytest.raises(ConfigError) as refusal:
        keys.client_key(file)
    for secret in (pair.secret, other.secret):
        assert secret.decode()[:-1] not in str(refusal.value)
    assert pair.secret.decode() not in repr(pair) + repr(keys.ClientKey(pair, other.public))


def test_a_key_is_made_once_and_a_name_that_cannot_be_one_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="cellctl keys make"):
        made(tmp_path, "desk", Role.OPERATOR)
    wide(tmp_path)
    made(tmp_path, "desk", Role.OPERATOR)
    refusals: list[tuple[Callable[[], object], str]] = [
        (lambda: keys.make_server(tmp_path / "keys"), "has a key already"),
        (lambda: made(tmp_path, "desk", Role.VISITOR), "There is a key for desk already"),
        (lambda: made(tmp_path, "../desk", Role.VISITOR), "cannot be the name"),
        (lambda: keys.revoke(tmp_path / "keys", "page"), "Its clients: desk"),
    ]
    for act, says in refusals:
        with pytest.raises(CellctlError, match=says):
            act()
    taken = tmp_path / "taken.key"
    taken.touch()
    with pytest.raises(UsageError, match="exists already"):
        keys.make_client(tmp_path / "keys", "page", Role.VISITOR, taken)
    assert [client.name for client in keys.clients(tmp_path / "keys")] == ["desk"]
