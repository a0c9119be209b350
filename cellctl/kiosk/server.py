"""The process behind ``cellctl kiosk``: serves the pages, and follows the bus for all of them."""

from __future__ import annotations

from contextlib import AsyncExitStack
from http import HTTPStatus
from pathlib import Path
from typing import Final

import structlog
from fastapi import Request, Response
from fastapi.responses import PlainTextResponse
from nicegui import Client, app, ui
from starlette.middleware.sessions import SessionMiddleware

from cellctl.config import CellConfig
from cellctl.kiosk.bus_link import BusLink
from cellctl.kiosk.cookies import cookie_secret
from cellctl.kiosk.guard import Guard
from cellctl.kiosk.operator.login import FrontDoor
from cellctl.kiosk.operator.page import operator_page
from cellctl.kiosk.origin import is_here
from cellctl.kiosk.shell import LOOK, Site, shell
from cellctl.kiosk.take_home import JobFiles
from cellctl.kiosk.take_page import add_files, take_page
from cellctl.kiosk.visitor.page import visitor_page

log = structlog.get_logger(__name__)

_RECONNECT_S: Final = 30.0
"""So long a browser that was cut off finds its page again as it was."""


def serve(config: CellConfig, key: Path | None = None) -> None:
    """Serve the pages until SIGTERM or SIGINT.

    Args:
        config: the cell.
        key: the page's key file, for a bus that is locked.
    """
    site = Site(config, BusLink(config, key))
    files = JobFiles(site.link)
    door = FrontDoor.of(config)
    door.add_routes()
    stack = AsyncExitStack()
    site.mirror.watch(files.built)

    async def begin() -> None:
        await stack.enter_async_context(site.link.following())
        log.info("page served", address=config.kiosk.address, port=config.kiosk.port)

    app.on_startup(begin)
    app.on_shutdown(stack.aclose)
    secret = cookie_secret()
    # The page library adds no sessions of its own then, and what is added last comes first.
    app.add_middleware(SessionMiddleware, secret_key=secret, same_site="strict")
    app.add_middleware(Guard, config=config, pages=_open_pages)
    app.exception_handler(HTTPStatus.NOT_FOUND)(_not_found)
    app.config.socket_io_js_transports = ["websocket"]
    app.add_static_files("/look", LOOK)
    _add_pages(site, files, door)
    add_files(files, config)
    ui.run(
        host=config.kiosk.address,
        port=config.kiosk.port,
        title=config.cell.name,
        favicon=LOOK / "favicon.svg",
        language="en-US",
        reload=False,
        show=False,
        tailwind=False,
        show_welcome_message=False,
        reconnect_timeout=_RECONNECT_S,
        binding_refresh_interval=None,
        storage_secret=secret,
    )


def _add_pages(site: Site, files: JobFiles, door: FrontDoor) -> None:
    @ui.page("/")
    def visitor(request: Request, lang: str = "") -> None:
        who = _secret(request)
        with shell(site, lang, "page.title", role="visitor", visitor=who) as page:
            visitor_page(page)

    @ui.page("/take/{job_id}")
    async def take(job_id: str, lang: str = "") -> None:
        with shell(site, lang, "take.title", role="take") as page:
            await take_page(page, files, job_id)

    @ui.page("/operator")
    def operator(request: Request, lang: str = "", refused: str = "") -> None:
        session = door.session(request)
        with shell(site, lang, "operator.title", role="operator") as page:
            if session is None:
                door.form(page, request, refused)
            else:
                operator_page(page, session)


def _secret(request: Request) -> str:
    """By what the cell knows a visitor's own device again; empty for a screen of the cell's own.

    The page library keeps a random id in a signed cookie that scripts cannot read.
    """
    return "" if is_here(request) else str(app.storage.browser["id"])


def _open_pages() -> list[str]:
    """The address of each page that is open, or was until a moment ago."""
    return [client.ip for client in Client.instances.values()]


async def _not_found(_: Request, __: Exception) -> Response:
    """Nothing is there; the page library would make a page that says so, and keep it."""
    return PlainTextResponse("There is no such page.", HTTPStatus.NOT_FOUND)
