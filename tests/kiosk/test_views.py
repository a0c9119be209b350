"""Both views in a real browser, before a cell that is emulated at the wire.

All of it shares one cell, one page's server and one browser, which take most of the time.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import httpx2
import pytest
from axe_playwright_python.sync_playwright import Axe

from cellctl.cli.daemon_process import wait_idle
from cellctl.kiosk.operator.access import COOKIE
from tests.cell.harness import bar, watched_daemon
from tests.kiosk.harness import PASSPHRASE, OpenPage, Size, Visit, kiosk_of, visit

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]

TABS = ("cell", "parts", "hand", "history", "limits", "devices", "records")
_POPUP = '.nicegui-error-popup[aria-hidden="{hidden}"]'


@pytest.fixture(scope="module")
def running() -> Iterator[Visit]:
    # Nobody shall have to hurry because the machine is busy.
    policy = {"confirmation": "ask", "confirmation_timeout_s": 900.0}
    with visit(speed=10.0, policy=policy) as there:
        yield there


@pytest.fixture
def idle(running: Visit) -> Iterator[Visit]:
    running.cell.begin_test()
    yield running
    running.cell.bring_back()


def assert_accessible(opened: OpenPage) -> None:
    """Nothing that an automated check calls more than minor."""
    found = Axe().run(opened.page).response["violations"]
    grave = [item for item in found if item["impact"] != "minor"]
    assert not grave, [(item["id"], [node["html"] for node in item["nodes"]]) for item in grave]


def test_a_visitor_types_a_wish_sees_what_was_understood_and_says_no(idle: Visit) -> None:
    with idle.open(reduced_motion="reduce") as opened:
        opened.phase("ready")
        assert_accessible(opened)
        opened.type("a stool thirty centimetres high")
        opened.phase("asking")
        opened.says("a stool thirty centimetres high")
        assert_accessible(opened)
        # As a browser has it that has not been told of a change yet.
        opened.page.evaluate("document.querySelector('.actions').dataset.asked = 'the one before'")
        opened.press("Yes")
        opened.says("That answer came before my question")
        assert idle.cell.client.snapshot().state.state == "validating_confirming"
        opened.press("No")
        opened.phase("ready")
        assert idle.cell.finish().outcome == "declined"
        assert opened.problems == []
        assert opened.elsewhere == []


def test_a_visitor_says_yes_and_sees_it_grow(idle: Visit) -> None:
    with idle.open(size="phone", reduced_motion="reduce") as opened:
        opened.phase("ready")
        opened.type("the letter I")
        opened.phase("asking")
        opened.page.wait_for_selector('.stage[data-mode="table"] canvas')
        opened.press("Yes")
        opened.phase("building")
        opened.page.wait_for_selector('.stage[data-mode="cell"]')
        opened.says(" of ")
        opened.phase("done")
        assert_accessible(opened)
        assert idle.cell.finish().outcome == "built"
        idle.cell.assert_as_planned()
        assert opened.problems == []


def test_both_views_are_accessible_on_a_phone_in_the_dark(idle: Visit) -> None:
    for path in ("?lang=de", "operator"):
        with idle.open(path, "phone", scheme="dark", graphics=False) as opened:
            opened.page.wait_for_selector("h1")
            assert_accessible(opened)
            wide = opened.page.evaluate("document.documentElement.scrollWidth")
            assert wide <= 390, f"{path} is {wide} pixels wide"


@contextmanager
def logged_in(there: Visit, size: Size = "kiosk") -> Iterator[OpenPage]:
    with there.open("operator", size, graphics=False) as opened:
        enter(opened, PASSPHRASE)
        opened.page.wait_for_selector(".now")
        yield opened
        assert [text for text in opened.problems if "WebGL" not in text] == []
        assert opened.elsewhere == []


def enter(opened: OpenPage, passphrase: str) -> None:
    opened.page.fill("#passphrase", passphrase)
    opened.page.press("#passphrase", "Enter")


def sure(opened: OpenPage, sentence: str) -> None:
    """Say yes to what comes up, which says what will happen."""
    opened.says(sentence)
    opened.page.click(".sure__yes")


def test_only_the_passphrase_opens_the_view_and_log_out_closes_it(idle: Visit) -> None:
    with idle.open("operator", graphics=False) as opened:
        assert_accessible(opened)
        enter(opened, "the wrong passphrase")
        opened.says("That is not the passphrase")
        assert not opened.page.query_selector(".now")
        enter(opened, PASSPHRASE)
        opened.page.wait_for_selector(".now")
        (cookie,) = [one for one in opened.page.context.cookies() if one["name"] == COOKIE]
        assert cookie["httpOnly"]
        assert cookie["sameSite"] == "Strict"
        opened.press("Log out")
        opened.page.wait_for_selector("#passphrase")
        # Who kept the cookie is not let in again.
        kept = {"name": COOKIE, "value": cookie["value"], "url": idle.kiosk.url}
        opened.page.context.add_cookies([kept])  # type: ignore[list-item]
        opened.page.reload()
        opened.page.wait_for_selector("#passphrase")


def test_every_part_of_the_view_is_accessible_and_fits_a_phone(idle: Visit) -> None:
    with logged_in(idle, "phone") as opened:
        for name in TABS:
            opened.page.click(f"#to-{name}")
            opened.page.wait_for_selector(f"#tab-{name} .panel")
            assert_accessible(opened)
            wide = opened.page.evaluate("document.documentElement.scrollWidth")
            assert wide <= 390, f"{name} is {wide} pixels wide"
        opened.page.focus("#to-cell")
        opened.page.keyboard.press("ArrowRight")
        opened.page.wait_for_selector("#to-parts[aria-selected=true]")


def test_a_fault_is_shown_with_its_remedy_and_cleared_by_the_buttons(idle: Visit) -> None:
    with logged_in(idle) as opened:
        idle.cell.world.inject("emergency_stop")
        opened.says("An emergency stop was pressed")
        opened.says("Make the cell safe, release the button")
        fault = opened.page.locator(".trouble--fault")
        assert fault.get_by_role("button", name="Resume").is_disabled()
        idle.cell.world.clear("emergency_stop")
        fault.get_by_role("button", name="Reset").click()
        idle.cell.wait_state("paused_resting")
        opened.page.locator(".now").get_by_role("button", name="Resume").click()
        sure(opened, "The cell takes wishes again")
        idle.cell.wait_state("idle")
        assert not fault.is_visible()


def test_the_inventory_is_corrected(idle: Visit) -> None:
    before = idle.cell.client.snapshot().inventory
    with logged_in(idle) as opened:
        opened.page.click("#to-parts")
        counting = opened.page.locator(".form", has_text="Correct the count")
        counting.get_by_label("On the belt").fill(str(before["belt"] - 2))
        opened.press("Correct the count")
        idle.cell.wait("two unknown", lambda now: now.inventory["unknown"] == 2)
        opened.page.wait_for_selector(".count--unknown >> text=2")
        # What cannot be is refused, with the cell's own words.
        opened.page.locator(".form", has_text="Belt is refilled").get_by_role("spinbutton").fill(
            "999"
        )
        opened.press("Belt is refilled")
        opened.says("The stock has")


def test_the_arm_moves_by_hand_only_while_the_cell_is_paused(idle: Visit) -> None:
    with logged_in(idle) as opened:
        opened.page.click("#to-hand")
        opened.says("only while the cell is paused")
        assert opened.page.get_by_role("button", name="Home", exact=True).is_disabled()
        opened.press("Pause")
        idle.cell.wait_state("paused_resting")
        opened.page.locator("#tab-hand").get_by_role("textbox").fill("99,0,0")
        opened.press("Go above it")
        sure(opened, "The arm goes above cell [99, 0, 0]")
        opened.page.wait_for_selector(".notices__line")  # the cell's own refusal
        before = idle.cell.client.snapshot().arm.tcp_pose
        opened.press("Up")
        raised = idle.cell.wait(
            "the arm is higher", lambda now: now.arm.tcp_pose[2] > before[2] + 0.004
        )
        assert raised.state.state in {"paused_moving", "paused_resting"}


def test_a_part_that_nobody_knows_of_is_found_by_the_recover_panel(idle: Visit) -> None:
    cell = idle.cell
    with logged_in(idle) as opened:
        cell.world.inject("speed_slider", fraction=0.1)
        cell.client.build("bar.json", bar(1, 1, 2))
        cell.wait_state("validating_confirming")
        cell.client.confirm(True)
        cell.wait(
            "an arm that moves to the station",
            lambda now: now.state.state == "assembling_picking" and now.arm.moving,
        )
        # The latch stalls as it closes: it may have the part, or not.
        cell.world.inject("gripper_fault")
        cell.world.inject("speed_slider", fraction=1.0)
        fault, doubt = (opened.page.locator(f".trouble--{kind}") for kind in ("fault", "doubt"))
        opened.says("should be in the gripper, and the latch does not confirm")
        station = doubt.get_by_role("button", name="At the pick station")
        assert station.is_disabled()
        cell.world.clear("gripper_fault")
        fault.get_by_role("button", name="Reset").click()
        cell.wait_state("paused_resting")
        station.click()
        sure(opened, "The part counts as lying at the pick station")
        cell.wait("no doubt", lambda now: not now.doubt)
        doubt.wait_for(state="hidden")
        opened.page.locator(".now").get_by_role("button", name="Resume").click()
        sure(opened, "The arm and the belt go on with the job")
        assert cell.finish().outcome == "built"
    cell.assert_inventory_true()


def test_history_shows_a_job_again_step_by_step(idle: Visit) -> None:
    idle.cell.client.build("bar.json", bar(1, 1, 2))
    idle.cell.wait_state("validating_confirming")
    idle.cell.client.confirm(True)
    assert idle.cell.finish().outcome == "built"
    with logged_in(idle) as opened:
        opened.page.click("#to-history")
        opened.page.locator(".job").first.click()
        opened.says("After step 2 of 2. Parts that stand: 2.")
        opened.press("Back")
        opened.says("After step 1 of 2. Parts that stand: 1.")
        opened.press("Back")
        opened.says("After step 0 of 2. Parts that stand: 0.")
        opened.press("Play")
        opened.says("After step 2 of 2. Parts that stand: 2.")
        opened.page.locator(".acts summary").click()
        assert opened.page.locator(".acts__list li", has_text="release").count() == 2


def test_foreign_names_and_sites_are_refused_by_the_server_itself(idle: Visit) -> None:
    url = idle.kiosk.url
    assert httpx2.get(url, headers={"Host": "evil.example"}).status_code == 421
    assert httpx2.get(url, headers={"Origin": "http://evil.example"}).status_code == 403
    assert httpx2.get(f"{url}no/such/page").status_code == 404
    assert httpx2.post(f"{url}operator/log-in", content=b"x" * 20_000).status_code == 413
    connected = idle.browser.new_page()
    connected.goto("data:text/html,another site")
    socket = url.replace("http", "ws") + "_nicegui_ws/socket.io/?EIO=4&transport=websocket"
    ended = connected.evaluate(
        "(url) => new Promise((tell) => { const socket = new WebSocket(url);"
        " socket.onopen = () => tell('open'); socket.onclose = () => tell('closed'); })",
        socket,
    )
    connected.close()
    assert ended == "closed"


def test_a_page_lives_through_the_daemons_end_and_its_servers(running: Visit) -> None:
    """The last one, for it ends what the others use."""
    cell, config = running.cell, running.cell.config
    with running.open(graphics=False) as it, tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        folder = Path(name)
        it.phase("ready")
        it.type("the letter I")
        it.phase("asking")
        running.life.close()
        # What was known is shown as old, and nothing can be answered to it.
        it.page.wait_for_selector('.page[data-stale="true"]')
        it.says("The cell has been silent for")
        assert it.page.get_by_role("button", name="Yes", exact=True).is_disabled()
        # Words are not lost: they stay until they can be heard.
        it.type("make it taller")
        it.says("Your words stay in the line")
        running.kiosk.end()
        it.page.wait_for_selector(_POPUP.format(hidden="false"), state="attached")
        it.says("This page has lost its connection")
        with kiosk_of(config, folder):
            # The page has loaded itself anew, and nobody has started the cell yet.
            it.page.wait_for_selector(_POPUP.format(hidden="true"), state="attached")
            it.phase("never")
            with watched_daemon(config, folder, cell.world) as again:
                # It remembers the job, and stays paused until an operator goes on.
                it.phase("waiting")
                it.says("Stopped")
                again.client.command("cancel")
                again.wait_state("paused_resting")
                again.client.command("resume")
                it.phase("ready")
                wait_idle(again.client, again.daemon)
                assert it.page.locator(".entry__line").input_value() == "make it taller"
        assert it.elsewhere == []
