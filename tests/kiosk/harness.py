"""A visit for tests: an emulated cell, its daemon, its page, and a browser in front of it."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal
from urllib.parse import urlsplit

from playwright.sync_api import (
    Browser,
    ConsoleMessage,
    Page,
    Request,
    ViewportSize,
    sync_playwright,
)
from playwright.sync_api import TimeoutError as PageTimeoutError

from cellctl.cli.daemon_process import wait_idle
from cellctl.cli.kiosk_process import KioskProcess, running_kiosk, with_own_page
from cellctl.config import CellConfig
from cellctl.credentials import variable_of
from cellctl.passphrase import OPERATOR_CREDENTIAL, PassphraseHash
from cellctl.sim.isolation import isolated
from cellctl.sim.spawn import emulated_cell
from tests.cell.harness import PATIENCE_S, RunningCell, cell_config, watched_daemon

PASSPHRASE = "a few words in a row"  # noqa: S105 - of cells that live for one test
"""Of the operators of every cell here."""
CHROMIUM = Path("/usr/bin/chromium")
ARGUMENTS = (
    "--no-sandbox",  # tests may run as root
    "--use-angle=swiftshader",  # 3D without a graphics card
    "--enable-unsafe-swiftshader",
    "--disable-gpu-compositing",  # all but 3D is drawn sooner without what stands in for one
    "--disable-gpu-watchdog",  # which ends a drawing process that waits for a busy computer
    "--disable-background-networking",
    "--disable-component-update",
    "--autoplay-policy=no-user-gesture-required",
)
SIZES = {"kiosk": (1920, 1080), "portrait": (1080, 1920), "phone": (390, 844)}
"""Screens that the page is made for: width and height in pixels."""
Size = Literal["kiosk", "portrait", "phone"]


@dataclass
class OpenPage:
    """A page in a browser, and everything that it said and asked for."""

    page: Page
    problems: list[str] = field(default_factory=list)
    elsewhere: list[str] = field(default_factory=list)
    """Requests to anybody but the page's own server."""

    def phase(self, *names: str, patience_s: float = PATIENCE_S) -> None:
        """Wait until the visitor's view is in one of these phases."""
        wanted = ", ".join(f'.visit[data-phase="{name}"]' for name in names)
        self.page.wait_for_selector(wanted, timeout=patience_s * 1000)

    def says(self, text: str, patience_s: float = PATIENCE_S) -> None:
        """Wait until the page shows these words, in any case."""
        found = self.page.get_by_text(re.compile(re.escape(text), re.IGNORECASE))
        found.filter(visible=True).first.wait_for(timeout=patience_s * 1000)

    def press(self, name: str) -> None:
        """Press a button by its words."""
        self.page.get_by_role("button", name=name, exact=True).click()

    def type(self, text: str) -> None:
        """Type a sentence and send it."""
        line = self.page.locator(".entry__line").filter(visible=True).first
        line.fill(text)
        line.press("Enter")


@dataclass
class Visit:
    """A cell with its page and a browser.

    Attributes:
        cell: the emulated cell and its daemon.
        kiosk: the process that serves the page.
        browser: a headless Chromium.
        life: the daemon's, which ends when it is closed.
    """

    cell: RunningCell
    kiosk: KioskProcess
    browser: Browser
    folder: Path
    life: ExitStack

    @contextmanager
    def open(self, path: str = "", size: Size = "kiosk", **options: Any) -> Iterator[OpenPage]:
        """Open one page; see ``opened``. What the cell did is told where the page waits in vain."""
        try:
            with opened(self.browser, self.kiosk.url, path, size, **options) as page:
                yield page
        except PageTimeoutError as error:
            now = self.cell.client.snapshot()
            error.add_note(
                f"state {now.state.state}, fault {now.fault}, job {now.job}\n"
                f"{self.cell.daemon.log_tail(8000)}"
            )
            raise


@contextmanager
def opened(
    browser: Browser,
    url: str,
    path: str = "",
    size: Size = "kiosk",
    *,
    scheme: Literal["light", "dark"] = "light",
    graphics: bool = True,
    **options: Any,
) -> Iterator[OpenPage]:
    """Open one page, and watch what goes wrong on it.

    Args:
        browser: where.
        url: of the visitor's view.
        path: after it, such as ``operator`` or ``?lang=de``.
        size: of the screen.
        scheme: what the browser's system prefers.
        graphics: whether it draws in three dimensions, which costs most of a browser's time here.
        options: further ones of ``Browser.new_context``.
    """
    width, height = SIZES[size]
    viewport: ViewportSize = {"width": width, "height": height}
    context = browser.new_context(viewport=viewport, color_scheme=scheme, **options)
    context.set_default_timeout(PATIENCE_S * 1000)
    if not graphics:
        context.add_init_script("HTMLCanvasElement.prototype.getContext = () => null")
    page = context.new_page()
    found = OpenPage(page)
    own = urlsplit(url).netloc

    def said(message: ConsoleMessage) -> None:
        if message.type == "error":
            found.problems.append(message.text)

    def asked(request: Request) -> None:
        parts = urlsplit(request.url)
        if parts.scheme in {"http", "https", "ws", "wss"} and parts.netloc != own:
            found.elsewhere.append(request.url)

    page.on("console", said)
    page.on("pageerror", lambda error: found.problems.append(str(error)))
    page.on("request", asked)
    try:
        page.goto(url + path)
        yield found
    finally:
        context.close()


@contextmanager
def chromium(*arguments: str, niceness: int = 5) -> Iterator[Browser]:
    """The Chromium that Debian packages, without a screen.

    Args:
        arguments: more of its command line.
        niceness: how much it gives way to the cell, 0 to 19.
    """
    with tempfile.TemporaryDirectory(prefix="browser-") as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=_giving_way(Path(folder), niceness), args=[*ARGUMENTS, *arguments]
        )
        try:
            yield browser
        finally:
            browser.close()


def _giving_way(folder: Path, niceness: int) -> Path:
    """A Chromium that does not draw while a cell should move: run by root, it would take
    precedence over every other process; and Linux shares a processor out among sessions first, of
    which it has one of its own, by the niceness in this file (sched(7))."""
    modest = "setpriv --bounding-set=-sys_nice --inh-caps=-sys_nice" if os.geteuid() == 0 else ""
    script = folder / "chromium"
    last = f"[ ! -w /proc/self/autogroup ] || echo {niceness} >/proc/self/autogroup"
    script.write_text(f'#!/bin/sh\n{last}\nexec {modest} {CHROMIUM} "$@"\n')
    script.chmod(0o755)
    return script


@contextmanager
def visit(speed: float = 10.0, **sections: dict[str, Any]) -> Iterator[Visit]:
    """A cell that asks before it builds, with its page and a browser.

    Args:
        speed: cell seconds per wall second.
        sections: settings to change, by section.
    """
    config = cell_config(**{"policy": {"confirmation": "ask"}, **sections})
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        folder = Path(name)
        own = with_own_page(isolated(config, folder, speed))
        with (
            emulated_cell(own, speed) as world,
            ExitStack() as life,
            kiosk_of(own, folder) as kiosk,
            chromium() as browser,
        ):
            cell = life.enter_context(watched_daemon(own, folder, world))
            wait_idle(cell.client, cell.daemon)
            yield Visit(cell, kiosk, browser, folder, life)


@contextmanager
def kiosk_of(config: CellConfig, folder: Path) -> Iterator[KioskProcess]:
    """The page of that cell, as anybody would start it; its log is shown when a test fails."""
    # The page library behaves otherwise in a process that has this variable of pytest's.
    environment = {name: value for name, value in os.environ.items() if "PYTEST" not in name}
    environment[variable_of(OPERATOR_CREDENTIAL)] = PassphraseHash.of(PASSPHRASE).line
    with running_kiosk(config, folder, environment) as kiosk:
        try:
            yield kiosk
        except BaseException:
            print(kiosk.log_tail())  # noqa: T201 - pytest shows it
            raise
