"""One running cell for tests: the emulated cell and the daemon as processes, and their clients."""

from __future__ import annotations

import math
import re
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from cellctl.assembling.frames import Frames
from cellctl.assembly import Assembly, Role
from cellctl.cli.daemon_process import DaemonProcess, running_daemon, wait_idle
from cellctl.client import CellClient, NoDaemonError
from cellctl.config import CellConfig, load_config
from cellctl.errors import RefusedError
from cellctl.messages import (
    CountCommand,
    HandCommand,
    HandMove,
    JobData,
    RefillCommand,
    Snapshot,
    StatusMessage,
)
from cellctl.sim.client import SimClient
from cellctl.sim.isolation import isolated
from cellctl.sim.messages import CellTruth
from cellctl.sim.spawn import emulated_cell
from cellctl.sim.world_values import Where

CONFIG = Path(__file__).parents[2] / "config" / "sim.toml"
PATIENCE_S = 180.0
"""How long a test waits for anything (wall time); machines can be slow."""
_POLL_S = 0.05
_OFF_M = 0.1
_DEVICES = {"arm", "conveyor", "gripper"}


def _was_heard_late(now: Snapshot, window_s: float) -> bool:
    """Whether the robot's program ended because a busy machine fed its watchdog too late, which no
    test of a whole cell is about."""
    pause = re.search(r"(\d+\.\d+) s", now.fault.detail)
    return _program_has_ended(now) and pause is not None and float(pause[1]) >= window_s


def _program_has_ended(now: Snapshot) -> bool:
    return now.fault.entry is not None and now.fault.entry.code == "program_stopped"


@dataclass
class RunningCell:
    """A cell that runs, and everything a test may do to it."""

    config: CellConfig
    world: SimClient
    client: CellClient
    visitor: CellClient
    daemon: DaemonProcess
    seen: list[StatusMessage] = field(default_factory=list)
    patience_s: float = PATIENCE_S
    held_before: int = 0
    """Violations of earlier tests; the world never forgets."""

    def begin_test(self) -> None:
        """Forget what earlier tests saw."""
        while any(True for _ in self.client.messages(0.0)):
            pass
        self.seen.clear()
        self.held_before = len(self.truth().violations)

    def wait(self, what: str, holds: Callable[[Snapshot], bool]) -> Snapshot:
        """Wait until the snapshot is as wanted; keeps every status message on the way."""
        deadline_s = time.monotonic() + self.patience_s
        while True:
            try:
                snapshot = self.client.snapshot()
            except NoDaemonError as error:
                pytest.fail(f"{error} Waited for {what}.\n{self.daemon.log_tail(8000)}")
            if _was_heard_late(snapshot, 1.0 / self.config.robot.watchdog_hz):
                self._go_on(deadline_s)
                continue
            if holds(snapshot):
                return snapshot
            assert time.monotonic() < deadline_s, (
                f"waited in vain for {what}; state {snapshot.state.state}, "
                f"fault {snapshot.fault}, job {snapshot.job}\n{self.daemon.log_tail()}"
            )
            self.listen()

    def _go_on(self, deadline_s: float) -> None:
        """Reset and resume, as an operator does."""
        ways = {
            "fault_stopped": "reset",
            "fault_recovering": "",
            "paused_braking": "",
            "paused_resting": "resume",
        }
        while (state := self.client.snapshot().state.state) in ways:
            assert time.monotonic() < deadline_s, f"no way out of {state}"
            if ways[state]:
                with suppress(RefusedError):  # it brakes, or asks to look first
                    self.client.command(ways[state])
            self.listen()

    def listen(self) -> None:
        """Take in status messages until one tells of more than the devices, or for a moment."""
        until_s = time.monotonic() + _POLL_S
        for message in self.client.messages(_POLL_S):
            self.seen.append(message)
            if message.topic not in _DEVICES or time.monotonic() >= until_s:
                return

    def wait_state(self, *states: str) -> Snapshot:
        """Wait until the machine is in one of these states."""
        return self.wait(f"state {states}", lambda snapshot: snapshot.state.state in states)

    def wait_held(self) -> Snapshot:
        """Wait until the arm is so far from the pick station that its latch has been proven."""
        station = Frames(self.config).pick_tcp()[:2, 3]
        return self.wait(
            "an arm that has carried a part off",
            lambda now: (
                now.state.state == "assembling_placing"
                and math.dist(now.arm.tcp_pose[:2], station) > _OFF_M
            ),
        )

    def wait_mid_place(self) -> Snapshot:
        """Wait until the arm is under way with a part."""
        return self.wait(
            "an arm that moves a part",
            lambda now: now.state.state == "assembling_placing" and now.arm.tcp_speed_m_s > 0.05,
        )

    def finish(self) -> JobData:
        """Wait until the job has ended, whatever a busy machine does to the arm process."""

        def has_ended(now: Snapshot) -> bool:
            return now.job is not None and bool(now.job.outcome) and now.state.state == "idle"

        while True:
            snapshot = self.wait(
                "the end of the job", lambda now: has_ended(now) or _program_has_ended(now)
            )
            if has_ended(snapshot):
                assert snapshot.job is not None
                return snapshot.job
            self._go_on(time.monotonic() + self.patience_s)

    def truth(self) -> CellTruth:
        """The world's truth."""
        return self.world.truth()

    def states_seen(self) -> list[str]:
        """Top-level states in the order of their messages, repetitions left out."""
        states: list[str] = []
        for message in self.seen:
            top = message.state.split("_", maxsplit=1)[0]
            if message.topic == "state" and (not states or states[-1] != top):
                states.append(top)
        return states

    def assert_as_planned(self, taken: int = 0) -> None:
        """The world equals the plan, and holds nothing against the cell; the inventory is right."""
        plan = self.client.snapshot().plan
        assert plan is not None
        truth = self.truth()
        assert set(truth.built) == set(plan.assembly.cells)
        held = truth.violations[self.held_before :]
        assert not held, f"the world holds against the cell: {held}"
        assert sum(truth.counts.values()) == self.config.limits.inventory_parts
        self.assert_inventory_true(taken)

    def hand(self, move: HandMove, **details: Any) -> str:
        """Move something by an operator's hand; returns what was done."""
        return self.client.request(
            HandCommand(move=move, **details), timeout_s=self.patience_s
        ).message

    def assert_inventory_true(self, taken: int = 0) -> None:
        """The daemon's inventory is where the world's parts are; what fell counts as unknown.

        Args:
            taken: how many parts visitors took unseen, which are unknown to the cell as well.
        """
        believed = self.client.snapshot().inventory
        counts = self.truth().counts
        assert believed == {
            "stock": counts[Where.STOCK],
            "belt": counts[Where.BELT] + counts[Where.PICK_STATION],
            "gripper": counts[Where.GRIPPER],
            "structure": counts[Where.PLACED],
            "handed_over": counts[Where.HANDED_OVER] - taken,
            "scrap": 0,
            "unknown": counts[Where.FALLEN] + taken,
        }

    def bring_back(self) -> None:
        """Whatever state a test left, mend the cell, end the job and take everything out."""
        for fault in self.truth().faults:
            self.world.clear(fault)
        state = self.client.snapshot().state.state
        if state.startswith("fault"):
            if state != "fault_recovering":
                self.client.command("reset")
            state = self.wait_state("paused_resting", "fault_held", "fault_stopped").state.state
        if state != "idle":
            self.client.command("stop")
            if self.wait_state("paused_resting", "idle").state.state == "paused_resting":
                self.client.command("cancel")
                self.wait_state("paused_resting")
                self.client.command("resume")
            self.wait_state("idle")
        self.clear_workspace()

    def clear_workspace(self) -> None:
        """A person takes everything out, lays the belt full, says so, and has counted."""
        self.world.clear_workspace()
        self.client.command("clear")
        self.world.refill()
        believed = self.client.snapshot().inventory
        if believed["stock"] and believed["belt"] < self.config.feeder.capacity_parts:
            self.client.request(RefillCommand())
        self.count()

    def refill(self, parts: int | None = None) -> None:
        """A person lays parts on the belt and says so; as many as it takes without a number."""
        self.client.request(RefillCommand(parts=self.world.refill(parts)))

    def count(self) -> None:
        """A person counts all parts and tells it, if the inventory is not right."""
        counts = self.truth().counts
        found = {
            "stock": counts[Where.STOCK],
            "belt": counts[Where.BELT] + counts[Where.PICK_STATION],
            "handed_over": counts[Where.HANDED_OVER],
            "scrap": 0,
        }
        believed = self.client.snapshot().inventory
        if any(believed[place] != count for place, count in found.items()):
            self.client.request(CountCommand.model_validate(found))


def cell_config(**sections: dict[str, Any]) -> CellConfig:
    """The emulated cell's configuration with the confirmation waived, and sections changed."""
    base = load_config(CONFIG)
    # Slow windows keep a busy machine from stopping the arm, and from losing a board that had no
    # time to answer; what the watchdog does is proven with the arm process alone.
    slow: dict[str, dict[str, Any]] = {
        "robot": {"watchdog_hz": 5.0},
        "feeder": {"reply_timeout_s": 0.6},
        "gripper": {"reply_timeout_s": 0.6},
        # A question waits for whoever needs seconds of wall time to start a command.
        "policy": {"confirmation": "waived", "confirmation_timeout_s": 3000.0},
    }
    changed: dict[str, dict[str, Any]] = {
        **{name: {**values, **sections.pop(name, {})} for name, values in slow.items()},
        **sections,
    }
    updates = {
        name: getattr(base, name).model_copy(update=values) for name, values in changed.items()
    }
    return CellConfig.model_validate(base.model_copy(update=updates).model_dump(exclude_none=True))


@contextmanager
def running_cell(
    speed: float = 10.0, patience_s: float = PATIENCE_S, **sections: dict[str, Any]
) -> Iterator[RunningCell]:
    """An emulated cell and a daemon, idle, with the confirmation waived.

    Args:
        speed: cell seconds per wall second.
        patience_s: how long to wait for anything (wall time).
        sections: settings to change, by section: ``robot={"model": "ur10"}``.
    """
    config = cell_config(**sections)
    with tempfile.TemporaryDirectory(prefix="cellctl-") as name:
        own = isolated(config, Path(name), speed)
        with (
            emulated_cell(own, speed) as world,
            watched_daemon(own, Path(name), world, patience_s) as cell,
        ):
            wait_idle(cell.client, cell.daemon)
            yield cell


@contextmanager
def watched_daemon(
    config: CellConfig, folder: Path, world: SimClient, patience_s: float = PATIENCE_S
) -> Iterator[RunningCell]:
    """A daemon that has just begun to start, for an emulated cell that runs already."""
    reply_s = patience_s / 9
    with (
        running_daemon(config, folder) as daemon,
        CellClient.for_role(config, timeout_s=reply_s) as client,
        CellClient.for_role(config, Role.VISITOR, timeout_s=reply_s) as visitor,
    ):
        client.subscribe()
        try:
            yield RunningCell(config, world, client, visitor, daemon, patience_s=patience_s)
        except BaseException:
            print(daemon.log_tail(6000))  # noqa: T201 - pytest shows it
            raise


def bar(nx: int, ny: int, nz: int) -> bytes:
    """A box of so many voxels, as a file of cells."""
    cells = [(x, y, z) for x in range(nx) for y in range(ny) for z in range(nz)]
    return Assembly.of(cells, pitch_m=0.1).model_dump_json().encode()
