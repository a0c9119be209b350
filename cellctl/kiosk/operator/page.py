"""The operator's view: what the cell does at the top, what is wrong below it, then the parts."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from nicegui import ui
from nicegui.element import Element

from cellctl.kiosk.components import Text, attempt, box, shown
from cellctl.kiosk.operator.access import Session
from cellctl.kiosk.operator.desk import Desk
from cellctl.kiosk.operator.facts import Devices, Limits
from cellctl.kiosk.operator.hand import Hand
from cellctl.kiosk.operator.history import History
from cellctl.kiosk.operator.login import LOG_OUT
from cellctl.kiosk.operator.now import Now
from cellctl.kiosk.operator.overview import Overview
from cellctl.kiosk.operator.parts import Parts
from cellctl.kiosk.operator.records import Records
from cellctl.kiosk.operator.troubles import Troubles
from cellctl.kiosk.shell import Page, duration

TABS = ("cell", "parts", "hand", "history", "limits", "devices", "records")


@dataclass
class _Tab:
    """One part of the view."""

    button: Element
    body: Element
    open: Callable[[], Awaitable[None]] | None = None
    """Asks for what no message tells, each time that it is opened."""
    show: Callable[[], None] | None = None
    """Shows what messages told."""


def operator_page(page: Page, session: Session) -> None:
    """Build the view for an operator who has logged in."""
    with box("div", "desk"):
        view = _View(Desk(page, session))
    page.follow(view.show)


class _View:
    """The whole view."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._left = False
        words = desk.words
        self._now = Now(desk)
        self._troubles = Troubles(desk)
        self._tabs: dict[str, _Tab] = {}
        with box("div", "tabs"):
            with box("div", "tabs__list", role="tablist", aria_label=words.say("op.tabs")) as row:
                buttons = {name: self._tab_button(name) for name in TABS}
            # The arrow keys go from tab to tab, as everywhere.
            row.on("keydown", js_handler="(event) => cellctl.tabKeys(event)")
            self._log_out()
        for name in TABS:
            body = box("div", "tab", role="tabpanel", id=f"tab-{name}")
            body.props["aria-labelledby"] = f"to-{name}"
            self._tabs[name] = _Tab(buttons[name], body)
        self._fill()
        desk.go = self._open_now
        self._chosen = ""
        self._choose("cell")

    def _tab_button(self, name: str) -> Element:
        with box("button", "tabs__tab", type="button", role="tab", id=f"to-{name}") as button:
            Text("span", self._desk.words.say(f"tab.{name}"))
        button.props["aria-controls"] = f"tab-{name}"

        async def choose() -> None:
            await self._open(name)

        button.on("click", lambda: attempt(button, choose))
        return button

    def _log_out(self) -> None:
        language = self._desk.words.language
        with box("form", "tabs__end", method="post", action=f"{LOG_OUT}?lang={language}"):
            self._idle = Text("span", "", "small")
            with box("button", "button button--quiet", type="submit"):
                Text("span", self._desk.words.say("login.leave"))

    def _fill(self) -> None:
        tabs, desk = self._tabs, self._desk
        with tabs["cell"].body:
            tabs["cell"].show = Overview(desk).show
        with tabs["parts"].body:
            tabs["parts"].show = Parts(desk).show
        with tabs["hand"].body:
            tabs["hand"].show = Hand(desk).show
        with tabs["history"].body:
            tabs["history"].open = History(desk).open
        with tabs["limits"].body:
            tabs["limits"].open = Limits(desk).open
        with tabs["devices"].body:
            tabs["devices"].open = Devices(desk).open
        with tabs["records"].body:
            tabs["records"].open = Records(desk).open

    def _open_now(self, name: str) -> None:
        """Lead to a part of the view; without a name, to the top."""
        if name:
            self._choose(name)
        target = f"tab-{name}" if name else "content"
        ui.run_javascript(f"cellctl.leadTo('{target}')")

    async def _open(self, name: str) -> None:
        self._choose(name)
        if (ask := self._tabs[name].open) is not None:
            await ask()

    def _choose(self, name: str) -> None:
        self._chosen = name
        for other, tab in self._tabs.items():
            chosen = other == name
            shown(tab.body, chosen)
            tab.button.props["aria-selected"] = "true" if chosen else "false"
            tab.button.props["tabindex"] = "0" if chosen else "-1"
            tab.button.update()
        self._show_tab()

    def show(self) -> None:
        """Show the cell as it is known now."""
        if self._has_ended():
            return
        self._now.show()
        self._troubles.show()
        self._show_tab()

    def _show_tab(self) -> None:
        """What is not looked at is not brought up to date."""
        tab = self._tabs.get(self._chosen)
        if tab is not None and tab.show is not None:
            tab.show()

    def _has_ended(self) -> bool:
        """Whether the session is over: the page goes back to the log-in then, once."""
        left_s = self._desk.session.left_s
        soon = 0.0 < left_s < 120.0
        words = self._desk.words
        told = words.say("login.ends", time=duration(words, left_s)) if soon else ""
        self._idle.show(told)
        if left_s:
            return False
        if not self._left:
            self._left = True
            ui.navigate.to(f"/operator?lang={words.language}")
        return True
