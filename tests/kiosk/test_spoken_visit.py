"""Whole visits by voice alone, from the sound in the room to what stands in the cell.

People speak into a virtual microphone, which also hears the cell's own voice; the page is open in a
real browser; the cell is emulated at the wire. What the page shows and what the world holds are
both compared with what was said.
"""

from __future__ import annotations

import re
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import Literal

import pytest

from cellctl.client import CellClient
from cellctl.config import CellConfig
from cellctl.errors import RefusedError
from cellctl.messages import Snapshot
from tests.cell.lives import BUSY
from tests.cell.spoken import ECHO_DB, People, hearing, people, said, wait_for_ears
from tests.kiosk.harness import OpenPage, Visit, visit

pytestmark = pytest.mark.wire

SPEED, SOAK_SPEED = 6.0, 15.0
NO_ANSWER_S = 10.0
"""Nobody waits longer for an answer to a yes."""
QUESTION = "Shall I build it?"


@dataclass(frozen=True)
class Plot:
    """What a visitor says, and what must come of it."""

    wish: str
    title: str
    change: str
    new_title: str


SHORT = Plot("the letter T", "Letter T", "the letter L", "Letter L")
PLOTS: dict[Literal["open", "wake_word"], tuple[Plot, ...]] = {
    "open": (
        Plot("a simple stool", "Stool", "a small bench", "bench"),
        Plot("the letter X", "Letter X", "the letter T", "Letter T"),
        Plot("make me a coffee table", "coffee table", "a table with one leg", "table"),
        Plot("I want a chair", "chair", "make it taller", "chair"),
        Plot("build me an arch", "arch", "make a cross", "cross"),
    ),
    "wake_word": (
        Plot("the letter A", "Letter A", "the letter T", "Letter T"),
        Plot("a side table", "side table", "a simple stool", "Stool"),
        Plot("a shelf with two tiers", "shelf", "a simple box", "box"),
        Plot("I want a small bench", "bench", "make it wider", "bench"),
        Plot("could you build a tower", "tower", "the letter L", "Letter L"),
    ),
}


class Visitor:
    """Somebody who speaks to the cell and looks at its page."""

    def __init__(self, there: Visit, people: People, page: OpenPage, *, wakes: bool) -> None:
        self.there = there
        self.cell = there.cell
        self.people = people
        self.page = page
        self._wakes = wakes
        self._told = 0
        """How many lines the cell had said when it was asked last."""

    def ask(self, sentence: str) -> None:
        """Say a wish or a change, after the wake word where it needs one, as politely as most
        people do: once the cell has finished speaking."""
        line = self.hush().dialogue.line
        self._told = line.number if line is not None else 0
        if self._wakes:
            self.people.say("hey mycroft")
            self.cell.wait("the wake word", lambda now: now.ears.state == "recording")
        self.people.say(sentence)

    def agree(self) -> None:
        """Say yes at once, perhaps while the cell still speaks; where that was not understood, or
        not heard over the cell's own voice, its visitor says it again once it has finished."""
        question = self.cell.wait(
            "a question", lambda now: now.state.state == "validating_confirming"
        )
        asked = self.line(question)
        self.people.say("yes")
        patience_s = time.monotonic() + NO_ANSWER_S
        heard = self.cell.wait(
            "a yes, or the question again, or nothing",
            lambda now: (
                now.state.state != "validating_confirming"
                or self.line(now) != asked
                or time.monotonic() > patience_s
            ),
        )
        if heard.state.state == "validating_confirming":
            told = self.line(heard)
            why = "not heard" if told == asked else f"not understood, and told: {told}"
            print(f"a yes was {why}")  # noqa: T201
            self.hush()
            self.people.say("yes")

    @staticmethod
    def line(now: Snapshot) -> str:
        """What the cell said last."""
        return now.dialogue.line.text if now.dialogue.line is not None else ""

    def hush(self) -> Snapshot:
        """Wait until the cell has finished speaking."""
        return self.cell.wait(
            "silence", lambda now: not now.dialogue.speaking and not now.voice.saying
        )

    def is_asked(self, title: str) -> None:
        """Wait until the cell asks about this, aloud and on the page, in the same words."""
        asked = self.cell.wait(
            f"a question about {title}",
            lambda now: (
                now.state.state == "validating_confirming"
                and now.dialogue.line is not None
                and now.dialogue.line.number > self._told
                and title.lower() in now.dialogue.line.text.lower()
                and QUESTION in now.dialogue.line.text
            ),
        )
        assert asked.dialogue.line is not None
        text = asked.dialogue.line.text
        self.page.phase("asking")
        for sentence in re.findall(
            r"\S[^.?!]*[.?!]", text
        ):  # what was changed has a place of its own
            self.page.says(sentence)
        self.cell.wait("those words", lambda now: text in now.voice.saying or text in self.said())

    def said(self) -> list[str]:
        """What the cell said aloud."""
        return said(self.cell)

    def builds(self, plot: Plot) -> None:
        """The visit: a wish, another one, a yes, and apart again."""
        self.page.phase("ready", "done")
        self.ask(plot.wish)
        self.is_asked(plot.title)
        self.page.says(plot.wish)  # what was heard
        self.ask(plot.change)
        self.is_asked(plot.new_title)
        assert self.cell.truth().built == ()  # nothing moves without a yes
        self.agree()
        self.page.phase("building")
        assert self.cell.finish().outcome == "built"
        self.page.phase("done")
        self.cell.assert_as_planned()
        parts = len(self.cell.truth().built)

        self.ask("take it apart")
        self.page.phase("asking")
        self.page.says("Shall I take it apart?")
        assert len(self.cell.truth().built) == parts
        self.agree()
        self.page.phase("taking_apart")
        assert self.cell.finish().outcome == "taken_apart"
        self.page.phase("ready")
        truth = self.cell.truth()
        assert truth.built == ()
        assert truth.violations == ()
        self.cell.assert_inventory_true()


@contextmanager
def spoken_visit(
    activation: Literal["open", "wake_word"], speed: float, real_time_priority: int = 0
) -> Iterator[Visitor]:
    """A visitor before a cell that speaks, and hears itself.

    Args:
        activation: ``hearing.activation``.
        speed: cell seconds per wall second.
        real_time_priority: of the arm's process; other cells would get no processor beside it.
    """
    sections = hearing(activation, speed, loudspeaker="spk")
    sections["robot"] = {"real_time_priority": real_time_priority}
    with people(echo_db=ECHO_DB) as speakers, visit(speed=speed, **sections) as there:
        plots = PLOTS[activation]
        speakers.prepare("hey mycroft", "yes", "take it apart", SHORT.wish, SHORT.change)
        speakers.prepare(*(plot.wish for plot in plots), *(plot.change for plot in plots))
        wait_for_ears(there.cell)
        there.cell.wait("a voice", lambda now: now.voice.state == "quiet")
        # A small screen: 3D without a graphics card is slow, and hearing must not wait for it.
        with (
            attended(there.cell.config),
            there.open(size="phone", reduced_motion="reduce") as page,
        ):
            yield Visitor(there, speakers, page, wakes=activation == "wake_word")
            assert page.problems == []
            assert page.elsewhere == []


@contextmanager
def attended(config: CellConfig) -> Iterator[None]:
    """An operator goes on where a machine that is busy with a browser and a recogniser let the
    robot stop."""
    over = threading.Event()
    ways = {"fault_stopped": "reset", "paused_resting": "resume"}

    def attend() -> None:
        stopped = False
        with CellClient.for_role(config, timeout_s=60.0) as operator:
            while not over.wait(0.5):
                now = operator.snapshot()
                entry = now.fault.entry
                stopped = stopped or (entry is not None and entry.code in BUSY)
                if stopped and now.state.state in ways:
                    with suppress(RefusedError):  # it still brakes
                        operator.command(ways[now.state.state])
                elif now.state.state.startswith(("assembling", "disassembling", "feeding")):
                    stopped = False

    watch = threading.Thread(target=attend, name="attending")
    watch.start()
    try:
        yield
    finally:
        over.set()
        watch.join()


@pytest.mark.timeout(600)
def test_a_visit_by_voice_alone() -> None:
    with spoken_visit("open", SPEED) as visitor:
        visitor.builds(SHORT)


@pytest.mark.soak
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("activation", ["open", "wake_word"])
def test_ten_different_visits(activation: Literal["open", "wake_word"]) -> None:
    # A browser and a recogniser beside a quick arm: see the option.
    with spoken_visit(activation, SOAK_SPEED, real_time_priority=5) as visitor:
        for plot in PLOTS[activation]:
            visitor.cell.begin_test()
            visitor.builds(plot)
            print(f"{plot.wish}, {plot.change}: built and taken apart")  # noqa: T201
