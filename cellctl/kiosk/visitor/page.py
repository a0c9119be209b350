"""The visitor's view: what the cell understood, what it asks, and how the object grows."""

from __future__ import annotations

from typing import Final

from cellctl.kiosk.components import Text, attribute, box, icon, shown
from cellctl.kiosk.shell import Page, duration
from cellctl.kiosk.visitor.actions import Actions
from cellctl.kiosk.visitor.examples import Examples
from cellctl.kiosk.visitor.help import Help
from cellctl.kiosk.visitor.panels import Changes, Countdown, Progress, Queue, Said, TakeHome
from cellctl.kiosk.visitor.stage import Stage
from cellctl.kiosk.visitor.telling import Telling, beside, telling


def visitor_page(page: Page) -> None:
    """Build the view."""
    page.follow(_Visit(page).show)


_OWN: Final = {"never": "page.never_sentence", "starting": "visit.starting"}


class _Visit:
    """The elements of one open page, and what they show."""

    def __init__(self, page: Page) -> None:
        self._page = page
        with box("section", "visit") as self._whole:
            self._stage = Stage(page)
            with box("div", "visit__words") as self._words:
                self._ears = _Ears(page)
                with box("div", "visit__now", aria_live="polite"):
                    self._state = Text("h1", "", "visit__state")
                    self._sentence = Text("p", "", "visit__sentence")
                self._countdown = Countdown(page)
                self._stale = Text("p", "", "visit__stale")
                self._stale.props["role"] = "status"
                self._help = Help(page)
                self._progress = Progress(page)
                self._said = Said(page)
                self._changes = Changes(page)
                self._home = TakeHome(page)
                self._queue = Queue(page)
            # Not hidden but left out: what is not there cannot be pressed from elsewhere either.
            may = page.site.config.kiosk.visitors_may_act
            self._actions = Actions(page) if may else None
            with self._words:
                send = self._actions.say if self._actions is not None else None
                self._examples = Examples(page, send)
        self._panels = (
            *(self._countdown, self._help, self._said, self._progress, self._examples),
            *(self._changes, self._home, self._queue),
        )

    def show(self) -> None:
        """Show the cell as it is known now."""
        mirror, words = self._page.site.mirror, self._page.words
        now = telling(mirror.snapshot)
        attribute(self._whole, "data-phase", now.phase)
        never = now.phase == "never"
        stale = mirror.stale and not never
        # Across the room nobody reads that the question below is an old one.
        self._state.say(words.say("phase.never" if stale else _headline(now)))
        own = _OWN.get(now.phase, "")
        sentence = words.say(own) if own else now.sentence
        self._sentence.show("" if stale else beside(sentence, self._state.text, now.changes))
        attribute(self._sentence, "lang", words.language if own else now.language)
        age = duration(words, mirror.age_s) if stale else ""
        self._stale.show(words.say("page.stale_sentence", age=age) if age else "")
        for part in self._panels:
            part.show(now)
        self._ears.show(now)
        if self._actions is not None:
            self._actions.show(now)
        self._stage.show(now)


def _headline(now: Telling) -> str:
    """The key of what is readable from across the room."""
    if now.phase == "asking" and now.question in {"take_apart", "hand_over"}:
        return f"phase.asking_{now.question}"
    if now.phase == "waiting" and now.need:
        return f"phase.waiting_{now.need}"
    return f"phase.{now.phase}"


class _Ears:
    """Whether the cell listens: only what the cell itself says of its microphone."""

    def __init__(self, page: Page) -> None:
        self._page = page
        with box("p", "ears") as self._whole:
            with box("span", "ears__on") as self._on:
                icon("mic")
            with box("span", "ears__off") as self._off:
                icon("muted")
            self._text = Text("span")

    def show(self, now: Telling) -> None:
        """Show the microphone as it is known now."""
        snapshot = self._page.site.mirror.snapshot
        stale = self._page.site.mirror.stale
        state = snapshot.ears.state if snapshot is not None and not stale else "off"
        hears = state in {"listening", "waiting", "recording", "slow"}
        attribute(self._whole, "data-ears", state)
        # A visitor's own device has no part in it: the microphone is the cell's.
        shown(self._whole, snapshot is not None and not stale and not self._page.visitor)
        shown(self._on, hears)
        shown(self._off, not hears)
        self._text.say(self._page.words.say(f"ears.{self._key(now, state)}"))

    def _key(self, now: Telling, state: str) -> str:
        if now.speaking:
            return "speaking"
        by_button = self._page.site.config.hearing.activation == "push_to_talk"
        return "waiting_press" if state == "waiting" and by_button else state
