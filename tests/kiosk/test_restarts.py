"""The page outlives the daemon, and comes back after its own end; what it shows is never a lie."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest

from cellctl.cli.daemon_process import wait_idle
from cellctl.cli.kiosk_process import KioskProcess, with_own_page
from cellctl.config import CellConfig
from cellctl.sim.client import SimClient
from cellctl.sim.isolation import isolated
from cellctl.sim.spawn import emulated_cell
from tests.cell.harness import cell_config, watched_daemon
from tests.kiosk.harness import OpenPage, chromium, kiosk_of, opened

pytestmark = [pytest.mark.wire, pytest.mark.timeout(240)]

_POPUP = '.nicegui-error-popup[aria-hidden="{hidden}"]'


def test_a_page_lives_through_the_daemons_end_and_its_servers() -> None:
    policy = {"confirmation": "ask", "confirmation_timeout_s": 900.0}
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        folder = Path(name)
        config = with_own_page(isolated(cell_config(policy=policy), folder, 10.0))
        with (
            emulated_cell(config, 10.0) as world,
            chromium() as browser,
            kiosk_of(config, folder) as kiosk,
            opened(browser, kiosk.url) as it,
        ):
            # Nobody has started the cell yet.
            it.phase("never")
            _ask_and_die(config, folder, world, it)
            # What was known is shown as old, and nothing can be answered to it.
            it.page.wait_for_selector('.page[data-stale="true"]')
            it.says("The cell has been silent for")
            assert it.page.get_by_role("button", name="Yes", exact=True).is_disabled()
            _come_back(config, folder, world, it, kiosk)
            assert it.elsewhere == []


def _ask_and_die(config: CellConfig, folder: Path, world: SimClient, it: OpenPage) -> None:
    """One life of the daemon: it ends while it asks."""
    with watched_daemon(config, folder, world) as cell:
        it.phase("ready")
        wait_idle(cell.client, cell.daemon)
        it.type("the letter T")
        it.phase("asking")


def _come_back(
    config: CellConfig, folder: Path, world: SimClient, it: OpenPage, kiosk: KioskProcess
) -> None:
    """The next life, in which the page's own server ends as well."""
    with watched_daemon(config, folder, world) as cell:
        it.page.wait_for_selector('.page[data-stale="false"]')
        # It remembers the job, and stays paused until an operator goes on.
        it.phase("waiting")
        kiosk.end()
        it.page.wait_for_selector(_POPUP.format(hidden="false"), state="attached")
        with kiosk_of(config, folder):
            # The page has loaded itself anew.
            it.page.wait_for_selector(_POPUP.format(hidden="true"), state="attached")
            it.phase("waiting")
            cell.client.command("cancel")
            cell.wait_state("paused_resting")
            cell.client.command("resume")
            it.phase("ready")
