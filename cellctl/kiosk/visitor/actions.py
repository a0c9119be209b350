"""What a visitor may do, within thumb's reach; never more than the visitor's door takes."""

from __future__ import annotations

from typing import Final

from cellctl.errors import RefusedError
from cellctl.kiosk.components import Action, Button, Entry, Kind, asked_of, box, shown
from cellctl.kiosk.shell import Page
from cellctl.kiosk.visitor.telling import Telling
from cellctl.messages import (
    MAX_TEXT,
    Command,
    ConfirmCommand,
    ListenCommand,
    Offer,
    PlainCommand,
    SayCommand,
)

_BUTTONS: Final[dict[Offer, tuple[Kind, str]]] = {
    "yes": ("strong", "yes"),
    "no": ("plain", "no"),
    "another": ("plain", "another"),
    "talk": ("strong", "mic"),
    "hand_over": ("plain", "home"),
    "take_apart": ("plain", "apart"),
    "cancel": ("plain", "no"),
    "stop": ("danger", "stop"),
}
"""How each stands out, and its picture; in this order. A change is typed or said."""
_COMMANDS: Final[dict[Offer, Command]] = {
    "another": PlainCommand(command="another"),
    "talk": ListenCommand(),
    "hand_over": PlainCommand(command="hand_over"),
    "take_apart": PlainCommand(command="take_apart"),
    "cancel": PlainCommand(command="cancel"),
    "stop": PlainCommand(command="stop"),
}
"""What each sends, beside yes and no."""
_AT_WORK: Final = frozenset({"building", "taking_apart"})
_TYPED_IN: Final = _AT_WORK | {"ready", "done", "asking", "hearing"}
"""Phases in which words are listened to, and typed ones as well."""


class Actions:
    """Buttons for what is offered, and a line to type into wherever speech works."""

    def __init__(self, page: Page) -> None:
        self._page = page
        words = page.words
        self._buttons: dict[Offer, Button] = {}
        with box("div", "actions") as self._whole:
            with box("div", "actions__buttons") as self._row:
                for offer, (kind, picture) in _BUTTONS.items():
                    self._buttons[offer] = Button(
                        words.say(f"offer.{offer}"),
                        self._doing(offer),
                        kind=kind,
                        picture=picture,
                        classes=f"offer offer--{offer}",
                    )
            self._entry = Entry(
                words.say("visit.type"),
                words.say("visit.send"),
                self.say,
                MAX_TEXT,
                urgent=self._stops,
            )

    def _doing(self, offer: Offer) -> Action:
        async def act() -> None:
            answers = offer in {"yes", "no"}
            body = self._answer(offer) if answers else _COMMANDS[offer]
            await self._page.site.link.ask(body, visitor=self._page.visitor)

        return act

    def _answer(self, offer: Offer) -> Command:
        """An answer to the question that was shown, and to no later one."""
        return ConfirmCommand(answer=offer == "yes", asked=self._buttons[offer].asked)

    async def say(self, text: str, asked: str = "") -> None:
        """Say something to the cell.

        Args:
            text: what.
            asked: name of the question that it may be an answer to; empty for none.

        Raises:
            CellctlError: it does not hear, or says no.
        """
        if self._stops(text):
            # Always tried, and by the way that waits for nothing.
            stop = PlainCommand(command="stop")
            await self._page.site.link.ask(stop, visitor=self._page.visitor)
            return
        if self._page.site.mirror.stale:
            raise RefusedError(self._page.words.say("visit.unheard"))
        body = SayCommand(text=text, asked=asked)
        await self._page.site.link.ask(body, visitor=self._page.visitor)

    def _stops(self, text: str) -> bool:
        """Whether that is a stop, in so many words."""
        return text.lower().strip(" .!") in self._page.words.say("visit.stops").split(", ")

    def show(self, now: Telling) -> None:
        """Offer what makes sense now."""
        page = self._page
        asked_of(self._whole, now.asked)
        shown(self._whole, now.phase != "never")
        stale = page.site.mirror.stale
        # A visitor's own device cannot be talked to: the microphone is the cell's.
        silent = bool(page.visitor) or now.phase == "hearing"
        offers = set(now.offers) - ({"talk"} if silent else set())
        for offer, button in self._buttons.items():
            shown(button, offer in offers)
            # Stop is always tried: it fails safe.
            button.enable(not stale or offer == "stop")
        designing = now.phase == "thinking"
        self._buttons["cancel"].label.say(
            page.words.say("offer.cancel_thinking" if designing else "offer.cancel")
        )
        shown(self._row, bool(offers & self._buttons.keys()))
        shown(self._entry, now.phase in _TYPED_IN)
        self._entry.invite(page.words.say(_invitation(now)))


def _invitation(now: Telling) -> str:
    """The key of what may be typed."""
    if "change" in now.offers:
        return "visit.type_change"
    if now.phase == "asking":
        return "visit.type_answer"
    return "visit.type_turn" if now.phase in _AT_WORK else "visit.type"
