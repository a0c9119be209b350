"""One wish on its way through the cell, and how far it has come."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

from cellctl.assembly import BuildPlan, Request, Role, Step, Utterance
from cellctl.control.states import Event
from cellctl.messages import JobData, Outcome, PartOutcome

if TYPE_CHECKING:
    from cellctl.mesh import GeneratedMesh


class Phase(StrEnum):
    """Where ``resume`` takes a job up again."""

    HEARING = "hearing"
    GENERATING = "generating"
    VALIDATING = "validating"
    CONFIRMING = "confirming"
    BUILDING = "building"
    RETREATING = "retreating"


class Grip(StrEnum):
    """What the latch has, as far as acts and their outcomes tell."""

    NOTHING = "nothing"
    LATCHING = "latching"
    """The latch was told to close and has not confirmed it; the arm stands at the station."""
    PART = "part"
    RELEASING = "releasing"
    """The latch was told to open and has not confirmed it; the arm stands at the cell."""


@dataclass
class Job:
    """The controller's record of one wish."""

    role: Role
    job_id: str = field(default_factory=lambda: secrets.token_hex(4))
    utterance: Utterance | None = None
    request: Request | None = None
    generated: GeneratedMesh | None = None
    plan: BuildPlan | None = None
    phase: Phase = Phase.HEARING
    placed: int = 0
    """How many steps of the plan are done; also the index of the next one."""
    outcomes: list[PartOutcome] = field(default_factory=list)
    message: str = ""
    outcome: Outcome = ""
    pausing: bool = False
    cancelling: bool = False
    end_of_speech_s: float | None = None
    first_motion_s: float | None = None
    finished_s: float | None = None

    @property
    def step(self) -> Step | None:
        """The step to carry out next; None when all are done."""
        if self.plan is None or self.placed >= len(self.plan.steps):
            return None
        return self.plan.steps[self.placed]

    @property
    def more_after_this(self) -> bool:
        """Whether the plan has a step after the next one."""
        return self.plan is not None and self.placed + 1 < len(self.plan.steps)

    def resume_event(self, grip: Grip) -> Event:
        """Which variant of ``resume`` goes on from here."""
        if self.phase is Phase.HEARING:
            return Event.RESUME_IDLE
        if self.phase is Phase.GENERATING:
            return Event.RESUME_GENERATING
        if self.phase is Phase.VALIDATING:
            return Event.RESUME_VALIDATING
        if self.phase is Phase.CONFIRMING:
            return Event.RESUME_CONFIRMING
        if self.phase is Phase.RETREATING or self.step is None:
            return Event.RESUME_RETREATING
        return {
            Grip.NOTHING: Event.RESUME_FEEDING,
            Grip.LATCHING: Event.RESUME_PICKING,
            Grip.PART: Event.RESUME_PLACING,
            Grip.RELEASING: Event.RESUME_VERIFYING,
        }[grip]

    def view(self) -> JobData:
        """The job as the bus shows it."""
        plan = self.plan
        durations = [step.duration_s for step in plan.steps] if plan is not None else []
        known = [duration for duration in durations if duration is not None]
        return JobData(
            job_id=self.job_id,
            role=self.role,
            utterance=self.utterance,
            request=self.request,
            title=plan.title if plan is not None else "",
            phase=self.phase.value,
            message=self.message,
            outcome=self.outcome,
            plan_id=plan.plan_id if plan is not None else "",
            parts_total=len(plan.steps) if plan is not None else 0,
            parts_placed=self.placed,
            predicted_s=sum(known) if durations and len(known) == len(durations) else None,
            checks=plan.checks if plan is not None else (),
            changes=plan.changes if plan is not None else (),
            questions=plan.questions if plan is not None else (),
            end_of_speech_s=self.end_of_speech_s,
            first_motion_s=self.first_motion_s,
            finished_s=self.finished_s,
        )
