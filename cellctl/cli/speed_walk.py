"""Trials of speed: an object is built at one pace after another, and taken apart in between.

The daemon does it, job by job, each in its journal; this is the order in which it is asked. What
the gripper does not feel standing counts as failed, and a person then takes away what fell.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from datetime import datetime
from statistics import fmean
from typing import NamedTuple, Protocol

from cellctl.assembly import Assembly, Pace
from cellctl.client import CellClient
from cellctl.config.rewriting import NewValues
from cellctl.errors import CellctlError, PlanError, RefusedError
from cellctl.messages import BuildCommand, CalibratedCommand, CountCommand, Outcome, Snapshot

PAPERS: tuple[Pace, ...] = tuple(
    Pace(speed_m_s=speed_m_s, acceleration_m_s2=speed_m_s / ratio)
    for ratio in (1.0, 2.0)
    for speed_m_s in (1.0, 1.5, 2.0, 2.5)
)
"""The paper's table: velocity to acceleration 1:1, then 2:1, each with the slow ones first."""

_SILENCE_S = 15.0
"""A daemon sends a heartbeat each second; this long without one, it is gone (wall time)."""
_FELL = "part_fell"
_WAITS = ("paused_resting", "feeding_refilling")
"""States in which somebody has to do something before a trial goes on."""


class Guide(Protocol):
    """Whoever stands at the cell."""

    def tell(self, text: str) -> None:
        """Show a line."""
        ...

    def removed(self, what: str) -> bool:
        """Have somebody take away what fell and lay it with the stock; False ends the trials."""
        ...


class Attempts(NamedTuple):
    """What came of the trials at one pace."""

    pace: Pace
    tried: int
    stood: int
    """In how many of them every part stood."""
    told_s: float
    """Cell time a part takes at that pace, as it was told in advance; 0 where nothing stood."""
    refused: str = ""
    """Why it was not tried."""

    def __str__(self) -> str:
        if self.refused:
            return f"{self.pace}: not tried. {self.refused}"
        told = f", {self.told_s:.2f} s a part" if self.stood else ""
        return f"{self.pace}: {self.stood} of {self.tried} stood{told}"


class SpeedWalk:
    """Tries paces in one cell, which must be idle and empty.

    Args:
        cell: the operator's client.
        guide: who stands at the cell.
        name: of the object's file.
        content: of that file.
        times: how often each pace is tried.
    """

    def __init__(
        self, cell: CellClient, guide: Guide, *, name: str, content: bytes, times: int = 1
    ) -> None:
        self._cell = cell
        self._guide = guide
        self._name = name
        self._content = content
        self._times = times

    def run(self, paces: Iterable[Pace]) -> list[Attempts]:
        """One pace after the other; each result is written into the cell's journal at once.

        Raises:
            RefusedError: the cell is not idle and empty, or somebody or a fault ended a trial.
        """
        self._cell.subscribe()
        self._begin()
        found = []
        for pace in paces:
            self._guide.tell(f"Trying {pace}.")
            found.append(self._attempts(pace))
            self._guide.tell(f"   {found[-1]}")
            note = f"{self._name} at {found[-1]}"
            self._cell.request(CalibratedCommand(what="speed", note=note[:1000]))
        return found

    def _begin(self) -> Snapshot:
        snapshot = self._cell.snapshot()
        if snapshot.state.state != "idle" or snapshot.standing:
            raise RefusedError(
                "Trials begin in an idle cell in which nothing stands.",
                "See `cellctl status`; `cellctl take-apart` takes apart what stands.",
            )
        return snapshot

    def _attempts(self, pace: Pace) -> Attempts:
        told: list[float] = []
        for _ in range(self._times):
            try:
                told_s = self._once(pace)
            except PlanError as error:
                return Attempts(pace, 0, 0, 0.0, str(error))
            if told_s is not None:
                told.append(told_s)
        return Attempts(pace, self._times, len(told), fmean(told) if told else 0.0)

    def _once(self, pace: Pace) -> float | None:
        """Build it and take it apart; seconds a part as they were told, or None where one did not
        stand.

        Raises:
            PlanError: it cannot be built at that pace.
            RefusedError: it was not carried through.
        """
        before = self._begin()
        reply = self._cell.request(BuildCommand(name=self._name, pace=pace), self._content)
        snapshot = self._end_of(reply.job_id)
        fault = snapshot.fault.entry
        if fault is not None and fault.code == _FELL:
            self._mend(snapshot, before.inventory["unknown"])
            return None
        if _outcome(snapshot) == "cannot_plan":
            assert snapshot.job is not None, "it has an outcome"
            raise PlanError(snapshot.job.message)
        self._expect(snapshot, "built")
        self._take_apart()
        # What a trial took in all depends on the belt as well, and on how busy the computer is.
        return fmean(part.predicted_s or part.seconds for part in snapshot.parts)

    def _take_apart(self) -> None:
        reply = self._cell.command("take_apart")
        self._expect(self._end_of(reply.job_id), "taken_apart")

    def _expect(self, snapshot: Snapshot, outcome: Outcome) -> None:
        """Raises RefusedError where a job did not end so."""
        if _outcome(snapshot) != outcome or snapshot.fault.entry is not None:
            raise RefusedError(
                f"A trial was not carried through. {snapshot.state.sentence}".strip(),
                "See to that first; what was found before stands in the journal. The trials that "
                "are left go on with --pace.",
            )

    def _end_of(self, job_id: str) -> Snapshot:
        """The cell when a job has ended or is in a fault; a question is answered with yes.

        Raises:
            RefusedError: another job has taken its place.
            CellctlError: the daemon fell silent.
        """
        asked, told = False, ""
        while True:
            snapshot = self._cell.snapshot()
            state, job = snapshot.state.state, snapshot.job
            if snapshot.fault.entry is not None and state.startswith("fault_"):
                return snapshot
            if job is None or job.job_id != job_id:
                raise RefusedError("Another job has begun.", "End it, and begin the trials anew.")
            if job.outcome and state in {"idle", "paused_resting"}:
                return snapshot
            if state == "validating_confirming" and not asked:
                asked = True
                self._cell.confirm(True)
            if state in _WAITS and state != told:
                self._guide.tell(f"   The cell waits for you. {snapshot.state.sentence}")
            told = state
            self._listen()

    def _mend(self, snapshot: Snapshot, unknown_before: int) -> None:
        """See to what fell, and take apart what stands.

        Raises:
            RefusedError: nobody does; the fault stays.
        """
        if not self._guide.removed(f"It does not stand. {snapshot.fault.detail}"):
            raise RefusedError(
                "What fell lies there still.", "Leave the fault as `cellctl status` says."
            )
        counts = self._cell.snapshot().inventory
        fell = counts["unknown"] - unknown_before
        stock = counts["stock"] + fell
        self._cell.request(CountCommand(stock=stock, note="fell in a trial of speed"))
        self._cell.command("reset")
        self._wait(lambda now: now.state.state == "paused_resting")
        self._cell.command("cancel")
        self._wait(lambda now: bool(_outcome(now)) and now.state.state == "paused_resting")
        self._cell.command("resume")
        if self._wait(lambda now: now.state.state == "idle").standing:
            self._take_apart()

    def _wait(self, holds: Callable[[Snapshot], bool]) -> Snapshot:
        while not holds(snapshot := self._cell.snapshot()):
            if snapshot.fault.entry is not None and snapshot.state.state != "fault_recovering":
                self._expect(snapshot, "built")
            self._listen()
        return snapshot

    def _listen(self) -> None:
        """Wait for the next status message."""
        if next(self._cell.messages(_SILENCE_S), None) is None:
            raise CellctlError("The daemon has fallen silent.", "Look at its log.")


def best(found: Sequence[Attempts]) -> Attempts | None:
    """The quickest pace at which everything stood every time; None where there is none."""
    good = [one for one in found if one.tried and one.stood == one.tried]
    return min(good, key=lambda one: one.told_s, default=None)


def values_of(chosen: Attempts, name: str) -> NewValues:
    """What the configuration says then: the limit for carrying a part, and what it rests on."""
    on = f"{datetime.now().astimezone():%Y-%m-%d}"
    measured = f"{on}: {name}, {chosen.stood} of {chosen.tried} stood at {chosen.pace}"
    return {
        ("robot", "carrying_speed_m_s"): chosen.pace.speed_m_s,
        ("robot", "carrying_acceleration_m_s2"): chosen.pace.acceleration_m_s2,
        ("robot", "carrying_measured"): measured.replace("#", " "),
    }


def column(pitch_m: float, height: int = 2) -> bytes:
    """A column of parts, as a file of cells."""
    cells = [(0, 0, z) for z in range(height)]
    return Assembly.of(cells, pitch_m=pitch_m).model_dump_json().encode()


def _outcome(snapshot: Snapshot) -> Outcome:
    return snapshot.job.outcome if snapshot.job is not None else ""
