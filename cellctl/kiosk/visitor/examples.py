"""What may be said to a cell that waits for a wish."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Final

from cellctl.kiosk.components import Button, Text, box, shown
from cellctl.kiosk.shell import Page
from cellctl.kiosk.visitor.telling import Telling
from cellctl.kiosk.words import Words

EXAMPLES: Final = ("stool", "table", "letter", "stairs", "question")
"""Keys of sentences; the last is a question."""


class Examples:
    """Sentences that the cell understands, in its own language; each can be pressed.

    Args:
        page: where.
        send: says one to the cell; None where visitors only look.
    """

    def __init__(self, page: Page, send: Callable[[str], Awaitable[None]] | None) -> None:
        self._page = page
        # Not the page's language: the cell would not understand that.
        spoken = Words(page.site.config.dialogue.language)
        with box("div", "examples") as self._whole:
            self._title = Text("h2", "", "changes__name")
            with box("ul", "examples__list", lang=spoken.language):
                for key in EXAMPLES:
                    sentence = spoken.say(f"examples.{key}")
                    with box("li"):
                        if send is None:
                            Text("span", f"“{sentence}”", "example")
                        else:
                            _example(sentence, send)

    def show(self, now: Telling) -> None:
        """Show them while the cell waits for a wish, and hears of it."""
        mirror, words = self._page.site.mirror, self._page.words
        shown(self._whole, now.phase in {"ready", "hearing"} and not mirror.stale)
        hears = "talk" in now.offers and not self._page.visitor
        self._title.say(words.say("examples.say" if hears else "examples.press"))


def _example(sentence: str, send: Callable[[str], Awaitable[None]]) -> Button:
    async def say() -> None:
        await send(sentence)

    return Button(f"“{sentence}”", say, classes="example")
