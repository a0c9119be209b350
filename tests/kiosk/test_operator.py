"""The operator's view in a real browser, before a cell that is emulated at the wire."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from cellctl.kiosk.operator.access import COOKIE
from tests.cell.harness import bar
from tests.kiosk.harness import PASSPHRASE, OpenPage, Size, Visit, visit
from tests.kiosk.test_visitor import assert_accessible

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]

TABS = ("cell", "parts", "hand", "history", "limits", "devices", "records")


@pytest.fixture(scope="module")
def running() -> Iterator[Visit]:
    with visit(speed=10.0, graphics=False, policy={"confirmation": "waived"}) as there:
        yield there


@pytest.fixture
def idle(running: Visit) -> Iterator[Visit]:
    running.cell.begin_test()
    yield running
    running.cell.bring_back()


@contextmanager
def logged_in(there: Visit, size: Size = "kiosk") -> Iterator[OpenPage]:
    with there.open("operator", size) as opened:
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
    with idle.open("operator") as opened:
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


def test_history_shows_a_job_again_step_by_step(idle: Visit) -> None:
    idle.cell.client.build("bar.json", bar(1, 1, 2))
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
