"""The wishes that wait for their turn, and how one of them is dropped."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from cellctl.kiosk.components import Button, Text, box, shown
from cellctl.kiosk.operator.desk import Desk
from cellctl.messages import DropWishCommand, QueueEntry, Snapshot


class Wishes:
    """The line, the next wish first; hidden while nobody waits."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._shown: tuple[QueueEntry, ...] = ()
        title = desk.words.say("wishes.title")
        with box("section", "panel", aria_labelledby="wishes") as self._whole:
            Text("h2", title, "panel__title").props["id"] = "wishes"
            self._list = box("ol", "lines", tabindex="0")

    def show(self, snapshot: Snapshot | None) -> None:
        """Show who waits now."""
        wanted = snapshot.dialogue.queue if snapshot is not None else ()
        shown(self._whole, bool(wanted))
        if wanted == self._shown:
            return
        self._shown = wanted
        self._list.clear()
        words = self._desk.words
        with self._list:
            for entry in wanted:
                with box("li", "row"):
                    name = entry.name or words.say("wishes.nobody")
                    Text("span", f"{entry.wish} · {name}")
                    Button(words.say("wishes.drop"), self._dropping(entry), kind="quiet")

    def _dropping(self, entry: QueueEntry) -> Callable[[], Awaitable[None]]:
        told = self._desk.words.say("sure.drop_wish", wish=entry.wish)
        act = self._desk.ordering(DropWishCommand(ticket=entry.ticket))
        return self._desk.asking_first("drop_wish", act, lambda: told)
