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
from cellctl.messages import (
    ArmData,
    BuildCommand,
    CalibratedCommand,
    CountCommand,
    JobData,
    Outcome,
    Snapshot,
)

PAPERS: tuple[Pace, ...] = tuple(
    Pace(speed_m_s=speed_m_s, acceleration_m_s2=speed_m_s / ratio)
    for ratio in (1.0, 2.0)
    for speed_m_s in (1.0, 1.5, 2.0, 2.5)
)
"""The paper's table: velocity to acceleration 1:1, then 2:1, each with the slow ones first."""

_SILENCE_S = 15.0
"""A daemon sends a heartbeat each second; this long without one, it is gone (wall time)."""
_FULL_FRACTION = 0.99
"""With the speed slider below this an arm goes slower than it is told."""
_MEASURED_LENGTH = 200
"""What the configuration takes as ``robot.carrying_measured``."""
_FELL = "part_fell"
_WAITS = ("paused_resting", "feeding_refilling")
"""States in which somebody has to do something before a trial goes on."""


class Guide(Protocol):
    """Whoever stands at the cell."""

    def tell(self, text: str) -> None:
        """Show a line."""
        ...

    def agreed(self, question: str) -> bool:
        """Ask whether something is to be done; False ends the trials."""
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
        self._since = 0
        """Number of the last status message before the trial under way."""
        self._slowest = 1.0
        """The least that the speed slider was at since then."""

    def run(self, paces: Iterable[Pace]) -> list[Attempts]:
        """One pace after the other; each result is written into the cell's journal at once.

        Raises:
            RefusedError: the cell is not idle and empty, the speed slider is not at full speed, or
                somebody or a fault ended a trial.
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
        need_ready(snapshot)
        self._since, self._slowest = snapshot.seq, 1.0
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
            RefusedError: it was not carried through, or tells nothing of that pace.
        """
        before = self._begin()
        reply = self._cell.request(BuildCommand(name=self._name, pace=pace), self._content)
        snapshot = self._end_of(reply.job_id)
        slowest, fault = self._slowest, snapshot.fault.entry
        if fault is not None and fault.code == _FELL:
            self._mend(snapshot, before.inventory["unknown"])
            need_full_speed(slowest)
            return None
        if _outcome(snapshot) == "cannot_plan":
            assert snapshot.job is not None, "it has an outcome"
            raise PlanError(snapshot.job.message)
        self._expect(snapshot, "built")
        need_full_speed(slowest)
        told_s = told_a_part(snapshot)
        self._take_apart()
        return told_s

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
        """The cell when a job has ended or is in a fault.

        Raises:
            RefusedError: another job has taken its place.
            CellctlError: the daemon fell silent.
        """
        answered, told = "", ""
        while True:
            snapshot = self._cell.snapshot()
            self._saw(snapshot.arm)
            state, job = snapshot.state.state, snapshot.job
            if snapshot.fault.entry is not None and state.startswith("fault_"):
                return snapshot
            if job is None or job.job_id != job_id:
                raise RefusedError("Another job has begun.", "End it, and begin the trials anew.")
            if job.outcome and state in {"idle", "paused_resting"}:
                return snapshot
            asked = snapshot.dialogue.asked
            if state == "validating_confirming" and asked not in {"", answered}:
                self._answer(snapshot)
                answered = asked
            if state in _WAITS and state != told:
                self._guide.tell(f"   The cell waits for you. {snapshot.state.sentence}")
            told = state
            self._listen()

    def _answer(self, snapshot: Snapshot) -> None:
        """Say yes where nothing is in question; else whoever stands at the cell decides."""
        assert snapshot.job is not None, "it asks"
        remarks = remarks_on(snapshot.job)
        for remark in remarks:
            self._guide.tell(f"   {remark}")
        yes = not remarks or self._guide.agreed("Build it all the same?")
        self._cell.confirm(yes, snapshot.dialogue.asked)

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
        message = next(self._cell.messages(_SILENCE_S), None)
        if message is None:
            raise CellctlError("The daemon has fallen silent.", "Look at its log.")
        data = message.payload()
        if isinstance(data, ArmData) and message.seq > self._since:
            self._saw(data)

    def _saw(self, arm: ArmData) -> None:
        self._slowest = min(self._slowest, arm.speed_fraction)


def remarks_on(job: JobData) -> list[str]:
    """What a person should know before a yes: what was changed, and what is in question."""
    return [*(f"{change.what} {change.why}" for change in job.changes), *job.questions]


def need_ready(snapshot: Snapshot) -> None:
    """See that a trial may begin.

    Raises:
        RefusedError: the cell is not idle and empty, or would go slower than it is told.
    """
    if snapshot.state.state != "idle" or snapshot.standing:
        raise RefusedError(
            "Trials begin in an idle cell in which nothing stands.",
            "See `cellctl status`; `cellctl take-apart` takes apart what stands.",
        )
    fraction = snapshot.arm.speed_fraction
    if fraction < _FULL_FRACTION:
        raise RefusedError(
            f"The speed slider is at {fraction:.0%}: the arm would go slower than it is told.",
            "Move it to 100 % on the pendant, and begin the trials anew.",
        )


def need_full_speed(slowest_fraction: float) -> None:
    """See that the arm went as fast as it was told.

    Args:
        slowest_fraction: the least that the speed slider was at while it built.

    Raises:
        RefusedError: it went slower.
    """
    if slowest_fraction < _FULL_FRACTION:
        raise RefusedError(
            f"The trial tells nothing: the speed slider was at {slowest_fraction:.0%}, and the arm "
            "went slower than it was told.",
            "Move it to 100 % on the pendant; `cellctl take-apart` takes apart what stands. The "
            "trials that are left go on with --pace.",
        )


def told_a_part(snapshot: Snapshot) -> float:
    """Cell time that a part of a finished trial takes, as it was told in advance. What it took in
    all depends on the belt as well, and on how busy the computer is.

    Raises:
        RefusedError: not every part was felt.
    """
    total = snapshot.job.parts_total if snapshot.job is not None else 0
    if not total or len(snapshot.parts) != total:
        raise RefusedError(
            "The trial tells nothing: it was interrupted before every part was felt "
            f"({len(snapshot.parts)} of {total}).",
            "See whether everything stands; `cellctl take-apart` takes it apart. The trials that "
            "are left go on with --pace.",
        )
    return fmean(part.predicted_s or part.seconds for part in snapshot.parts)


def beyond(paces: Iterable[Pace], limit: Pace) -> list[Pace]:
    """The paces that exceed a limit, in speed or in acceleration."""
    return [pace for pace in paces if not _at_most(pace, limit)]


def best(found: Sequence[Attempts]) -> Attempts | None:
    """The quickest pace at which everything stood every time; None where there is none.

    Where something fell, no pace counts that is at least as fast in both speed and acceleration:
    that it stood there was luck.
    """
    failed = [one.pace for one in found if one.stood < one.tried]
    good = [
        one
        for one in found
        if one.tried
        and one.stood == one.tried
        and not any(_at_most(pace, one.pace) for pace in failed)
    ]
    return min(good, key=lambda one: one.told_s, default=None)


def _at_most(pace: Pace, limit: Pace) -> bool:
    return pace.speed_m_s <= limit.speed_m_s and pace.acceleration_m_s2 <= limit.acceleration_m_s2


def values_of(chosen: Attempts, name: str) -> NewValues:
    """What the configuration says then: the limit for carrying a part, and what it rests on."""
    on = f"{datetime.now().astimezone():%Y-%m-%d}"
    came = f", {chosen.stood} of {chosen.tried} stood at {chosen.pace}"
    room = _MEASURED_LENGTH - len(f"{on}: {came}")
    measured = f"{on}: {name[:room]}{came}"
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
