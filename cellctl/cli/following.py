"""Follow one job on the status stream, and show how it goes."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from cellctl.assembly import PartOutcome
from cellctl.cli.replies import state_words
from cellctl.client import CellClient
from cellctl.errors import CellctlError, ExitStatus
from cellctl.messages import (
    FaultData,
    GripperData,
    HealthData,
    JobData,
    PartData,
    SpeechData,
    StateData,
    StatusMessage,
)

_SILENCE_S = 15.0
"""A daemon sends a heartbeat each second; this long without one, it is gone (wall time)."""

OUTCOME_STATUS = {
    "built": ExitStatus.DONE,
    "taken_apart": ExitStatus.DONE,
    "cancelled": ExitStatus.DIFFERS,
    "declined": ExitStatus.DIFFERS,
    "unreadable": ExitStatus.USAGE,
    "no_object": ExitStatus.NO_OBJECT,
    "cannot_plan": ExitStatus.CANNOT_PLAN,
    "failed": ExitStatus.INTERNAL,
}


_BUSY = frozenset({"feeding", "assembling", "disassembling"})


class Follower:
    """Turns status messages into lines and a bar.

    Args:
        console: where to write.
        progress: the bar; it shows only on a terminal.
    """

    def __init__(self, console: Console, progress: Progress) -> None:
        self._console = console
        self._progress = progress
        self._bar = progress.add_task("", total=None, visible=False)
        self._said = ""
        self._noticed = ""

    def show(self, message: StatusMessage) -> None:
        """Show what is worth showing of one message."""
        data = message.payload()
        match data:
            case StateData():
                self._state(data)
            case SpeechData():
                self._speech(data)
            case PartData():
                self._part(data)
            case FaultData() if data.entry is not None:
                self._console.print(f"[bold red]fault[/] {data.entry.code}: {data.entry.title}")
                if data.detail:
                    self._console.print(f"      {data.detail}")
                self._console.print(f"      what to do: {data.entry.remedy}")
            case GripperData():
                self._gripper(data)
            case _:
                return

    def _gripper(self, data: GripperData) -> None:
        code = data.notice.code if data.notice is not None else ""
        if data.notice is not None and code != self._noticed:
            self._console.print(f"[yellow]{data.notice.title}[/] {data.notice.remedy}")
        self._noticed = code

    def _state(self, data: StateData) -> None:
        top = data.state.split("_", maxsplit=1)[0]
        if top in _BUSY:
            self._progress.update(self._bar, description=state_words(data.state))
            if self._said in _BUSY:
                return
        self._said = top
        self._console.print(f"[cyan]{state_words(data.state):<26}[/] {data.sentence}")

    def _speech(self, data: SpeechData) -> None:
        if data.request is None:
            words = data.utterance.text or "nothing"
            self._console.print(f"[green]{'heard':<26}[/] {words!r} by {data.utterance.recogniser}")
        else:
            self._console.print(f"[green]{'understood':<26}[/] {data.request.phrase}")
            if changed := data.request.corrections:
                told = ", ".join(f"{each.heard!r} as {each.taken!r}" for each in changed)
                self._console.print(f"[green]{'taken':<26}[/] {told}")
            if data.request.cloud:
                self._console.print(
                    f"[yellow]{'your words were sent to':<26}[/] {data.request.cloud}, "
                    "to be understood"
                )

    def _part(self, data: PartData) -> None:
        self._progress.update(self._bar, total=data.total, completed=data.placed, visible=True)
        if not self._console.is_terminal:
            x, y, z = data.outcome.cell
            self._console.print(
                f"part {data.placed:>3} of {data.total}: [{x}, {y}, {z}] "
                f"in {data.outcome.seconds:.1f} s{_told(data.outcome)}",
                markup=False,
            )


def _told(outcome: PartOutcome) -> str:
    """What was told for it, and what the arm waited for beyond that."""
    told = f" (told {outcome.predicted_s:.1f})" if outcome.predicted_s is not None else ""
    waited = f", {outcome.waited_s:.1f} s of them for the belt" if outcome.waited_s > 0.05 else ""
    return told + waited


@contextmanager
def follower(console: Console) -> Iterator[Follower]:
    """A follower whose bar lives as long as the context."""
    progress = Progress(
        TextColumn("{task.description:<26}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("parts"),
        TimeElapsedColumn(),
        console=console,
        transient=True,
    )
    with progress:
        yield Follower(console, progress)


def await_question(cell: CellClient, job_id: str, console: Console | None = None) -> ExitStatus:
    """Show what becomes of a wish until the cell asks, begins to build, or will not.

    Args:
        cell: subscribed before the wish was given.
        job_id: as the reply to the request named it.

    Raises:
        CellctlError: the daemon fell silent.
    """
    console = console or Console(highlight=False)
    for message in cell.messages(_SILENCE_S):
        data = message.payload()
        if isinstance(data, StateData | HealthData):
            snapshot = cell.snapshot()
            job, state = snapshot.job, snapshot.state
            if job is None or job.job_id != job_id:
                return ExitStatus.DONE
            if job.outcome:
                console.print(job.message, markup=False)
                return OUTCOME_STATUS[job.outcome]
            if snapshot.fault.entry is not None:
                console.print(state.sentence, markup=False)
                return ExitStatus.FAULT
            if state.state == "validating_confirming" or job.phase == "building":
                console.print(state.sentence, markup=False)
                return ExitStatus.DONE
    raise CellctlError("The daemon has fallen silent.", "Look at its log.")


def follow_job(
    cell: CellClient, job_id: str, console: Console | None = None, timeout_s: float = 3600.0
) -> ExitStatus:
    """Show a job until it has ended or the cell is in a fault.

    Args:
        cell: subscribed before the job began.
        job_id: as the reply to the request named it.
        timeout_s: wall time.

    Raises:
        CellctlError: the daemon fell silent, or the job took too long.
    """
    deadline_s = time.monotonic() + timeout_s
    with follower(console or Console(highlight=False)) as view:
        for message in cell.messages(_SILENCE_S):
            view.show(message)
            data = message.payload()
            if isinstance(data, FaultData) and data.entry is not None:
                return ExitStatus.FAULT
            if isinstance(data, JobData) and data.job_id == job_id and data.outcome:
                return OUTCOME_STATUS[data.outcome]
            if isinstance(data, HealthData):
                # The end may have come before the subscription did.
                job = cell.snapshot().job
                if job is not None and job.job_id == job_id and job.outcome:
                    return OUTCOME_STATUS[job.outcome]
            if time.monotonic() > deadline_s:
                raise CellctlError(f"The job did not end within {timeout_s:g} s.")
    raise CellctlError("The daemon has fallen silent.", "Look at its log.")
