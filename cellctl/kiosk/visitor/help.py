"""Whom to call when the cell waits for people; a visitor can do no more than that."""

from __future__ import annotations

from cellctl.kiosk.components import Text, box, icon, shown
from cellctl.kiosk.shell import Page
from cellctl.kiosk.visitor.telling import Telling


class Help:
    """What the configuration says about whom to call, and the way to the operator's view."""

    def __init__(self, page: Page) -> None:
        words, call = page.words, page.site.config.kiosk.call_text
        with box("div", "help") as self._whole:
            icon("people")
            Text("p", call or words.say("visit.call"), "help__text")
            way = Text("a", words.say("visit.operator"), "help__way small")
            way.props["href"] = f"/operator?lang={words.language}"

    def show(self, now: Telling) -> None:
        """Show it while people are needed."""
        shown(self._whole, bool(now.need))
