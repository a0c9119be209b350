"""One build in many lives: a daemon that dies, and another that goes on with what it left."""

from __future__ import annotations

import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from cellctl.client import CellClient, NoDaemonError
from cellctl.config import CellConfig
from cellctl.errors import RefusedError
from cellctl.messages import RefillCommand, Snapshot
from cellctl.sim.client import SimClient
from cellctl.sim.isolation import isolated, write_config
from cellctl.sim.messages import CellTruth
from cellctl.sim.spawn import emulated_cell
from tests.cell.harness import PATIENCE_S, bar, cell_config

_REPLY_S = 0.3
"""A daemon that dies does not answer; longer is not waited for (wall time)."""
_POLL_S = 0.05
BUSY = {"robot_lost", "program_stopped"}
"""What a machine brings about that is too busy for its robot: an operator resets and resumes."""


@dataclass
class Lives:
    """An emulated cell, in which one daemon follows another.

    Args:
        config: of all the daemons.
        folder: holds their configuration, journal and logs.
        world: the emulated cell.
        parts: length, width and height of what is built, again and again.
        takes_apart: whether the cell takes it apart again; else a person takes it out.
    """

    config: CellConfig
    folder: Path
    world: SimClient
    parts: tuple[int, int, int] = (2, 1, 4)
    takes_apart: bool = False
    settled_s: list[float] = field(default_factory=list)
    """From the start of each process to where it stands still and knows what is (wall time)."""
    found: Counter[str] = field(default_factory=Counter)
    """The states that the daemons came up in."""
    built: int = 0
    untold: bool = False
    """Somebody has taken the object out, and no daemon has written that down yet."""

    @contextmanager
    def life(self, *arguments: str) -> Iterator[Life]:
        """A daemon; with arguments, one that kills itself (see ``dying_daemon``)."""
        file, log = self.folder / "cell.toml", self.folder / "daemon.log"
        write_config(self.config, file)
        program = ["cellctl", "run", "--config", str(file)]
        if arguments:
            program = ["tests.cell.dying_daemon", str(file), *arguments]
        with log.open("ab") as sink, CellClient.for_role(self.config, timeout_s=_REPLY_S) as client:
            began_s = time.monotonic()
            process = subprocess.Popen(
                [sys.executable, "-m", *program],
                stdin=subprocess.DEVNULL,
                stdout=sink,
                stderr=sink,
            )
            try:
                yield Life(self, process, client, began_s)
            finally:
                process.kill()
                process.wait()
        self.check_world()

    def check_world(self) -> CellTruth:
        """No part is lost or doubled, none fell, and nothing was touched."""
        truth = self.world.truth()
        assert not truth.violations, f"the world holds against the cell: {truth.violations}"
        assert sum(truth.counts.values()) == self.config.feeder.capacity_parts
        return truth


@dataclass
class Life:
    """One daemon.

    Args:
        lives: what it is one of.
        process: the daemon.
        client: at its operator's door.
        began_s: when it was started, on the monotonic clock.
    """

    lives: Lives
    process: subprocess.Popen[bytes]
    client: CellClient
    began_s: float

    @property
    def dead(self) -> bool:
        """Whether it has ended."""
        return self.process.poll() is not None

    def settle(self) -> Snapshot | None:
        """Wait until it stands still and has said what it believes, which must be the truth; None
        when it died before."""
        while snapshot := self._snapshot():
            state = snapshot.state.state
            if state == "starting":
                self._listen()
                continue
            if snapshot.fault.entry is not None and snapshot.fault.entry.code in BUSY:
                return snapshot
            assert state in {"idle", "paused_resting"}, f"{state}: {snapshot.fault}"
            assert ("started again" in snapshot.state.sentence) is (state == "paused_resting")
            assert not snapshot.doubt, snapshot.doubt
            self.lives.settled_s.append(time.monotonic() - self.began_s)
            self.lives.found[state] += 1
            if not self.lives.untold:
                self._check_belief(snapshot)
            return snapshot
        return None

    def _check_belief(self, snapshot: Snapshot) -> None:
        """The inventory is the world's own count, and the structure stands where it is believed."""
        truth = self.lives.check_world()
        counts = {place.value: count for place, count in truth.counts.items()}
        believed = snapshot.inventory
        assert believed["belt"] == counts["belt"] + counts["pick_station"]
        assert believed["stock"] == counts["stock"]
        if snapshot.gripper.holding == "gripped" and counts["gripper"]:
            # A part that is off its place by millimetres still counts as standing.
            (off,) = set(snapshot.standing) - set(truth.built)
            assert off not in truth.built
            return
        assert believed["gripper"] == counts["gripper"]
        assert believed["structure"] == counts["placed"]
        assert set(snapshot.standing) == set(truth.built)

    def go_on(self, until_s: float = float("inf")) -> bool:
        """Resume, or begin the next build, and so on, until the daemon dies; True when one build
        was completed before.

        Args:
            until_s: of the monotonic clock; the daemon lives on then.
        """
        completed = False
        deadline_s = time.monotonic() + PATIENCE_S
        while (snapshot := self._snapshot()) and time.monotonic() < until_s:
            assert time.monotonic() < deadline_s, f"nothing comes of {snapshot.state}"
            state = snapshot.state.state
            entry = snapshot.fault.entry
            assert entry is None or entry.code in BUSY, f"{state}: {snapshot.fault}"
            try:
                if state in {"fault_held", "fault_stopped"}:
                    self.client.command("reset")
                elif state == "paused_resting":
                    self.client.command("resume")
                elif state == "idle":
                    completed = self._begin_anew(snapshot) or completed
            except (NoDaemonError, RefusedError):  # it dies, or has gone on by itself
                continue
            self._listen()
        return completed

    def _begin_anew(self, snapshot: Snapshot) -> bool:
        """Look at what was built, take it out, and begin to build it again."""
        lives = self.lives
        if lives.takes_apart and snapshot.standing:
            self._check_belief(snapshot)
            self.client.command("take_apart")
            return False
        if lives.takes_apart:
            lives.built += self._is_apart(snapshot)
            self.client.build("bar.json", bar(*lives.parts))
            return True
        completed = bool(snapshot.standing) and not lives.untold
        if completed:
            self._check_belief(snapshot)
            # A daemon that was started after the last part was placed knows of no plan.
            if snapshot.plan is not None:
                assert set(snapshot.standing) == set(snapshot.plan.assembly.cells)
            lives.built += 1
        if completed or lives.untold:
            lives.untold = True
            lives.world.clear_workspace()
            lives.world.refill()
            self.client.command("clear")
            if self.client.snapshot().inventory["stock"]:
                self.client.request(RefillCommand())
            lives.untold = False
        self.client.build("bar.json", bar(*lives.parts))
        return completed

    def _is_apart(self, snapshot: Snapshot) -> bool:
        """Whether something was taken apart before; all of it is on the belt then."""
        self._check_belief(snapshot)
        assert snapshot.inventory["belt"] == self.lives.config.feeder.capacity_parts
        return snapshot.job is not None and snapshot.job.outcome == "taken_apart"

    def _listen(self) -> None:
        """Wait a little, or until something happens."""
        for _ in self.client.messages(_POLL_S):
            return

    def _snapshot(self) -> Snapshot | None:
        """What the daemon says; None when it is dead."""
        deadline_s = time.monotonic() + PATIENCE_S
        while not self.dead:
            try:
                return self.client.snapshot()
            except NoDaemonError:
                assert time.monotonic() < deadline_s, "it neither answers nor dies"
        return None


@contextmanager
def many_lives(folder: Path, speed: float = 10.0, *, takes_apart: bool = False) -> Iterator[Lives]:
    """An emulated cell for daemons that die; nobody asks before building."""
    config = isolated(cell_config(), folder, speed)
    with emulated_cell(config, speed) as world:
        lives = Lives(config, folder, world, takes_apart=takes_apart)
        try:
            yield lives
        except BaseException:
            print((folder / "daemon.log").read_text(errors="replace")[-6000:])  # noqa: T201
            raise
