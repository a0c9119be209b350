"""What the visitor's view says, from what is known of the cell: a pure function."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from cellctl.assembly import Change
from cellctl.messages import DialogueData, Offer, Question, QueueEntry, Snapshot

Phase = Literal[
    "never",
    "starting",
    "ready",
    "done",
    "hearing",
    "thinking",
    "asking",
    "building",
    "taking_apart",
    "waiting",
    "fault",
]
"""Those of the topic ``dialogue``, and ``never``: the cell was not heard of yet; ``hearing``: what
is said now is a request; ``done``: an object is finished and stands."""


Need = Literal["", "parts", "look", "help"]
"""What people have to do before the cell goes on: lay parts on the belt, look after a cell that was
stopped, or see to a fault."""
_AT_WORK = frozenset({"building", "taking_apart", "waiting", "fault"})
"""Phases in which the view is about a job that has begun."""
_AT_REST = frozenset({"ready", "done"})
"""Phases in which the wish before is of no interest any more."""


@dataclass(frozen=True)
class Telling:
    """Everything in words and numbers that the view shows."""

    phase: Phase
    sentence: str = ""
    """What the cell says, in its own language."""
    language: str = "en"
    """Of the sentence."""
    speaking: bool = False
    question: Question = ""
    asked: str = ""
    """Name of the question that is open, which an answer carries."""
    deadline: datetime | None = None
    offers: tuple[Offer, ...] = ()
    need: Need = ""
    heard: str = ""
    understood: str = ""
    changes: tuple[Change, ...] = ()
    title: str = ""
    placed: int = 0
    total: int = 0
    left_s: float | None = None
    """How long the rest will take, as far as the plan tells (cell time)."""
    queue: tuple[QueueEntry, ...] = ()
    job_id: str = ""


def telling(snapshot: Snapshot | None) -> Telling:
    """What to tell.

    Args:
        snapshot: the cell; None when it was never heard of.
    """
    if snapshot is None:
        return Telling("never")
    talk, job, plan = snapshot.dialogue, snapshot.job, snapshot.plan
    phase = _phase(snapshot)
    placed = job.parts_placed if job is not None else 0
    left = [step.duration_s for step in plan.steps[placed:]] if plan is not None else []
    sentence, language = _sentence(snapshot)
    heard, understood = _said(snapshot, phase)
    about_it = phase == "building" or (phase == "asking" and talk.question == "build")
    return Telling(
        phase=phase,
        sentence=sentence,
        language=language,
        speaking=talk.speaking,
        question=talk.question,
        asked=talk.asked,
        deadline=talk.deadline,
        offers=talk.offers,
        need=_need(snapshot),
        heard=heard,
        understood=understood,
        changes=job.changes if job is not None and about_it else (),
        title=plan.title if plan is not None else "",
        placed=placed,
        total=job.parts_total if job is not None else 0,
        left_s=sum(s for s in left if s is not None) if left and None not in left else None,
        queue=talk.queue,
        job_id=job.job_id if job is not None else "",
    )


def beside(sentence: str, headline: str, changes: tuple[Change, ...]) -> str:
    """What is left to say of a sentence on a screen where its question is the headline, and where
    what was changed has a list of its own."""
    rest = sentence.removesuffix(headline)
    for change in changes:
        rest = rest.replace(f" {change.what}", "")
    return rest.strip()


def in_other_words(heard: str, understood: str) -> bool:
    """Whether what was understood has other words than what was heard ends with."""
    return not _letters(heard).endswith(_letters(understood))


def _letters(text: str) -> str:
    return "".join(letter for letter in text.casefold() if letter.isalnum())


def _phase(snapshot: Snapshot) -> Phase:
    talk, job = snapshot.dialogue, snapshot.job
    if snapshot.ears.state == "recording" and talk.phase in {"ready", "asking"}:
        return "hearing" if talk.phase == "ready" else "asking"
    if snapshot.state.state in {"listening_waiting", "listening_hearing"}:
        return "hearing"
    if talk.phase == "ready" and snapshot.standing and job is not None and job.outcome == "built":
        return "done"
    return talk.phase


def _said(snapshot: Snapshot, phase: Phase) -> tuple[str, str]:
    """What was heard and understood of what the view is about."""
    talk, job = snapshot.dialogue, snapshot.job
    if phase in _AT_REST or phase == "taking_apart":
        return "", ""
    if phase not in _AT_WORK or job is None:
        return talk.heard, talk.understood
    # Others may have said something meanwhile, which waits for its turn.
    heard = job.utterance.text if job.utterance is not None else ""
    return heard, job.title[:1].upper() + job.title[1:]


def _need(snapshot: Snapshot) -> Need:
    state = snapshot.state.state
    if snapshot.dialogue.phase == "fault":
        return "help"
    if state == "feeding_refilling":
        return "parts"
    # While it brakes, or an operator moves it, only its own sentence is true.
    return "look" if state == "paused_resting" else ""


def _sentence(snapshot: Snapshot) -> tuple[str, str]:
    """What the cell says, and in which language: what it does now, unless it waits for words."""
    talk = snapshot.dialogue
    if _waits_for_words(talk) and talk.line is not None:
        return talk.line.text, talk.line.language
    if talk.waits is not None:
        return talk.waits.text, talk.waits.language
    language = talk.line.language if talk.line is not None else "en"
    return snapshot.state.sentence, language


def _waits_for_words(talk: DialogueData) -> bool:
    return talk.phase in {"ready", "asking"}
