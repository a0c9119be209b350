"""A day of visitors who change their minds, fall silent, interrupt and are interrupted.

What the recogniser would hand on is said at the visitor's door; the robot, the belt and the latch
are emulated at the wire, in accelerated time. The daemon is killed and started again in between,
and so are its planner and its arm process.
"""

from __future__ import annotations

import contextlib
import random
import signal
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import psutil
import pytest

from cellctl.cli.daemon_process import wait_idle
from cellctl.errors import CellctlError, RefusedError
from cellctl.sim.isolation import isolated
from cellctl.sim.spawn import emulated_cell
from tests.cell.harness import RunningCell, cell_config, watched_daemon

pytestmark = [pytest.mark.wire, pytest.mark.soak]

VISITS = 500
SPEED = 20.0
LIFE = 25
"""After so many visits the daemon is killed, wherever it is."""
WISHES = ("a cube 10 cm wide", "a tower 20 cm high", "a wall 20 cm wide and 10 cm high")
"""Small things: a day is long."""
OTHERS = ("a table", "the letter L", "a chair with three legs")
CHANGES = ("make it taller", "make it wider", "another one", "something different", "the letter I")
NONSENSE = ("the weather is nice", "my dog ate it", "you", "thanks for watching", "purple")
QUESTIONS = (
    *("what can you make?", "how long does it take?", "what are you doing?", "why?"),
    *("how many parts are left?", "who is next?", "who are you?", "say that again", "help"),
)


@dataclass
class Day:
    """The visits of one day.

    Args:
        cell: what they visit.
        dice: decides what they do.
    """

    cell: RunningCell
    dice: random.Random
    visits: Counter[str] = field(default_factory=Counter)
    outcomes: Counter[str] = field(default_factory=Counter)

    def visit(self) -> None:
        """One visitor, from a cell that listens to a cell that listens."""
        kinds: dict[Callable[[], None], int] = {
            self.builds: 3,
            self.declines: 4,
            self.falls_silent: 2,
            self.changes_mind: 3,
            self.makes_no_sense: 3,
            self.asks: 3,
            self.cancels: 2,
            self.stops: 1,
            self.is_joined: 2,
            self.loses_a_process: 1,
        }
        kind = self.dice.choices(list(kinds), list(kinds.values()))[0]
        self.visits[kind.__name__] += 1
        kind()
        self.settle()

    def say(self, text: str, visitor: str = "") -> str:
        """What the cell answers; a refusal is an answer, too."""
        self.cell.visitor.visitor = visitor
        try:
            return self.cell.visitor.say(text).message
        except RefusedError as error:
            return str(error)
        finally:
            self.cell.visitor.visitor = ""

    def wish(self, wishes: tuple[str, ...] = WISHES) -> bool:
        """Say a wish, and whether it is asked about."""
        self.say(self.dice.choice(wishes))
        state = self.cell.wait_state("validating_confirming", "idle").state.state
        return state == "validating_confirming"

    def builds(self) -> None:
        """Says yes, and takes it along or has it taken apart."""
        if not self.wish():
            return
        self.say("yes")
        if self.dice.random() < 0.3:
            self.say(self.dice.choice(QUESTIONS))
        self.cell.finish()

    def declines(self) -> None:
        if self.wish(WISHES + OTHERS):
            self.say("no thanks")

    def falls_silent(self) -> None:
        if self.wish(WISHES + OTHERS):
            self.cell.wait("silence", lambda now: now.state.state == "idle")

    def changes_mind(self) -> None:
        for _ in range(self.dice.randint(1, 3)):
            if self.cell.client.snapshot().state.state == "idle" and not self.wish():
                return
            self.say(self.dice.choice(CHANGES))
            self.cell.wait_state("validating_confirming", "idle")
        self.say("never mind")

    def makes_no_sense(self) -> None:
        for _ in range(self.dice.randint(1, 3)):
            self.say(self.dice.choice(NONSENSE))
            self.cell.wait_state("idle", "validating_confirming")

    def asks(self) -> None:
        for _ in range(self.dice.randint(1, 5)):
            assert self.say(self.dice.choice(QUESTIONS))

    def cancels(self) -> None:
        """At any time: while it is understood, planned, asked or built."""
        self.say(self.dice.choice(WISHES))
        if self.dice.random() < 0.5:
            self.cell.wait_state("validating_confirming", "idle")
            self.say("yes")
        self.say("cancel")

    def stops(self) -> None:
        """In the middle of a build; the operator lets it go on."""
        if not self.wish():
            return
        self.say("yes")
        self.cell.wait_state("assembling_placing", "assembling_picking", "idle")
        self.say("stop")
        if self.cell.wait_state("paused_resting", "idle").state.state == "paused_resting":
            self.cell.client.command("resume")
        self.cell.finish()

    def is_joined(self) -> None:
        """Somebody else says a wish meanwhile, and nobody answers when its turn comes."""
        if not self.wish():
            return
        self.say(f"call me {self.dice.choice(('Anna', 'Ben'))}", "another")
        self.say(self.dice.choice(OTHERS), "another")
        assert "nother visitor" in self.say("yes", "another")
        self.say(self.dice.choice(("no", "yes")))

    def loses_a_process(self) -> None:
        """The planner or the arm's process dies while somebody waits for an answer."""
        self.say(self.dice.choice(WISHES))
        children = psutil.Process(self.cell.daemon.process.pid).children()
        victim = self.dice.choice(children)
        with contextlib.suppress(psutil.NoSuchProcess):
            victim.send_signal(signal.SIGKILL)

    def settle(self) -> None:
        """An operator brings it back where it cannot come by itself; then it listens."""
        cell = self.cell

        def rests(_now: object) -> bool:
            snapshot = cell.client.snapshot()
            state = snapshot.state.state
            if state in {"fault_held", "fault_stopped", "fault_emergency"}:
                with contextlib.suppress(CellctlError):
                    cell.client.command("reset")
            elif state == "paused_resting":
                with contextlib.suppress(CellctlError):
                    cell.client.command("resume")
            return state == "idle" and not snapshot.dialogue.queue

        snapshot = cell.wait("a cell that listens", rests)
        if snapshot.job is not None:
            self.outcomes[snapshot.job.outcome] += 1
        if snapshot.standing:
            if self.dice.random() < 0.7:
                self.say("thank you, it is mine")
                cell.world.hand_over()
                self.say("yes")
            else:
                self.say("take it apart")
                cell.wait_state("validating_confirming")
                self.say("yes")
                cell.finish()
        self.check()

    def check(self) -> None:
        """It listens, nothing is lost, and what the cell believes is the truth."""
        cell = self.cell
        snapshot = cell.wait("rest", lambda now: now.dialogue.phase == "ready")
        assert snapshot.standing == ()
        truth = cell.truth()
        assert not truth.violations, truth.violations
        assert sum(truth.counts.values()) == cell.config.limits.inventory_parts
        cell.assert_inventory_true()
        cell.seen.clear()
        if snapshot.inventory["handed_over"] > 20:  # somebody brings them back
            cell.clear_workspace()


def day(visits: int, seed: int = 1) -> dict[str, object]:
    """A day; returns what came of it.

    Args:
        visits: how many.
        seed: of all that the visitors do.
    """
    config = cell_config(
        policy={"confirmation": "ask", "confirmation_timeout_s": 20.0},
        dialogue={"take_along_s": 1.0},
    )
    dice = random.Random(seed)  # noqa: S311 - no secrets
    done, lives = 0, 0
    counted: Counter[str] = Counter()
    ended: Counter[str] = Counter()
    resident_mb: list[float] = []
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        own = isolated(config, Path(name), SPEED)
        with emulated_cell(own, SPEED) as world:
            while done < visits:
                lives += 1
                with (
                    contextlib.suppress(_KilledError),
                    watched_daemon(own, Path(name), world) as cell,
                ):
                    today = Day(cell, dice, counted, ended)
                    if lives == 1:
                        wait_idle(cell.client, cell.daemon)
                    today.settle()
                    for _ in range(min(LIFE, visits - done)):
                        today.visit()
                        done += 1
                        process = psutil.Process(cell.daemon.process.pid)
                        resident_mb.append(process.memory_info().rss / 1e6)
                    if done < visits:
                        today.say(dice.choice(WISHES))  # and in the middle of that it dies
                        cell.daemon.process.kill()
                        cell.daemon.process.wait()
                        raise _KilledError
    return {
        "visits": done,
        "lives": lives,
        "kinds": dict(counted),
        "outcomes": dict(ended),
        "resident_mb": resident_mb,
    }


class _KilledError(Exception):
    """The daemon was killed on purpose."""


@pytest.mark.timeout(7200)
def test_a_day_of_visitors() -> None:
    told = day(VISITS)
    resident_mb = told.pop("resident_mb")
    assert isinstance(resident_mb, list)
    print(told, f"resident {resident_mb[4]:.0f} -> {resident_mb[LIFE - 1]:.0f} MB in a life")  # noqa: T201
    for life in range(0, len(resident_mb) - LIFE, LIFE):
        assert resident_mb[life + LIFE - 1] < resident_mb[life + 4] + 20.0
