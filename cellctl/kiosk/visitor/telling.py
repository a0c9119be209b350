"""What the visitor's view says, from what is known of the cell: a pure function."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cellctl.assembly import Change, StepKind
from cellctl.messages import JobData, Snapshot, SpeechData

Phase = Literal[
    "never",
    "starting",
    "idle",
    "hearing",
    "thinking",
    "asking",
    "building",
    "apart",
    "done",
    "paused",
    "fault",
]

_OF_TOP: dict[str, Phase] = {
    "starting": "starting",
    "listening": "hearing",
    "generating": "thinking",
    "validating": "thinking",
    "feeding": "building",
    "assembling": "building",
    "disassembling": "apart",
    "paused": "paused",
    "fault": "fault",
}


@dataclass(frozen=True)
class Telling:
    """Everything in words and numbers that the view shows."""

    phase: Phase
    sentence: str = ""
    heard: str = ""
    understood: str = ""
    changes: tuple[Change, ...] = ()
    title: str = ""
    placed: int = 0
    total: int = 0
    left_s: float | None = None
    """How long the rest will take, as far as the plan tells (cell time)."""
    predicted_s: float | None = None
    takes_apart: bool = False
    standing: bool = False
    """Whether something stands in the workspace."""
    moving: bool = False
    """Whether the arm may move, so that *stop* counts."""


def telling(snapshot: Snapshot | None, speech: SpeechData | None) -> Telling:
    """What to tell.

    Args:
        snapshot: the cell; None when it was never heard of.
        speech: what was heard last.
    """
    if snapshot is None:
        return Telling("never")
    state, job = snapshot.state.state, snapshot.job
    phase = _phase(snapshot)
    steps = snapshot.plan.steps if snapshot.plan is not None else ()
    takes_apart = bool(steps) and all(step.kind is StepKind.REMOVE for step in steps)
    placed = job.parts_placed if job is not None else 0
    left = [step.duration_s for step in steps[placed:]]
    heard = _heard(job, speech) if phase != "idle" else ""
    sentence = snapshot.state.sentence
    if snapshot.fault.entry is not None:
        sentence = snapshot.fault.entry.title
    return Telling(
        phase=phase,
        sentence=sentence,
        heard=heard,
        understood=_understood(job) if phase != "idle" else "",
        changes=job.changes if job is not None and phase in {"asking", "building", "done"} else (),
        title=snapshot.plan.title if snapshot.plan is not None else "",
        placed=placed,
        total=job.parts_total if job is not None else 0,
        left_s=sum(s for s in left if s is not None) if left and None not in left else None,
        predicted_s=job.predicted_s if job is not None else None,
        takes_apart=takes_apart,
        standing=bool(snapshot.standing),
        moving=state.split("_", maxsplit=1)[0] in {"feeding", "assembling", "disassembling"}
        or state in {"paused_braking", "paused_moving"},
    )


def _phase(snapshot: Snapshot) -> Phase:
    state, job = snapshot.state.state, snapshot.job
    if state == "validating_confirming":
        return "asking"
    if state == "listening_interpreting":
        return "thinking"
    if state != "idle":
        return _OF_TOP.get(state.split("_", maxsplit=1)[0], "starting")
    if snapshot.ears.state == "recording":
        return "hearing"
    ended_well = job is not None and job.outcome == "built"
    return "done" if ended_well and snapshot.standing else "idle"


def _heard(job: JobData | None, speech: SpeechData | None) -> str:
    if job is not None and job.utterance is not None:
        return job.utterance.text
    return speech.utterance.text if speech is not None else ""


def _understood(job: JobData | None) -> str:
    if job is None or job.request is None or job.request.phrase == "false":
        return ""
    return job.request.phrase
