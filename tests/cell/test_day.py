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
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import psutil
import pytest

from cellctl.cli.daemon_process import wait_idle
from cellctl.errors import CellctlError, RefusedError
from cellctl.messages import Snapshot
from cellctl.sim.isolation import isolated
from cellctl.sim.spawn import emulated_cell
from tests.cell.harness import RunningCell, cell_config, watched_daemon

pytestmark = [pytest.mark.wire, pytest.mark.soak]

SPEED = 8.0
PATIENCE_S = 600.0
"""How long anything may take (wall time): a busy machine stops the emulated arm now and then."""
LIVES = (25, 25, 50, 100, 300)
"""After so many visits each the daemon is killed, wherever it is: 500 on the whole day."""
SETTLED = 20
"""After so many visits of a life everything that is loaded once is loaded."""
WISHES = (
    *("a cube 10 cm wide", "a wall 20 cm wide and 10 cm high"),
    "a wall 10 cm wide and 20 cm high",
)
"""One or two parts: a day is long, and what is tried here is the talk between them."""
OTHERS = ("a table", "the letter L", "a chair with three legs")
CHANGES = ("make it taller", "make it wider", "another one", "something different", "the letter I")
NONSENSE = ("the weather is nice", "my dog ate it", "you", "thanks for watching", "purple")
QUESTIONS = (
    *("what can you make?", "how long does it take?", "what are you doing?", "why?"),
    *("how many parts are left?", "who is next?", "who are you?", "say that again", "help"),
)


@dataclass
class Told:
    """What came of a day."""

    visits: Counter[str] = field(default_factory=Counter)
    """How many of each kind."""
    outcomes: Counter[str] = field(default_factory=Counter)
    """How the last job of each visit ended."""
    faults: Counter[str] = field(default_factory=Counter)
    """Those that ended visits, by code."""
    resident_mb: list[list[float]] = field(default_factory=list)
    """Memory of the daemon after each visit, life by life."""


@dataclass
class Day:
    """The visits of one day.

    Args:
        cell: what they visit.
        dice: decides what they do.
        told: what comes of it.
    """

    cell: RunningCell
    dice: random.Random
    told: Told

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
        self.told.visits[kind.__name__] += 1
        try:
            kind()
        except _FaultError as fault:
            self.told.faults[str(fault)] += 1
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

    def wait(self, what: str, holds: Callable[[Snapshot], bool]) -> Snapshot:
        """Wait until it is so.

        Raises:
            _FaultError: the cell is in a fault instead, which ends the visit.
        """
        snapshot = self.cell.wait(what, lambda now: holds(now) or now.fault.entry is not None)
        if snapshot.fault.entry is not None:
            raise _FaultError(snapshot.fault.entry.code)
        return snapshot

    def wait_state(self, *states: str) -> str:
        """Wait until the machine is in one of these; see ``wait``."""
        return self.wait(f"state {states}", lambda now: now.state.state in states).state.state

    def wait_built(self) -> None:
        """Wait until the job has ended; see ``wait``."""
        self.wait("the end of the job", lambda now: bool(now.job and now.job.outcome))
        self.wait_state("idle")

    def wish(self, wishes: tuple[str, ...] = WISHES) -> bool:
        """Say a wish, and whether it is asked about."""
        self.say(self.dice.choice(wishes))
        return self.wait_state("validating_confirming", "idle") == "validating_confirming"

    def builds(self) -> None:
        """Says yes, and takes it along or has it taken apart."""
        if not self.wish():
            return
        self.say("yes")
        if self.dice.random() < 0.3:
            self.say(self.dice.choice(QUESTIONS))
        self.wait_built()

    def declines(self) -> None:
        if self.wish(WISHES + OTHERS):
            self.say("no thanks")

    def falls_silent(self) -> None:
        if self.wish(WISHES + OTHERS):
            self.wait("silence", lambda now: now.state.state == "idle")

    def changes_mind(self) -> None:
        for _ in range(self.dice.randint(1, 3)):
            if self.cell.client.snapshot().state.state == "idle" and not self.wish():
                return
            self.say(self.dice.choice(CHANGES))
            self.wait_state("validating_confirming", "idle")
        self.say("never mind")

    def makes_no_sense(self) -> None:
        for _ in range(self.dice.randint(1, 3)):
            self.say(self.dice.choice(NONSENSE))
            self.wait_state("idle", "validating_confirming")

    def asks(self) -> None:
        for _ in range(self.dice.randint(1, 5)):
            assert self.say(self.dice.choice(QUESTIONS))

    def cancels(self) -> None:
        """At any time: while it is understood, planned, asked or built."""
        self.say(self.dice.choice(WISHES))
        if self.dice.random() < 0.5:
            self.wait_state("validating_confirming", "idle")
            self.say("yes")
        self.say("cancel")

    def stops(self) -> None:
        """In the middle of a build; the operator lets it go on."""
        if not self.wish():
            return
        self.say("yes")
        self.wait_state("assembling_placing", "assembling_picking", "idle")
        self.say("stop")
        if self.wait_state("paused_resting", "idle") == "paused_resting":
            self.cell.client.command("resume")
        self.wait_built()

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
            self.told.outcomes[snapshot.job.outcome] += 1
        while snapshot.standing:
            with contextlib.suppress(_FaultError):
                self.takes_along() if self.dice.random() < 0.7 else self.has_it_taken_apart()
            snapshot = cell.wait("a cell that listens", rests)
        self.check()

    def takes_along(self) -> None:
        """Somebody takes what stands, and says so."""
        self.say("thank you, it is mine")
        if self.cell.client.snapshot().dialogue.question == "hand_over":
            self.cell.world.hand_over()
            self.say("yes")

    def has_it_taken_apart(self) -> None:
        self.say("take it apart")
        self.wait_state("validating_confirming")
        self.say("yes")
        self.wait_built()

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


def day(lives: Sequence[int] = LIVES, seed: int = 1) -> Told:
    """A day of visitors.

    Args:
        lives: how many visits each daemon lives to see.
        seed: of all that the visitors do.
    """
    config = cell_config(
        policy={"confirmation": "ask", "confirmation_timeout_s": 20.0},
        dialogue={"take_along_s": 1.0},
        robot={"rtde_frequency_hz": 125},  # a fourth of the work for the emulated link
    )
    dice = random.Random(seed)  # noqa: S311 - no secrets
    told = Told()
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        own = isolated(config, Path(name), SPEED)
        with emulated_cell(own, SPEED) as world:
            for number, visits in enumerate(lives):
                told.resident_mb.append([])
                with (
                    contextlib.suppress(_KilledError),
                    watched_daemon(own, Path(name), world, PATIENCE_S) as cell,
                ):
                    today = Day(cell, dice, told)
                    if number == 0:
                        wait_idle(cell.client, cell.daemon)
                    today.settle()
                    process = psutil.Process(cell.daemon.process.pid)
                    for _ in range(visits):
                        today.visit()
                        told.resident_mb[-1].append(process.memory_info().rss / 1e6)
                    if number + 1 < len(lives):
                        today.say(dice.choice(WISHES))  # and in the middle of that it dies
                        cell.daemon.process.kill()
                        cell.daemon.process.wait()
                        raise _KilledError
    return told


class _FaultError(Exception):
    """The cell is in a fault; its code."""


class _KilledError(Exception):
    """The daemon was killed on purpose."""


@pytest.mark.timeout(7200)
def test_a_day_of_visitors() -> None:
    told = day()
    curves = [
        f"{life[min(SETTLED, len(life) - 1)]:.0f}-{life[-1]:.0f}" for life in told.resident_mb
    ]
    print(told.visits, told.outcomes, told.faults, f"resident: {curves} MB")  # noqa: T201
    for life in told.resident_mb:
        assert life[-1] < life[SETTLED] + 20.0
