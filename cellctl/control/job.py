"""One wish on its way through the cell, and how far it has come."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import TYPE_CHECKING, Self

from cellctl.assembly import BuildPlan, Cell, Request, Role, Step, Utterance
from cellctl.control.acts import JobFiles, JobRecord
from cellctl.control.states import Event
from cellctl.messages import JobData, Outcome, PartOutcome

if TYPE_CHECKING:
    from cellctl.mesh import GeneratedMesh


class Phase(StrEnum):
    """Where ``resume`` takes a job up again."""

    HEARING = "hearing"
    INTERPRETING = "interpreting"
    GENERATING = "generating"
    VALIDATING = "validating"
    CONFIRMING = "confirming"
    BUILDING = "building"
    RETREATING = "retreating"


_RESUMES = {
    Phase.HEARING: Event.RESUME_IDLE,
    Phase.INTERPRETING: Event.RESUME_INTERPRETING,
    Phase.GENERATING: Event.RESUME_GENERATING,
    Phase.VALIDATING: Event.RESUME_VALIDATING,
    Phase.CONFIRMING: Event.RESUME_CONFIRMING,
}
"""What ``resume`` leads to before anything has moved."""


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
    began_at: datetime | None = None
    """Calendar time."""
    finished_at: datetime | None = None
    upload_name: str = ""
    upload: bytes | None = None
    """The mesh or plan file that it began with."""
    standing: frozenset[Cell] = frozenset()
    """Cells of the workspace that hold a part."""
    outcomes: list[PartOutcome] = field(default_factory=list)
    message: str = ""
    outcome: Outcome = ""
    pausing: bool = False
    cancelling: bool = False
    end_of_speech_s: float | None = None
    first_motion_s: float | None = None
    finished_s: float | None = None

    @property
    def placed(self) -> int:
        """How many parts of the plan stand."""
        return sum(step.cell in self.standing for step in self._steps)

    @property
    def step(self) -> Step | None:
        """The step to carry out next: the first whose part does not stand; None when all do."""
        return next((step for step in self._steps if step.cell not in self.standing), None)

    @property
    def more_after_this(self) -> bool:
        """Whether the plan has a step after the next one."""
        return self.placed + 1 < len(self._steps)

    @property
    def _steps(self) -> tuple[Step, ...]:
        return self.plan.steps if self.plan is not None else ()

    def resume_event(self, grip: Grip) -> Event:
        """Which variant of ``resume`` goes on from here."""
        if self.phase in _RESUMES:
            return _RESUMES[self.phase]
        if self.step is None or (self.phase is Phase.RETREATING and self.cancelling):
            return Event.RESUME_RETREATING
        return {
            Grip.NOTHING: Event.RESUME_FEEDING,
            Grip.LATCHING: Event.RESUME_PICKING,
            Grip.PART: Event.RESUME_PLACING,
            Grip.RELEASING: Event.RESUME_VERIFYING,
        }[grip]

    def record(self) -> JobRecord:
        """As the journal keeps it."""
        assert self.began_at is not None, "a job that is kept has begun"
        return JobRecord(
            job_id=self.job_id,
            role=self.role,
            began_at=self.began_at,
            finished_at=self.finished_at,
            phase=self.phase.value,
            outcome=self.outcome,
            message=self.message,
            utterance=self.utterance,
            request=self.request,
            plan=self.plan,
            parts=tuple(self.outcomes),
            upload_name=self.upload_name,
            cancelling=self.cancelling,
        )

    @classmethod
    def recalled(cls, record: JobRecord, files: JobFiles, standing: frozenset[Cell]) -> Self:
        """A job that an earlier daemon began."""
        return cls(
            record.role,
            job_id=record.job_id,
            utterance=record.utterance,
            request=record.request,
            generated=files.mesh,
            plan=record.plan,
            phase=Phase(record.phase),
            began_at=record.began_at,
            upload_name=record.upload_name,
            upload=files.upload,
            standing=standing,
            outcomes=list(record.parts),
            message=record.message,
            cancelling=record.cancelling,
        )

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
