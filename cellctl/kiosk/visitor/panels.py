"""The smaller parts of the visitor's view: each shows one thing, and hides where there is none."""

from __future__ import annotations

from datetime import UTC, datetime

from cellctl.kiosk.components import Text, attribute, box, shown
from cellctl.kiosk.shell import Page, duration
from cellctl.kiosk.take_home import take_home_path
from cellctl.kiosk.take_page import code_image
from cellctl.kiosk.visitor.telling import Telling, in_other_words


class Said:
    """What was heard, and what was understood of it."""

    def __init__(self, page: Page) -> None:
        self._words = page.words
        with box("dl", "visit__said") as self._whole:
            self._heard = _Pair("", "quote")
            self._understood = _Pair(page.words.say("visit.understood"), "")

    def show(self, now: Telling) -> None:
        """Show both; where they are the same words, once."""
        differs = in_other_words(now.heard, now.understood)
        same = bool(now.understood) and not differs
        self._heard.name.say(self._words.say("visit.heard_understood" if same else "visit.heard"))
        self._heard.show(now.heard)
        self._understood.show(now.understood if differs else "")
        # Where people are needed, that is what is to be read.
        shown(self._whole, bool(now.heard or now.understood) and not now.need)


class _Pair:
    """A name and what it is."""

    def __init__(self, name: str, classes: str) -> None:
        with box("div", "pair") as self._whole:
            self.name = Text("dt", name)
            self._value = Text("dd", "", classes)

    def show(self, value: str) -> None:
        """Show this value; hide where it is empty."""
        self._value.say(value)
        shown(self._whole, bool(value))


class Countdown:
    """How long a question stays open; then silence counts as a no."""

    def __init__(self, page: Page) -> None:
        with box("div", "countdown") as self._whole:
            with box("div", "countdown__line"):
                self._left = box("div", "countdown__left")
            Text("p", page.words.say("visit.silence"), "small")
        self._page = page
        self._deadline: datetime | None = None

    def show(self, now: Telling) -> None:
        """Begin a line that shortens by itself, once for each question."""
        shown(self._whole, now.deadline is not None and not self._page.site.mirror.stale)
        if now.deadline == self._deadline:
            return
        self._deadline = now.deadline
        if now.deadline is not None:
            left_s = max(0.0, (now.deadline - datetime.now(UTC)).total_seconds())
            # Two names of the same movement: another name begins it anew.
            name = "run-out" if "again" in self._left.props.get("style", "") else "run-out-again"
            attribute(self._left, "style", f"animation: {name} {left_s:.1f}s linear forwards")


class Progress:
    """How far the object is, and how long the rest takes."""

    def __init__(self, page: Page) -> None:
        self._page = page
        with box("div", "progress") as self._whole:
            with box("div", "progress__words"):
                self._count = Text("span", "", "progress__count")
                self._left = Text("span", "", "progress__left")
            with box("div", "progress__line", role="progressbar", aria_valuemin="0") as self._bar:
                self._done = box("div", "progress__done")
        self._bar.props["aria-label"] = page.words.say("page.parts")

    def show(self, now: Telling) -> None:
        """Show how many parts are done."""
        at_work = now.phase in {"building", "taking_apart", "waiting", "fault"} and now.total > 0
        shown(self._whole, at_work)
        if not at_work:
            return
        words = self._page.words
        # While it waits for people nobody knows how long it takes.
        time = duration(words, now.left_s) if now.left_s and not now.need else ""
        self._count.say(words.say("visit.progress", done=now.placed, total=now.total))
        self._left.say(words.say("visit.left", time=time) if time else "")
        attribute(self._bar, "aria-valuemax", str(now.total))
        attribute(self._bar, "aria-valuenow", str(now.placed))
        attribute(self._done, "style", f"width: {100.0 * now.placed / now.total:.1f}%")


class Changes:
    """What the planner made otherwise than it was wished, and why."""

    def __init__(self, page: Page) -> None:
        with box("div", "changes") as self._whole:
            Text("h2", page.words.say("visit.changed"), "changes__name")
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


class Queue:
    """Whose wishes wait."""

    def __init__(self, page: Page) -> None:
        self._page = page
        with box("div", "queue") as self._whole:
            Text("h2", page.words.say("visit.queue"), "changes__name")
            self._list = box("ol", "queue__list")
        self._shown: tuple[object, ...] = ()

    def show(self, now: Telling) -> None:
        """Show them in their order."""
        shown(self._whole, bool(now.queue))
        if now.queue == self._shown:
            return
        self._shown = now.queue
        self._list.clear()
        with self._list:
            for entry in now.queue:
                with box("li"):
                    Text("span", entry.wish, "queue__wish")
                    name = entry.name or f"#{entry.ticket}"
                    Text("span", name, "small")


class TakeHome:
    """The code that leads a phone to the picture and the 3D file of what was built."""

    def __init__(self, page: Page) -> None:
        self._page = page
        words = page.words
        with box("div", "home card") as self._whole:
            self._code = box("img", "home__code", alt="")
            with box("div", "home__words"):
                Text("h2", words.say("visit.take_home"), "title")
                self._how = Text("p", words.say("visit.take_home_how"), "small")
                self._link = Text("a", words.say("take.open"), "home__link")
        self._job_id = ""

    def show(self, now: Telling) -> None:
        """Show the code of the job that has ended well."""
        wanted = now.phase == "done" and bool(now.job_id)
        shown(self._whole, wanted)
        if not wanted or now.job_id == self._job_id:
            return
        self._job_id = now.job_id
        path, home = take_home_path(now.job_id), self._page.site.config.kiosk.home
        attribute(self._link, "href", f"{path}?lang={self._page.words.language}")
        for element in (self._code, self._how):
            shown(element, bool(home))
        if home:
            attribute(self._code, "src", code_image(f"{home}{path}"))
