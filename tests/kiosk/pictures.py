"""Pictures of the page in every state, for the docs: ``python -m tests.kiosk.pictures FOLDER``.

An emulated cell is brought into each state by the doors that people use, and a headless Chromium
takes its picture.
"""

from __future__ import annotations

import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Browser
from playwright.sync_api import TimeoutError as PageTimeoutError

from cellctl.assembly import Role
from cellctl.cli.daemon_process import wait_idle
from cellctl.cli.kiosk_process import KioskProcess, with_own_page
from cellctl.client import CellClient
from cellctl.config import CellConfig
from cellctl.errors import RefusedError
from cellctl.messages import HistoryCommand, HistoryData, RecoverCommand, Snapshot
from cellctl.sim.client import SimClient
from cellctl.sim.isolation import isolated
from cellctl.sim.spawn import emulated_cell
from tests.cell.harness import RunningCell, cell_config, watched_daemon
from tests.cell.spoken import hearing, wait_for_ears
from tests.kiosk.harness import PASSPHRASE, OpenPage, Size, chromium, kiosk_of, opened
from tests.virtual_sound import virtual_sound

_SPEED = 2.0
_WISH = "a table with three legs"
_SMALL_WISH = "the letter T"
_REFUSED_WISH = "a penguin"
_BELT = 32
"""Parts on a full belt, so that it is empty before the table is finished."""
_CALL = "Please call 1234, or ask at the desk."
_SCALE = 2 / 3
"""Pixels of a picture for each of the screen's: large enough to read, and small as a file."""
_PATIENCE_S = 900.0
"""How long a computer may take for what is waited for, with everything else that it has to do."""
_DRAWN_MS = 2500
"""So long a page has to draw its 3D view, on a computer without a graphics card."""
_FRAMES = """() => new Promise((done) => {
    let left = 3;
    const frame = () => (left-- ? requestAnimationFrame(frame) : done());
    frame();
})"""
"""What came last is drawn after so many frames, however busy the computer is."""
_COMMON = 32
"""Colours of a picture that stay exactly as they are: those of grounds and large letters."""
_COLOURS = {Image.Quantize.MEDIANCUT: 176, Image.Quantize.MAXCOVERAGE: 48}
"""The others: shades by how much there is of them, and what is rare and like none of them."""
_FAULTS = frozenset({"fault_held", "fault_stopped"})
_HAND_OVER = "thank you, it is mine"


class Album:
    """Takes pictures of one cell's page.

    Args:
        browser: what shows it.
        kiosk: what serves it.
        folder: where they go.
    """

    def __init__(self, browser: Browser, kiosk: KioskProcess, folder: Path) -> None:
        self._browser = browser
        self._kiosk = kiosk
        self._folder = folder

    @contextmanager
    def page(self, size: Size = "kiosk", path: str = "", **options: Any) -> Iterator[OpenPage]:
        """A page to take pictures of."""
        # Less motion: the same state gives the same picture.
        options = {"device_scale_factor": _SCALE, "reduced_motion": "reduce", **options}
        with opened(self._browser, self._kiosk.url, path, size, **options) as page:
            yield page

    @contextmanager
    def operator(self, size: Size = "kiosk", **options: Any) -> Iterator[OpenPage]:
        """The operator's view, logged in."""
        with self.page(size, "operator", device_scale_factor=1.0, **options) as page:
            page.page.set_viewport_size({"width": 1280, "height": 900})
            page.page.fill("#passphrase", PASSPHRASE)
            page.page.press("#passphrase", "Enter")
            page.page.wait_for_selector(".now")
            yield page

    def take(self, opened: OpenPage, name: str, *, drawn_ms: int = _DRAWN_MS) -> None:
        """Take a picture."""
        opened.page.mouse.move(0, 0)
        opened.page.wait_for_timeout(drawn_ms)
        opened.page.evaluate(_FRAMES)
        file = self._folder / f"{name}.png"
        opened.page.screenshot(path=file)
        made_small(file)
        print(f"{file}: {file.stat().st_size / 1000:.0f} kB", flush=True)  # noqa: T201 - output

    def also(self, name: str, phase: str, size: Size = "phone", path: str = "") -> None:
        """A picture of the same state on another screen, in the dark."""
        with self.page(size, path, scheme="dark") as other:
            other.phase(phase)
            self.take(other, name)


def passing(album: Album, screen: OpenPage, cell: RunningCell, phase: str) -> None:
    """A phase that is soon over: the cell stands still for the picture, and not so long that the
    page would notice."""
    screen.phase(phase)
    cell.daemon.process.send_signal(signal.SIGSTOP)
    album.take(screen, phase, drawn_ms=100)
    cell.daemon.process.send_signal(signal.SIGCONT)


def made_small(file: Path) -> None:
    """A quarter of the bytes, and no difference that would be seen."""
    with Image.open(file) as picture:
        colours = picture.convert("RGB")
    every, counts = np.unique(np.asarray(colours).reshape(-1, 3), axis=0, return_counts=True)
    levels: list[int] = every[np.argsort(counts)[-_COMMON:]].ravel().tolist()
    for method, count in _COLOURS.items():
        levels += (colours.quantize(count, method).getpalette() or [])[: 3 * count]
    chosen = Image.new("P", (1, 1))
    chosen.putpalette(levels)
    colours.quantize(palette=chosen, dither=Image.Dither.NONE).save(file, optimize=True)


def at_work(album: Album, page: OpenPage, cell: RunningCell, name: str) -> None:
    """An arm that carries a part; anew, where a busy computer has stopped it meanwhile."""
    while True:
        _going(
            cell, "an arm with a part", lambda now: _at_work(now) and now.gripper.holding == "part"
        )
        page.says(" of ")
        album.take(page, name, drawn_ms=500)
        if cell.client.snapshot().state.state not in _FAULTS:
            return


def at_rest(album: Album, page: OpenPage, cell: RunningCell, name: str) -> None:
    """A cell that was stopped; anew, where a busy computer has lost its robot meanwhile."""
    while True:
        album.take(page, name)
        if not _mended(cell):
            return


def asking(album: Album, screen: OpenPage, cell: RunningCell) -> None:
    """A wish, and the question about it."""
    screen.phase("ready")
    album.take(screen, "ready")
    album.also("ready-dark", "ready", "kiosk")
    screen.type(_REFUSED_WISH)
    screen.says("I cannot design")
    album.take(screen, "refused")
    screen.type(_WISH)
    passing(album, screen, cell, "thinking")
    while True:
        _going(cell, "the question", _asks)
        screen.phase("asking")
        album.take(screen, "asking")
        if cell.client.snapshot().state.state not in _FAULTS:
            break
    album.also("phone", "asking")


def building(album: Album, screen: OpenPage, cell: RunningCell) -> None:
    """The build, with everything that interrupts one."""
    screen.press("Yes")
    screen.phase("building")
    with CellClient.for_role(cell.config, Role.VISITOR) as anna:
        anna.visitor = "a secret of Anna's own browser"
        anna.say("call me Anna")
        anna.say("a small bench")
    _going(cell, "8 parts", lambda now: len(now.standing) >= 8)
    at_work(album, screen, cell, "building")
    with album.page("phone", scheme="dark") as phone:
        at_work(album, phone, cell, "building-phone")
    with album.operator() as desk:
        at_work(album, desk, cell, "operator-cell")
    _stop(screen, cell)
    at_rest(album, screen, cell, "stopped")
    with album.operator() as desk:
        desk.page.click("#to-hand")
        at_rest(album, desk, cell, "operator-hand")
    cell.world.inject("belt_jam")
    _resume(cell)
    _going(cell, "a jam", _is_jammed)
    screen.phase("fault")
    album.take(screen, "fault")
    album.also("fault-phone", "fault")
    with album.operator() as desk:
        album.take(desk, "operator-fault")
    cell.world.clear("belt_jam")
    _resume(cell)
    _going(cell, "an empty belt", lambda now: now.state.state == "feeding_refilling")
    screen.says("I need more parts")
    album.take(screen, "refilling")
    cell.refill()
    _going(cell, "the object", lambda now: now.job is not None and now.job.outcome == "built")
    screen.phase("done")
    album.take(screen, "done")


def handed_over(album: Album, screen: OpenPage) -> None:
    """Somebody may take an object along."""
    screen.type(_HAND_OVER)
    screen.says("Do you take it along?")
    album.take(screen, "hand-over")
    screen.press("No")
    screen.phase("done")


def taken_apart(album: Album, screen: OpenPage, cell: RunningCell) -> None:
    """A small object, and how it comes apart again."""
    screen.phase("ready")
    screen.type(_SMALL_WISH)
    screen.phase("asking")
    screen.press("Yes")
    _going(cell, "the object", lambda now: now.job is not None and now.job.outcome == "built")
    screen.phase("done")
    screen.press("Take it apart")
    screen.says("Shall I take it apart?")
    album.take(screen, "taking-apart-asked")
    screen.press("Yes")
    screen.phase("taking_apart")
    _going(cell, "a part less", lambda now: now.job is not None and now.job.parts_placed >= 1)
    album.take(screen, "taking-apart", drawn_ms=500)
    _going(cell, "nothing", lambda now: now.job is not None and now.job.outcome == "taken_apart")


def behind(album: Album, cell: RunningCell) -> None:
    """The operator's view of what was, and what to take home of it."""
    job = _job(cell)
    with album.page("phone", f"take/{job}") as home:
        home.page.wait_for_selector("h1")
        album.take(home, "take-home")
    with album.operator() as desk:
        desk.page.click("#to-parts")
        album.take(desk, "operator-parts")
        desk.page.click("#to-history")
        desk.page.locator(".job", has_text="built").first.click()
        album.take(desk, "operator-history")
    with album.operator("phone", scheme="dark") as desk:
        desk.page.set_viewport_size({"width": 390, "height": 844})
        album.take(desk, "operator-phone")


def stale(album: Album, screen: OpenPage, cell: RunningCell) -> None:
    """A cell that has fallen silent."""
    cell.daemon.process.send_signal(signal.SIGSTOP)
    screen.page.wait_for_selector('.page[data-stale="true"]')
    album.take(screen, "stale")
    cell.daemon.process.send_signal(signal.SIGCONT)


def doubtful(album: Album, cell: RunningCell) -> None:
    """A part of which nobody knows where it is."""
    cell.world.inject("speed_slider", fraction=0.1)
    cell.client.say(_SMALL_WISH)
    cell.wait_state("validating_confirming")
    cell.client.confirm(True)
    cell.wait(
        "an arm on its way",
        lambda now: now.state.state == "assembling_picking" and now.arm.moving,
    )
    cell.world.inject("gripper_fault")
    cell.world.inject("speed_slider", fraction=1.0)
    cell.wait("a doubt", lambda now: bool(now.doubt))
    cell.world.clear("gripper_fault")
    cell.client.command("reset")
    cell.wait_state("paused_resting")
    with album.operator() as desk:
        album.take(desk, "operator-doubt")
    cell.client.request(RecoverCommand(part="station"))
    cell.client.command("cancel")
    cell.wait_state("paused_resting")
    cell.client.command("resume")
    cell.wait_state("idle")


def _is_jammed(now: Snapshot) -> bool:
    return now.fault.entry is not None and now.fault.entry.code == "belt_jam"


def _asks(now: Snapshot) -> bool:
    return now.state.state == "validating_confirming"


def _at_work(now: Snapshot) -> bool:
    return now.state.state.startswith("assembling")


def _going(cell: RunningCell, what: str, holds: Callable[[Snapshot], bool]) -> None:
    """Wait for something; go on, as an operator does, after faults of a computer that was busy."""
    while True:
        now = cell.wait(what, lambda now: holds(now) or now.state.state in _FAULTS)
        if holds(now):
            return
        _resume(cell)


def _mended(cell: RunningCell) -> bool:
    """Clear a fault, if there is one; whether there was."""
    if cell.client.snapshot().state.state not in _FAULTS:
        return False
    cell.client.command("reset")
    cell.wait_state("paused_resting")
    return True


def _stop(screen: OpenPage, cell: RunningCell) -> None:
    """Stop the arm at work by the page's button; anew, where a fault was sooner."""
    while True:
        _going(cell, "an arm at work", _at_work)
        try:
            screen.page.get_by_role("button", name="Stop", exact=True).click(timeout=5000)
            screen.page.get_by_text("Stopped").first.wait_for(timeout=10_000)
        except PageTimeoutError:
            continue
        if cell.client.snapshot().state.state == "paused_resting":
            return


def _resume(cell: RunningCell) -> None:
    """Go on, whatever fault is to be cleared before."""
    while True:
        _mended(cell)
        try:
            cell.client.command("resume")
        except RefusedError:
            continue
        return


def _job(cell: RunningCell) -> str:
    """The last job that built something."""
    reply = cell.client.request(HistoryCommand())
    assert isinstance(reply.data, HistoryData)
    return next(job.job_id for job in reply.data.jobs if job.outcome == "built")


@contextmanager
def _page_of(
    folder: Path, **sections: dict[str, Any]
) -> Iterator[tuple[CellConfig, SimClient, Browser, KioskProcess]]:
    """An emulated cell without a daemon, its page, and a browser."""
    config = with_own_page(isolated(cell_config(**sections), folder, _SPEED))
    with (
        emulated_cell(config, _SPEED) as world,
        kiosk_of(config, folder) as kiosk,
        chromium() as browser,
    ):
        yield config, world, browser, kiosk


@contextmanager
def _album_of(pictures: Path, **sections: dict[str, Any]) -> Iterator[tuple[Album, RunningCell]]:
    """An album of a cell that is idle, and that cell."""
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        folder = Path(name)
        with (
            _page_of(folder, **sections) as (config, world, browser, kiosk),
            watched_daemon(config, folder, world) as cell,
        ):
            cell.patience_s = _PATIENCE_S
            wait_idle(cell.client, cell.daemon)
            yield Album(browser, kiosk, pictures), cell


_SECTIONS: dict[str, dict[str, Any]] = {
    "cell": {"name": "Voxel cell"},
    "robot": {"watchdog_hz": 5.0, "host_silence_s": 5.0},
    "feeder": {"capacity_parts": _BELT},
    "kiosk": {"public_url": "http://cell.local:8080", "call_text": _CALL},
    "policy": {"confirmation": "ask", "confirmation_timeout_s": 3600.0},
    # Anna's turn comes when the table is gone.
    "dialogue": {"take_along_s": 3600.0},
}


def until_the_question(pictures: Path) -> None:
    """From a cell that nobody has started to its question; then it falls silent."""
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        folder = Path(name)
        with _page_of(folder, **_SECTIONS) as (config, world, browser, kiosk):
            album = Album(browser, kiosk, pictures)
            with album.page() as screen:
                screen.phase("never")
                album.take(screen, "never")
                with watched_daemon(config, folder, world) as cell:
                    passing(album, screen, cell, "starting")
                    wait_idle(cell.client, cell.daemon)
                    asking(album, screen, cell)
                    stale(album, screen, cell)


def from_the_yes_on(pictures: Path) -> None:
    """A build with everything that interrupts one, and what comes of the object."""
    with _album_of(pictures, **_SECTIONS) as (album, cell):
        with album.page() as screen:
            screen.phase("ready")
            screen.type(_WISH)
            screen.phase("asking")
            building(album, screen, cell)
            handed_over(album, screen)
            behind(album, cell)
            cell.clear_workspace()
            # Anna's turn has come, and she has gone.
            screen.phase("asking")
            cell.client.confirm(False)
            taken_apart(album, screen, cell)
        doubtful(album, cell)


def in_german(pictures: Path) -> None:
    """A cell that speaks another language, on a screen that stands upright."""
    sections = _SECTIONS | {"dialogue": {"language": "de"}, "kiosk": {}}
    with (
        _album_of(pictures, **sections) as (album, _),
        album.page("portrait", scheme="dark") as screen,
    ):
        screen.phase("ready")
        screen.type("ein Tisch mit drei Beinen")
        screen.phase("asking")
        album.take(screen, "portrait")


def with_a_microphone(pictures: Path) -> None:
    """The states of hearing."""
    sections = hearing("push_to_talk", _SPEED) | {"cell": {"name": "Voxel cell"}}
    with virtual_sound(), _album_of(pictures, **sections) as (album, cell):
        wait_for_ears(cell)
        with album.page() as screen:
            screen.phase("ready")
            album.take(screen, "ready-microphone")
            screen.press("Talk")
            screen.phase("hearing")
            album.take(screen, "hearing", drawn_ms=300)


def main() -> None:
    """Entry point: ``FOLDER``, and which of them, if not all."""
    folder, only = Path(sys.argv[1]), sys.argv[2:]
    folder.mkdir(parents=True, exist_ok=True)
    parts = {
        "hearing": with_a_microphone,
        "asking": until_the_question,
        "building": from_the_yes_on,
        "german": in_german,
    }
    for name in only or parts:
        parts[name](folder)


if __name__ == "__main__":
    main()
