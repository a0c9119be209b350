"""The visitor's view: what the cell understood, what it asks, and how the object grows."""

from __future__ import annotations

from nicegui.element import Element

from cellctl.assembly import Role
from cellctl.kiosk.components import Button, Entry, Text, attribute, box, icon, shown
from cellctl.kiosk.shell import Page, duration
from cellctl.kiosk.visitor.telling import Telling, telling
from cellctl.messages import (
    MAX_TEXT,
    Command,
    ConfirmCommand,
    ListenCommand,
    PlainCommand,
    SayCommand,
)


def visitor_page(page: Page) -> None:
    """Build the view."""
    page.follow(_Visit(page).show)


class _Visit:
    """The elements of one open page, and what they show."""

    def __init__(self, page: Page) -> None:
        self._page = page
        words = page.words
        with box("section", "visit") as self._whole:
            with box("div", "visit__words"):
                self._ears = _Ears(page)
                with box("div", "visit__now", aria_live="polite"):
                    self._state = Text("h1", "", "visit__state")
                    self._sentence = Text("p", "", "visit__sentence")
                self._stale = Text("p", "", "visit__stale")
                self._stale.props["role"] = "status"
                with box("dl", "visit__said") as self._said:
                    self._heard = _Pair(words.say("visit.heard"))
                    self._understood = _Pair(words.say("visit.understood"))
                self._progress = _Progress(page)
                self._changes = _Changes(words.say("visit.changed"))
            self._actions = _Actions(page)

    def show(self) -> None:
        """Show the cell as it is known now."""
        mirror, words = self._page.site.mirror, self._page.words
        now = telling(mirror.snapshot, mirror.speech)
        attribute(self._whole, "data-phase", now.phase)
        question = now.phase == "asking" and now.takes_apart
        self._state.say(words.say("phase.asking_apart" if question else f"phase.{now.phase}"))
        never = now.phase == "never"
        self._sentence.show(words.say("page.never_sentence") if never else now.sentence)
        age = duration(words, mirror.age_s) if mirror.stale and not never else ""
        self._stale.show(words.say("page.stale_sentence", age=age) if age else "")
        self._heard.show(now.heard)
        self._understood.show(now.understood)
        shown(self._said, bool(now.heard or now.understood))
        self._progress.show(now)
        self._changes.show(now)
        self._ears.show()
        self._actions.show(now)


class _Pair:
    """A name and what it is: hidden when there is nothing."""

    def __init__(self, name: str) -> None:
        with box("div", "pair") as self._whole:
            Text("dt", name)
            self._value = Text("dd")

    def show(self, value: str) -> None:
        """Show this value."""
        self._value.say(value)
        shown(self._whole, bool(value))


class _Ears:
    """Whether the cell listens: only what the cell itself says of its microphone."""

    def __init__(self, page: Page) -> None:
        self._page = page
        with box("p", "ears") as self._whole:
            with box("span", "ears__on") as self._on:
                icon("mic")
            with box("span", "ears__off") as self._off:
                icon("muted")
            self._said = Text("span")

    def show(self) -> None:
        """Show the microphone as it is known now."""
        snapshot = self._page.site.mirror.snapshot
        state = snapshot.ears.state if snapshot is not None else "off"
        attribute(self._whole, "data-ears", state)
        hears = state in {"listening", "waiting", "recording", "slow"}
        shown(self._on, hears)
        shown(self._off, not hears)
        self._said.say(self._page.words.say(f"ears.{state}"))


class _Progress:
    """How far the object is."""

    def __init__(self, page: Page) -> None:
        self._words = page.words
        with box("div", "progress") as self._whole:
            with box("div", "progress__words"):
                self._count = Text("span", "", "progress__count")
                self._left = Text("span", "", "progress__left")
            with box("div", "progress__line", role="progressbar", aria_valuemin="0") as self._bar:
                self._done = box("div", "progress__done")
        self._bar.props["aria-label"] = page.words.say("page.parts")

    def show(self, now: Telling) -> None:
        """Show how many parts are done, and how long the rest takes."""
        at_work = now.phase in {"building", "apart", "paused", "fault"} and now.total > 0
        planned = now.phase == "asking" and now.total > 0
        shown(self._whole, at_work or planned)
        shown(self._bar, at_work)
        if not (at_work or planned):
            return
        words = self._words
        time = duration(words, now.left_s) if now.left_s else ""
        if planned:
            key = "visit.plan" if time else "visit.plan_bare"
            self._count.say(words.say(key, parts=now.total, time=time))
            self._left.say("")
            return
        self._count.say(words.say("visit.progress", done=now.placed, total=now.total))
        self._left.say(words.say("visit.left", time=time) if time else "")
        attribute(self._bar, "aria-valuemax", str(now.total))
        attribute(self._bar, "aria-valuenow", str(now.placed))
        attribute(self._done, "style", f"width: {100.0 * now.placed / now.total:.1f}%")


class _Changes:
    """What the planner made otherwise than it was wished, and why."""

    def __init__(self, name: str) -> None:
        with box("div", "changes") as self._whole:
            Text("h2", name, "changes__name")
            self._list = box("ul", "changes__list")
        self._shown: tuple[tuple[str, str], ...] | None = None

    def show(self, now: Telling) -> None:
        """Show the changes."""
        wanted = tuple((change.what, change.why) for change in now.changes)
        shown(self._whole, bool(wanted))
        if wanted == self._shown:
            return
        self._shown = wanted
        self._list.clear()
        with self._list:
            for what, why in wanted:
                with box("li"):
                    Text("span", what, "changes__what")
                    Text("span", why, "changes__why")


class _Actions:
    """What a visitor may do, within thumb's reach; never more than the visitor's door takes."""

    def __init__(self, page: Page) -> None:
        self._page = page
        words = page.words
        with box("div", "actions") as self._whole:
            with box("div", "actions__buttons"):
                self._yes = self._button("visit.yes", ConfirmCommand(answer=True), "yes", "strong")
                self._no = self._button("visit.no", ConfirmCommand(answer=False), "no")
                self._another = self._button(
                    "visit.another", SayCommand(text="something else"), "another"
                )
                self._talk = self._button("visit.talk", ListenCommand(), "mic", "strong")
                self._apart = self._button(
                    "visit.apart", PlainCommand(command="take_apart"), "apart"
                )
                self._mine = self._button("visit.mine", PlainCommand(command="hand_over"), "home")
                self._stop = self._button(
                    "visit.stop", PlainCommand(command="stop"), "stop", "danger"
                )
            self._entry = Entry(
                words.say("visit.type"), words.say("visit.send"), self._typed, MAX_TEXT
            )

    def _button(self, key: str, body: Command, picture: str, kind: str = "plain") -> Button:
        async def act() -> None:
            await self._page.site.link.ask(body, role=Role.VISITOR)

        label = self._page.words.say(key)
        return Button(label, act, kind=kind, picture=picture)  # type: ignore[arg-type]

    async def _typed(self, text: str) -> None:
        await self._page.site.link.ask(SayCommand(text=text), role=Role.VISITOR)

    def show(self, now: Telling) -> None:
        """Offer what makes sense now."""
        may = self._page.site.config.kiosk.visitors_may_act
        shown(self._whole, may and now.phase != "never")
        words = self._page.words
        self._yes.label.say(words.say("visit.yes_apart" if now.takes_apart else "visit.yes"))
        snapshot = self._page.site.mirror.snapshot
        hears = snapshot is not None and snapshot.ears.state in {"waiting", "listening"}
        offered: tuple[tuple[Element, bool], ...] = (
            (self._yes, now.phase == "asking"),
            (self._no, now.phase == "asking"),
            (self._another, now.phase == "asking" and not now.takes_apart),
            (self._talk, hears and now.phase in {"idle", "done"}),
            (self._apart, now.phase in {"done", "idle"} and now.standing),
            (self._mine, now.phase == "done"),
            (self._stop, now.moving or now.phase in {"thinking", "asking", "hearing"}),
        )
        for element, wanted in offered:
            shown(element, wanted)
        stale = self._page.site.mirror.stale
        for element, _ in offered:
            if isinstance(element, Button) and element is not self._stop:
                element.enable(not stale)
        shown(self._entry, now.phase in {"idle", "done", "asking", "hearing"})
