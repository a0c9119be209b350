"""How quick the page is: ``python -m benchmarks.kiosk [--browsers N] [--speed N]``.

Builds the same object twice in an emulated cell, first with nobody looking, then with N pages open
in a headless Chromium, and prints a table: from an event of the daemon to its words on each page,
how long the control loop was blocked, and what the page's process costs. The browsers, which would
be on computers of their own, give way to the cell and draw no 3D here: without a graphics card
their drawing would be measured, and nothing of cellctl.
"""

from __future__ import annotations

import argparse
import re
import statistics
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
from playwright.sync_api import Browser, Page

from cellctl.cli.daemon_process import running_daemon, wait_idle
from cellctl.cli.kiosk_process import KioskProcess, running_kiosk, with_own_page
from cellctl.client import CellClient
from cellctl.config import CellConfig, load_config
from cellctl.messages import JobData, RefillCommand, StateData
from cellctl.sim.client import SimClient
from cellctl.sim.isolation import isolated
from cellctl.sim.spawn import emulated_cell
from tests.kiosk.harness import chromium

CONFIG = Path(__file__).parents[1] / "config" / "sim.toml"
WISH = "the letter T"
_ALIKE = ("--disable-gpu", "--disable-3d-apis", "--renderer-process-limit=1")
_PATIENCE_S = 600.0
_SILENCE_S = 15.0
_WINDOW_S = 60.0
"""The daemon tells how its control loop did in the last minute; starting and opening pages do not
count."""
_COUNTED = re.compile(r"\(\d+ of \d+\)")
"""Of sentences that come once in a build."""
_WATCH = """() => {
    window.seen = [];
    const words = document.querySelector(".visit__sentence");
    new MutationObserver(() => window.seen.push([words.textContent, Date.now()]))
        .observe(words, { childList: true, characterData: true, subtree: true });
}"""


@contextmanager
def cell(speed: float) -> Iterator[tuple[CellConfig, CellClient, SimClient, Path]]:
    """A running cell that builds without asking."""
    base = load_config(CONFIG)
    policy = base.policy.model_copy(update={"confirmation": "waived"})
    # Many browsers on the cell's own computer: see the option.
    robot = base.robot.model_copy(update={"real_time_priority": 5})
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        folder = Path(name)
        own = base.model_copy(update={"policy": policy, "robot": robot})
        own = isolated(own, folder, speed)
        own = with_own_page(own)
        with (
            emulated_cell(own, speed) as world,
            running_daemon(own, folder) as daemon,
            CellClient.for_role(own) as client,
        ):
            wait_idle(client, daemon)
            client.subscribe()
            yield own, client, world, folder


def build(client: CellClient, pages: list[Page]) -> tuple[dict[str, float], float, float]:
    """Build the object once.

    Args:
        client: subscribed.
        pages: waited for in the end, until they show that it is finished.

    Returns:
        When each sentence was published (epoch seconds), and how long the control loop was blocked
        meanwhile: 99th percentile and worst, in seconds.
    """
    told: dict[str, float] = {}
    reply = client.say(WISH)
    deadline_s = time.monotonic() + _PATIENCE_S
    for message in client.messages(_SILENCE_S):
        data = message.payload()
        if isinstance(data, StateData) and data.state.startswith("fault"):
            raise SystemExit(f"Not built: {data.sentence}")
        if isinstance(data, StateData) and _COUNTED.search(data.sentence):
            told.setdefault(data.sentence, message.time.timestamp())
        if isinstance(data, JobData) and data.job_id == reply.job_id and data.outcome:
            if data.outcome != "built":
                raise SystemExit(f"Not built: {data.message}")
            break
        if time.monotonic() > deadline_s:
            raise SystemExit("It takes too long.")
    for page in pages:
        page.wait_for_selector('.visit[data-phase="done"]')
    health = client.snapshot().health
    return told, health.loop_blocked_p99_s, health.loop_blocked_max_s


def clear(client: CellClient, world: SimClient) -> None:
    """Take out what stands."""
    world.clear_workspace()
    client.command("clear")
    world.refill()
    if client.snapshot().inventory["stock"]:
        client.request(RefillCommand())


def latencies_s(pages: list[Page], told: dict[str, float]) -> list[float]:
    """From the publishing of each sentence to each page that showed it."""
    found = []
    for page in pages:
        seen: dict[str, float] = {}
        for text, moment_ms in page.evaluate("window.seen"):
            seen.setdefault(text, moment_ms / 1000.0)
        found += [seen[text] - moment for text, moment in told.items() if text in seen]
    return sorted(found)


def open_pages(browser: Browser, kiosk: KioskProcess, count: int) -> list[Page]:
    """Pages that write down when their sentence changes."""
    pages = []
    for _ in range(count):
        page = browser.new_context(reduced_motion="reduce").new_page()
        page.goto(kiosk.url)
        page.wait_for_selector('.visit[data-phase="ready"]')
        page.evaluate(_WATCH)
        pages.append(page)
    return pages


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--browsers", type=int, default=20)
    parser.add_argument("--speed", type=float, default=1.0, help="cell seconds per second")
    wanted = parser.parse_args()
    with cell(wanted.speed) as (config, client, world, folder):
        time.sleep(_WINDOW_S)
        _, alone_p99_s, alone_worst_s = build(client, [])
        clear(client, world)
        with (
            running_kiosk(config, folder) as kiosk,
            chromium(*_ALIKE, niceness=19) as browser,
        ):
            pages = open_pages(browser, kiosk, wanted.browsers)
            time.sleep(_WINDOW_S)
            process = psutil.Process(kiosk.process.pid)
            began_s, cpu_s = time.monotonic(), sum(process.cpu_times()[:2])
            told, p99_s, worst_s = build(client, pages)
            busy = (sum(process.cpu_times()[:2]) - cpu_s) / (time.monotonic() - began_s)
            memory_mb = process.memory_full_info().pss / 1e6
            found = latencies_s(pages, told)
    rows = [
        (
            f"event to page, {wanted.browsers} browsers, {len(found)} changes",
            f"median {statistics.median(found) * 1e3:.0f} ms, 99th percentile "
            f"{found[int(0.99 * len(found))] * 1e3:.0f} ms, worst {found[-1] * 1e3:.0f} ms",
        ),
        ("control loop blocked, nobody looks", _blocked(alone_p99_s, alone_worst_s)),
        (f"control loop blocked, {wanted.browsers} browsers", _blocked(p99_s, worst_s)),
        ("the page's process", f"{busy * 100:.0f} % of a core, {memory_mb:.0f} MB"),
    ]
    for name, value in rows:
        print(f"{name:<48} {value}")  # noqa: T201 - this is what it is for


def _blocked(p99_s: float, worst_s: float) -> str:
    return f"99th percentile {p99_s * 1e3:.1f} ms, worst {worst_s * 1e3:.0f} ms"


if __name__ == "__main__":
    main()
