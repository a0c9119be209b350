"""What the page's server refuses before a page is made: foreign names and sites, and too much."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager, ExitStack

import pytest
from starlette.applications import Starlette
from starlette.datastructures import Headers
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.routing import Route, WebSocketRoute
from starlette.testclient import TestClient, WebSocketTestSession
from starlette.websockets import WebSocket, WebSocketDisconnect

from cellctl.kiosk.guard import MOST_BODY, PER_ADDRESS, RESERVE, SOCKET_PATH, Guard, Names
from cellctl.kiosk.origin import device_of
from tests.cell.harness import cell_config

PHONE, OTHER, HERE = "192.168.7.50", "192.168.7.51", "127.0.0.1"
MOST = 30
SITE = {"public_url": "https://cell.example", "host_names": ("show.local",), "most_pages": MOST}


class House:
    """A guard before an application that says yes to everything."""

    def __init__(self) -> None:
        self.pages: list[str] = []
        inside = Starlette(
            routes=[
                Route("/{path:path}", _answer, methods=["GET", "POST"]),
                WebSocketRoute("/{path:path}", _talk),
            ]
        )
        self.guard = Guard(inside, cell_config(kiosk=SITE), lambda: self.pages)

    def client(self, address: str, host: str = "192.168.7.2:8080") -> TestClient:
        return TestClient(self.guard, f"http://{host}", client=(address, 50000))

    def connected(
        self, host: str = "192.168.7.2:8080", **headers: str
    ) -> AbstractContextManager[WebSocketTestSession]:
        client = self.client(PHONE, host)
        return client.websocket_connect(f"ws://{host}{SOCKET_PATH}", headers=headers)

    def get(self, path: str = "/", address: str = PHONE, host: str = "192.168.7.2:8080") -> int:
        return int(self.client(address, host).get(path).status_code)


async def _answer(request: Request) -> PlainTextResponse:
    return PlainTextResponse(f"{len(await request.body())} bytes")


async def _talk(socket: WebSocket) -> None:
    await socket.accept()
    await socket.send_text("open")
    await socket.receive()


@pytest.fixture
def house() -> House:
    return House()


@pytest.mark.parametrize(
    "host",
    [
        *("192.168.7.2:8080", "127.0.0.1", "localhost:8080", "[::1]:8080", "computer.local"),
        *("COMPUTER", "cell.example", "show.local:8080", "computer.local.", "computer.example"),
    ],
)
def test_the_page_is_known_by_its_addresses_and_names(host: str) -> None:
    assert _refused({"host": host}) == 0


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1.evil.example", "", "show.local.evil.example", "[::1"]
)
def test_a_name_that_somebody_else_pointed_here_is_refused(host: str) -> None:
    assert _refused({"host": host}) == 421


@pytest.mark.parametrize(
    ("origin", "status"),
    [
        ("http://192.168.7.2:8080", 0),
        ("https://cell.example", 0),  # a proxy with TLS, which may ask by another name
        ("http://cell.example", 403),
        ("http://192.168.7.2:9090", 403),
        ("http://evil.example", 403),
        ("null", 403),
        ("http://[", 403),
        ("https://cell.example:443", 0),
        ("", 403),
    ],
)
def test_only_the_pages_own_site_may_ask(origin: str, status: int) -> None:
    assert _refused({"host": "192.168.7.2:8080", "origin": origin}) == status


def _refused(headers: Mapping[str, str]) -> int:
    refusal = Names(cell_config(kiosk=SITE), "Computer.example").refusal(Headers(headers))
    return int(refusal.status) if refusal is not None else 0


def test_refusals_say_why_and_answers_forbid_what_is_elsewhere(house: House) -> None:
    refused = house.client(PHONE, "evil.example").get("/")
    assert refused.status_code == 421
    assert "kiosk.host_names" in refused.text
    for answer in (refused, house.client(PHONE).get("/")):
        assert "default-src 'self'" in answer.headers["Content-Security-Policy"]


def test_a_websocket_of_another_site_or_name_is_refused(house: House) -> None:
    with house.connected(origin="http://192.168.7.2:8080") as socket:
        assert socket.receive_text() == "open"
    for host in ("192.168.7.2:8080", "evil.example"):
        with (
            pytest.raises(WebSocketDisconnect),
            house.connected(host, origin="http://evil.example"),
        ):
            pytest.fail("it was taken")


def test_what_is_sent_has_a_length_and_a_limit(house: House) -> None:
    client = house.client(PHONE)
    assert client.post("/operator/log-in", content=b"x" * MOST_BODY).text == f"{MOST_BODY} bytes"
    assert client.post("/operator/log-in", content=b"x" * (MOST_BODY + 1)).status_code == 413
    assert client.post("/operator/log-in", content=iter([b"x"] * 3)).status_code == 411
    assert client.post(SOCKET_PATH, content=b"x").status_code == 400


def test_one_address_may_have_some_pages_and_all_together_more(house: House) -> None:
    house.pages = [PHONE] * PER_ADDRESS
    assert house.get(address=PHONE) == 503
    assert house.get("/nothing/here", address=PHONE) == 503
    assert house.get("/look/kiosk.css", address=PHONE) == 200
    assert house.get(address=OTHER) == 200
    house.pages += [OTHER] * (MOST - PER_ADDRESS)
    assert house.get(address="192.168.7.52") == 503
    # The cell's own screen never stands before a closed door.
    assert house.get(address=HERE) == 200
    house.pages += [HERE] * RESERVE
    assert house.get(address=HERE) == 503


def test_connections_are_counted_while_they_last(house: House) -> None:
    with ExitStack() as stack:
        for _ in range(PER_ADDRESS):
            assert stack.enter_context(house.connected()).receive_text() == "open"
        with pytest.raises(WebSocketDisconnect), house.connected():
            pytest.fail("one more was taken")
    with house.connected() as socket:
        assert socket.receive_text() == "open"


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("fd00:1:2:3::5", "fd00:1:2:3:aaaa::6", True),  # as many addresses as it likes
        ("2001:db8:1:2::1", "2001:db8:1:3::1", False),
        ("fe80::1%eth0", "fe80::2%eth0", False),  # all devices of a link share that network
        ("192.168.7.50", "192.168.7.51", False),
        ("::ffff:192.168.7.50", "192.168.7.50", True),
        ("testclient", "testclient", True),
    ],
)
def test_a_device_is_known_by_its_address_or_its_network(one: str, other: str, same: bool) -> None:
    assert (device_of(one) == device_of(other)) == same


def test_the_cells_own_screen_may_come_by_either_protocol(house: House) -> None:
    house.pages = [f"fd00:1::{number}" for number in range(PER_ADDRESS)]
    assert house.get(address="fd00:1::ffff", host="[fd00::1]:8080") == 503
    house.pages += [OTHER] * (MOST - PER_ADDRESS)
    for own in ("::1", "::ffff:127.0.0.1", HERE):
        assert house.get(address=own, host="[::1]:8080") == 200
