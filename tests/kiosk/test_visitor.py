"""The visitor's view in a real browser, before a cell that is emulated at the wire."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from axe_playwright_python.sync_playwright import Axe

from tests.kiosk.harness import OpenPage, Visit, visit

pytestmark = [pytest.mark.wire, pytest.mark.shared_cell]


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
    """Nothing that an automated check calls serious or critical."""
    found = Axe().run(opened.page).response["violations"]
    grave = [item for item in found if item["impact"] in {"serious", "critical"}]
    assert not grave, [(item["id"], [node["html"] for node in item["nodes"]]) for item in grave]


def test_a_visitor_types_a_wish_sees_what_was_understood_and_says_no(idle: Visit) -> None:
    with idle.open() as opened:
        opened.phase("ready")
        assert_accessible(opened)
        opened.type("a stool thirty centimetres high")
        opened.phase("asking")
        opened.says("a stool thirty centimetres high")
        assert_accessible(opened)
        opened.press("No")
        opened.phase("ready")
        assert idle.cell.finish().outcome == "declined"
        assert opened.problems == []
        assert opened.elsewhere == []


def test_a_visitor_says_yes_and_sees_it_grow(idle: Visit) -> None:
    with idle.open(size="phone") as opened:
        opened.phase("ready")
        opened.type("the letter T")
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
        with idle.open(path, "phone", scheme="dark") as opened:
            opened.page.wait_for_selector("h1")
            assert_accessible(opened)
            wide = opened.page.evaluate("document.documentElement.scrollWidth")
            assert wide <= 390, f"{path} is {wide} pixels wide"
