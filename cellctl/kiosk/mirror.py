"""What the page knows of the cell: the last snapshot, and every message since.

A ``Mirror`` lives in the page's event loop and does no I/O. What it shows may be old: it says how
old. Whoever watches it is called once for many changes that come close together.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable
from typing import Final, Literal

import structlog

from cellctl.assembly import PartOutcome, StepKind
from cellctl.messages import (
    ArmData,
    ConveyorData,
    DialogueData,
    EarsData,
    FaultData,
    GripperData,
    HealthData,
    JobData,
    LogData,
    PartData,
    Snapshot,
    SpeechData,
    StateData,
    StatusMessage,
    VoiceData,
)

log = structlog.get_logger(__name__)

_TOGETHER_S: Final = 0.04
"""Changes that come within this time are shown at once (wall time)."""
_LOGS: Final = 200
"""Warnings and errors that are kept for the operator's view."""

_FIELDS: Final[dict[type, str]] = {
    StateData: "state",
    JobData: "job",
    ArmData: "arm",
    ConveyorData: "conveyor",
    GripperData: "gripper",
    FaultData: "fault",
    EarsData: "ears",
    VoiceData: "voice",
    DialogueData: "dialogue",
    HealthData: "health",
}
"""Messages that take the place of one part of the snapshot."""

Place = Literal["next", "known", "gap"]


class Sequence:
    """Where a message stands in one daemon's numbers."""

    def __init__(self) -> None:
        self._included = 0
        self._received = 0

    def snapshot(self, seq: int) -> None:
        """A snapshot includes every message up to ``seq``."""
        self._included = seq
        self._received = min(self._received, seq)

    def place(self, seq: int) -> Place:
        """``known``: a snapshot has it already; ``gap``: messages before it were lost, or another
        daemon has begun to count, so that a snapshot is needed first."""
        before, self._received = self._received, seq
        if seq <= before:
            return "gap"
        if seq <= self._included:
            return "known"
        return "next" if seq == max(before, self._included) + 1 else "gap"


class Mirror:
    """The cell as it was last heard of.

    Args:
        patience_s: silence that is longer makes what is shown stale (wall time).
        now: seconds of a clock that never goes back.
    """

    def __init__(self, patience_s: float, now: Callable[[], float] = time.monotonic) -> None:
        self._patience_s = patience_s
        self._now = now
        self._heard_s: float | None = None
        self._watchers: list[Callable[[], None]] = []
        self._due: asyncio.TimerHandle | None = None
        self.snapshot: Snapshot | None = None
        """None until the cell was first heard."""
        self.speech: SpeechData | None = None
        """What was heard last."""
        self.logs: deque[tuple[str, LogData]] = deque(maxlen=_LOGS)
        """When (hours, minutes and seconds of the local time), and what; the newest last."""

    @property
    def age_s(self) -> float:
        """How long the cell has been silent (wall time); infinite before it was first heard."""
        return self._now() - self._heard_s if self._heard_s is not None else float("inf")

    @property
    def stale(self) -> bool:
        """Whether what is shown may no longer be so."""
        return self.age_s > self._patience_s

    def watch(self, changed: Callable[[], None]) -> Callable[[], None]:
        """Have ``changed`` called after every change, and once a second; returns how to end it."""
        self._watchers.append(changed)
        return lambda: self._watchers.remove(changed) if changed in self._watchers else None

    def take_snapshot(self, snapshot: Snapshot) -> None:
        """The whole picture."""
        self._heard_s = self._now()
        self.snapshot = snapshot
        self._changed()

    def take(self, message: StatusMessage) -> None:
        """One message, in its order."""
        self._heard_s = self._now()
        before = self.snapshot
        if before is None:
            return
        data = message.payload()
        change: dict[str, object] = {}
        if (name := _FIELDS.get(type(data))) is not None:
            change[name] = data
        elif isinstance(data, PartData):
            change = _after_part(before, data.outcome)
        elif isinstance(data, SpeechData):
            self.speech = data
        elif isinstance(data, LogData):
            self.logs.append((f"{message.time.astimezone():%H:%M:%S}", data))
        self.snapshot = before.model_copy(update=change)
        self._changed()

    def tick(self) -> None:
        """A second has passed: ages have changed."""
        self._changed()

    def _changed(self) -> None:
        if self._due is None:
            self._due = asyncio.get_running_loop().call_later(_TOGETHER_S, self._tell)

    def _tell(self) -> None:
        self._due = None
        for changed in list(self._watchers):
            try:
                changed()
            except Exception:
                # One page that cannot show it must not keep it from the others.
                log.exception("a page cannot show this")


def _after_part(before: Snapshot, outcome: PartOutcome) -> dict[str, object]:
    """What a part that was placed or taken off changes."""
    standing = set(before.standing)
    if outcome.kind is StepKind.PLACE:
        standing.add(outcome.cell)
    else:
        standing.discard(outcome.cell)
    return {"standing": tuple(sorted(standing)), "parts": (*before.parts, outcome)}
