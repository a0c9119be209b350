"""Pictures of the page in every state, for the docs: ``python -m tests.kiosk.pictures FOLDER``.

An emulated cell is brought into each state by the doors that people use, and a headless Chromium
takes its picture.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cellctl.messages import HistoryCommand, HistoryData
from tests.kiosk.harness import OpenPage, Size, Visit, visit

_SPEED = 4.0
_WISH = "a table with three legs"
_SCALE = 2 / 3
"""Pixels of a picture for each of the screen's: large enough to read, and small as a file."""
_DRAWN_MS = 2500
"""So long a page has to draw its 3D view, on a computer without a graphics card."""


class Album:
    """Takes pictures of one visit's page.

    Args:
        there: the visit.
        folder: where they go.
    """

    def __init__(self, there: Visit, folder: Path) -> None:
        self._there = there
        self._folder = folder

    @contextmanager
    def page(self, size: Size = "kiosk", path: str = "", **options: Any) -> Iterator[OpenPage]:
        """A page to take pictures of."""
        # Less motion: the same state gives the same picture.
        options = {"device_scale_factor": _SCALE, "reduced_motion": "reduce", **options}
        with self._there.open(path, size, **options) as opened:
            yield opened

    def take(self, opened: OpenPage, name: str) -> None:
        """Take a picture."""
        opened.page.wait_for_timeout(_DRAWN_MS)
        file = self._folder / f"{name}.png"
        opened.page.screenshot(path=file)
        print(f"{file}: {file.stat().st_size / 1000:.0f} kB")  # noqa: T201 - a command's output


def take_all(there: Visit, folder: Path) -> None:
    """Bring the cell into each state, and take its picture."""
    album, cell = Album(there, folder), there.cell
    with album.page() as screen:
        screen.phase("ready")
        album.take(screen, "ready")
        screen.type(_WISH)
        screen.phase("asking")
        album.take(screen, "asking")
        with album.page("portrait", "?lang=de", scheme="dark") as portrait:
            portrait.phase("asking")
            album.take(portrait, "portrait")
        with album.page("phone", scheme="dark") as phone:
            phone.phase("asking")
            album.take(phone, "phone")
        screen.press("Yes")
        screen.phase("building")
        _wait_parts(there, 8)
        cell.wait("a part in the gripper", lambda now: now.gripper.holding == "part")
        album.take(screen, "building")
        screen.press("Stop")
        screen.phase("waiting")
        album.take(screen, "stopped")
        cell.client.command("resume")
        cell.world.inject("belt_jam")
        screen.phase("fault")
        album.take(screen, "fault")
        cell.world.clear("belt_jam")
        cell.client.command("reset")
        cell.wait_state("paused_resting")
        cell.client.command("resume")
        screen.phase("done")
        album.take(screen, "done")
        cell.client.command("take_apart")
        screen.phase("asking")
        album.take(screen, "taking-apart")
        screen.press("No")
    with album.page("phone", f"take/{_job(there)}") as home:
        home.page.wait_for_selector("h1")
        album.take(home, "take-home")
    with album.page() as screen:
        screen.phase("ready", "done")
        there.cell.daemon.process.send_signal(signal.SIGSTOP)
        screen.page.wait_for_selector('.page[data-stale="true"]')
        album.take(screen, "stale")
        there.cell.daemon.process.send_signal(signal.SIGCONT)


def _wait_parts(there: Visit, count: int) -> None:
    there.cell.wait(f"{count} parts", lambda now: len(now.standing) >= count)


def _job(there: Visit) -> str:
    """The last job that built something: the one before the taking apart that was declined."""
    reply = there.cell.client.request(HistoryCommand())
    assert isinstance(reply.data, HistoryData)
    return next(job.job_id for job in reply.data.jobs if job.outcome == "built")


def main() -> None:
    """Entry point."""
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    kiosk = {"public_url": "http://cell.local:8080"}
    policy = {"confirmation": "ask", "confirmation_timeout_s": 1200.0}
    with visit(_SPEED, policy=policy, kiosk=kiosk) as there:
        take_all(there, folder)


if __name__ == "__main__":
    main()
