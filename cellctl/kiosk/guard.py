"""What every request has to pass before a page is made for it, and what every answer says.

The page is served to a room, and browsers there look at other sites too. A request that names a
host which the page is not known by comes from a name that somebody pointed here (DNS rebinding);
one that another site's page sent says so in its ``Origin``. Both are refused, WebSockets included.
Nobody may hold more pages than people open, or send more than a passphrase.
"""

from __future__ import annotations

import ipaddress
import socket
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from http import HTTPStatus
from typing import Final
from urllib.parse import SplitResult, urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from cellctl.config import CellConfig
from cellctl.kiosk.origin import device_of, is_loopback
from cellctl.kiosk.words import Words

PER_ADDRESS: Final = 20
"""Pages that one address may have open; the cell's own computer may have more."""
RESERVE: Final = 20
"""Pages that stay free for the cell's own computer, however many are open."""
MOST_BODY: Final = 8192
"""Bytes of the longest form: a passphrase of 500 letters, each as twelve."""
SOCKET_PATH: Final = "/_nicegui_ws/"
_ASSETS: Final = ("/_nicegui/", "/look/", "/job/", "/favicon.ico")
"""Files; for everything else a page is made, which is kept for a while."""
_SENDS: Final = frozenset({"POST", "PUT", "PATCH", "DELETE"})
_POLICY: Final = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:; "
    "connect-src 'self'; worker-src 'self' blob:; object-src 'none'; "
    "base-uri 'self'; form-action 'self'; frame-ancestors 'none'"
)
"""What a page may load: nothing from elsewhere. The page library evaluates what its own server
sends, hence the two ``unsafe``."""
_HEADERS: Final = {
    "Content-Security-Policy": _POLICY,
    "X-Content-Type-Options": "nosniff",
    # Browsers say by it where a form came from; other sites are told nothing.
    "Referrer-Policy": "same-origin",
}


@dataclass(frozen=True)
class Refusal:
    """Why a request is not taken."""

    status: HTTPStatus
    text: str


class Names:
    """By what hosts and origins the page is known.

    Args:
        config: the cell.
        computer: its own name.
    """

    def __init__(self, config: CellConfig, computer: str) -> None:
        public = urlsplit(config.kiosk.public_url)
        full = computer.lower()
        short = full.partition(".")[0]
        # ``.local``: by which computers of a room find each other (mDNS).
        own = {full, short, f"{short}.local", "localhost"}
        self._hosts = own | {name.lower().rstrip(".") for name in config.kiosk.host_names}
        self._public = _origin(public) if public.hostname else ""
        if public.hostname:
            self._hosts.add(public.hostname)

    def refusal(self, headers: Headers) -> Refusal | None:
        """What speaks against where a request goes to and comes from; None for nothing."""
        host = headers.get("host", "")
        name = _hostname(host)
        if not _is_address(name) and name not in self._hosts:
            return Refusal(
                HTTPStatus.MISDIRECTED_REQUEST,
                f"This page is not known as {name!r}. If it should be, name it in "
                "kiosk.host_names of the cell's configuration.",
            )
        origin = headers.get("origin")
        if origin is None:
            return None
        parts = _split(origin)
        if parts is not None and parts.netloc.lower() == host.lower():
            return None
        if parts is not None and self._public and _origin(parts) == self._public:
            return None
        return Refusal(HTTPStatus.FORBIDDEN, "Another site's page asked for this.")


class Guard:
    """The outermost layer of the page's server.

    Args:
        app: what it guards.
        config: the cell.
        pages: the address of each page that is open now.
    """

    def __init__(self, app: ASGIApp, config: CellConfig, pages: Callable[[], list[str]]) -> None:
        self._app = app
        self._names = Names(config, socket.gethostname())
        self._pages = pages
        self._most = config.kiosk.most_pages
        self._words = Words(config.dialogue.language)
        self._sockets: Counter[str] = Counter()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Take a request, or refuse it; see ASGI."""
        match scope["type"]:
            case "http":
                await self._http(scope, receive, send)
            case "websocket":
                await self._websocket(scope, receive, send)
            case _:
                await self._app(scope, receive, send)

    async def _http(self, scope: Scope, receive: Receive, send: Send) -> None:
        async def dressed(message: Message) -> None:
            if message["type"] == "http.response.start":
                MutableHeaders(scope=message).update(_HEADERS)
            await send(message)

        headers = Headers(scope=scope)
        refusal = self._names.refusal(headers) or self._too_much(scope, headers)
        if refusal is None:
            await self._app(scope, receive, dressed)
            return
        # What is left of the body is not read: the connection ends with the answer.
        closing = {"Connection": "close", "Retry-After": "60"}
        answer = PlainTextResponse(refusal.text, refusal.status, headers=closing)
        await answer(scope, receive, dressed)

    def _too_much(self, scope: Scope, headers: Headers) -> Refusal | None:
        path = scope["path"]
        if path.startswith(SOCKET_PATH):
            return Refusal(HTTPStatus.BAD_REQUEST, "Pages are served by WebSocket.")
        if scope["method"] in _SENDS:
            length = headers.get("content-length", "")
            if not length.isdecimal():
                return Refusal(HTTPStatus.LENGTH_REQUIRED, "How much is sent must be said.")
            if int(length) > MOST_BODY:
                return Refusal(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, "That is too much.")
        makes_page = scope["method"] not in _SENDS and not path.startswith(_ASSETS)
        if makes_page and self._is_full(_address(scope), Counter(map(device_of, self._pages()))):
            return Refusal(HTTPStatus.SERVICE_UNAVAILABLE, self._words.say("page.too_many"))
        return None

    async def _websocket(self, scope: Scope, receive: Receive, send: Send) -> None:
        address = _address(scope)
        refused = self._names.refusal(Headers(scope=scope)) is not None
        if refused or self._is_full(address, self._sockets):
            await receive()  # the request itself
            await send({"type": "websocket.close", "code": 1008})
            return
        self._sockets[address] += 1
        try:
            await self._app(scope, receive, send)
        finally:
            self._sockets[address] -= 1
            if not self._sockets[address]:
                del self._sockets[address]

    def _is_full(self, address: str, opened: Counter[str]) -> bool:
        """Whether that address may open no further one."""
        if is_loopback(address):
            return opened.total() >= self._most + RESERVE
        others = sum(count for name, count in opened.items() if not is_loopback(name))
        return others >= self._most or opened[address] >= PER_ADDRESS


def _address(scope: Scope) -> str:
    """Of the device that asks."""
    client = scope.get("client")
    return device_of(str(client[0])) if client else ""


def _hostname(host: str) -> str:
    """Of a ``Host`` header, without its port; empty when it is none."""
    try:
        return (urlsplit(f"//{host}").hostname or "").rstrip(".")
    except ValueError:
        return ""


def _split(origin: str) -> SplitResult | None:
    """The parts of an ``Origin`` header; None when it is none."""
    try:
        return urlsplit(origin)
    except ValueError:
        return None


def _is_address(name: str) -> bool:
    """Whether it is a network address, which nobody can point elsewhere."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _origin(parts: SplitResult) -> str:
    """As browsers say it: without the port that its scheme has anyway."""
    usual = {"http": ":80", "https": ":443"}.get(parts.scheme.lower(), "")
    netloc = parts.netloc.lower()
    return f"{parts.scheme}://{netloc.removesuffix(usual) if usual else netloc}".lower()
