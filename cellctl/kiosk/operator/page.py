"""The operator's view."""

from __future__ import annotations

from cellctl.kiosk.components import Text, box
from cellctl.kiosk.shell import Page


def operator_page(page: Page) -> None:
    """Build the view: what the cell does, in words, and which version of cellctl it runs."""
    words, mirror = page.words, page.site.mirror
    with box("section", "card"):
        Text("h1", words.say("operator.title"), "title")
        with box("dl", "facts"):
            Text("dt", words.say("operator.state"))
            state = Text("dd")
            Text("dt", words.say("operator.version"))
            version = Text("dd")

    def show() -> None:
        snapshot = mirror.snapshot
        state.say(snapshot.state.state.replace("_", ": ") if snapshot is not None else "-")
        version.say(snapshot.version if snapshot is not None else "-")

    page.follow(show)
