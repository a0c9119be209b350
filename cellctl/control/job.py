"""One wish on its way through the cell, and how far it has come."""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import TYPE_CHECKING, Self

from cellctl.assembly import (
    BuildPlan,
    Cell,
    Intent,
    Pace,
    PartOutcome,
    Request,
    Role,
    Step,
    StepKind,
    Utterance,
)
from cellctl.control.acts import JobFiles, JobRecord
from cellctl.control.proposals import Proposals
from cellctl.control.states import Event
from cellctl.messages import JobData, Outcome

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
    """The latch was told to open and has not confirmed it; the arm stands at the cell, or where the
    part goes back to the belt."""
    GRIPPED = "gripped"
    """The latch has closed on a part that stands, and that is not parted from its neighbours; or it
    was told to let one go, and nobody has felt that the gripper is free of it."""


@dataclass(frozen=True)
class Planned:
    """What was asked about, while a change to it is worked out."""

    request: Request | None
    generated: GeneratedMesh | None
    plan: BuildPlan | None


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
    pace: Pace | None = None
    """What the movements with a part are told, where it is a trial of that."""
    standing: frozenset[Cell] = frozenset()
    """Cells of the workspace that hold a part."""
    outcomes: list[PartOutcome] = field(default_factory=list)
    message: str = ""
    change: Request | None = None
    """What is to be changed, while that is worked out."""
    before: Planned | None = None
    """What was asked about before that change."""
    another: bool = False
    """Whether another shape for the same wish is wanted, while that is worked out."""
    proposals: Proposals = field(default_factory=Proposals)
    """What was shown for the wish."""
    note: str = ""
    """Why the last change could not be made."""
    outcome: Outcome = ""
    pausing: bool = False
    cancelling: bool = False
    end_of_speech_s: float | None = None
    first_motion_s: float | None = None
    finished_s: float | None = None

    owner: str = ""
    """Mark of the visitor whose it is; empty for the one in front of the cell."""
    owner_name: str = ""

    @classmethod
    def of_file(cls, name: str, content: bytes, role: Role, pace: Pace | None = None) -> Self:
        """That builds what a mesh or plan file holds, at a pace that is under trial if need be."""
        return cls(role, phase=Phase.VALIDATING, upload_name=name, upload=content, pace=pace)

    @classmethod
    def taking_apart(cls, role: Role, owner: str = "") -> Self:
        """That takes apart what stands."""
        request = Request(
            text="Take it apart.", intent=Intent.CONTROL, phrase="false", command="take_apart"
        )
        return cls(role, phase=Phase.VALIDATING, request=request, owner=owner)

    @property
    def placed(self) -> int:
        """How many steps of the plan are done: parts that stand as planned, or are taken off."""
        return sum(not due for due in self._due())

    @property
    def step(self) -> Step | None:
        """The step to carry out next: the first that is due; None when none is.

        A placed part that has gone missing is due again; one that was to be taken off, and is gone,
        is no longer.
        """
        due = self._due()
        return next((step for step, is_due in zip(self._steps, due, strict=True) if is_due), None)

    @property
    def step_before(self) -> Step | None:
        """The step that was done last."""
        step = self.step
        index = step.index if step is not None else len(self._steps)
        return self._steps[index - 1] if index else None

    @property
    def takes(self) -> bool:
        """Whether the next step takes a part off."""
        step = self.step
        return step is not None and step.kind is StepKind.REMOVE

    @property
    def next_placement(self) -> Step | None:
        """The step after the next one, if that brings a part from the belt."""
        due = self._due()
        left = [step for step, is_due in zip(self._steps, due, strict=True) if is_due]
        return left[1] if len(left) > 1 and left[1].kind is StepKind.PLACE else None

    @property
    def more_after_this(self) -> bool:
        """Whether the plan places a part right after the next step."""
        return self.next_placement is not None

    @property
    def removes(self) -> bool:
        """Whether its plan takes parts off."""
        return any(step.kind is StepKind.REMOVE for step in self._steps)

    @property
    def left_to_place(self) -> int:
        """How many parts are still to be placed."""
        due = zip(self._steps, self._due(), strict=True)
        return sum(is_due and step.kind is StepKind.PLACE for step, is_due in due)

    @property
    def left_s(self) -> float | None:
        """How long the steps that are due take; None where that is not known of all of them."""
        due = zip(self._steps, self._due(), strict=True)
        durations = [step.duration_s for step, is_due in due if is_due]
        known = [duration for duration in durations if duration is not None]
        return sum(known) if len(known) == len(durations) else None

    @property
    def kept(self) -> frozenset[Cell]:
        """Cells whose part must stand for the plan to hold, and that no step of it touches."""
        if self.plan is None:
            return frozenset()
        touched = {step.cell for step in self._steps}
        return frozenset(self.plan.assembly.cells) - touched

    def _due(self) -> list[bool]:
        """For each step whether it is still to be carried out.

        Steps are carried out in order, and each is written down before the next begins; so the one
        after the last that was written down may be done as well, which what stands tells.
        """
        steps, standing = self._steps, self.standing
        begun = max((outcome.step + 1 for outcome in self.outcomes), default=0)
        while begun < len(steps) and _done(steps[begun], standing):
            begun += 1
        last = {step.cell: step.index for step in steps[:begun]}
        return [
            step.index >= begun or (last[step.cell] == step.index and not _done(step, standing))
            for step in steps
        ]

    @property
    def _steps(self) -> tuple[Step, ...]:
        return self.plan.steps if self.plan is not None else ()

    @property
    def takes_apart(self) -> bool:
        """Whether it was asked for that what stands is taken apart."""
        return self.request is not None and self.request.command == "take_apart"

    def outcome_when_home(self) -> Outcome:
        """How it ended when the arm is home again."""
        if self.step is not None:
            return "cancelled"
        return "taken_apart" if self.takes_apart else "built"

    def confirm_event(self) -> Event:
        """Which variant of ``confirm`` fits its plan."""
        return Event.CONFIRM_TAKING if self.takes else Event.CONFIRM

    def why_not_resume(self) -> str:
        """Why it cannot go on: a part that was to stay is gone. Empty when it can."""
        lost = sorted(self.kept - self.standing)
        if not lost:
            return ""
        return (
            f"The part at {list(lost[0])} was to stay, and is missing: the plan no longer holds. "
            "Cancel, and ask anew."
        )

    def begin_change(self, request: Request) -> None:
        """Design anew: what was asked about, changed; or another wish."""
        self.change, self.note = request, ""
        self.before = Planned(self.request, self.generated, self.plan)
        self.phase = Phase.GENERATING

    def begin_another(self) -> None:
        """Design another shape for the same wish."""
        self.another, self.note = True, ""
        self.before = Planned(self.request, self.generated, self.plan)
        self.phase = Phase.GENERATING

    def end_change(self) -> None:
        """What is planned now is what is asked about."""
        self.change = self.before = None
        self.another = False

    def undo_change(self, why: str) -> None:
        """Ask again about what was planned before."""
        assert self.before is not None, "a change was begun"
        self.request, self.generated = self.before.request, self.before.generated
        self.plan = self.before.plan
        self.note = why
        self.phase = Phase.CONFIRMING
        self.end_change()

    def resume_event(self, grip: Grip, gripped: Cell | None = None) -> Event:
        """Which variant of ``resume`` goes on from here.

        Args:
            grip: what the latch has.
            gripped: the cell of the standing part that it has hold of.
        """
        if self.phase in _RESUMES:
            return _RESUMES[self.phase]
        winding_up = self.phase is Phase.RETREATING and self.cancelling
        if winding_up or (self.step is None and grip is Grip.NOTHING):
            return Event.RESUME_RETREATING
        if grip is Grip.GRIPPED and (self.step is None or gripped != self.step.cell):
            # Whatever comes next lets that part stand first.
            if self.step is None:
                return Event.RESUME_RETREATING
            return Event.RESUME_GRIPPING if self.takes else Event.RESUME_PICKING
        if self.step is None or self.takes:
            return {
                Grip.NOTHING: Event.RESUME_GRIPPING,
                Grip.LATCHING: Event.RESUME_GRIPPING,
                Grip.GRIPPED: Event.RESUME_PARTING,
                Grip.PART: Event.RESUME_RETURNING,
                Grip.RELEASING: Event.RESUME_PUTTING_BACK,
            }[grip]
        return {
            Grip.NOTHING: Event.RESUME_FEEDING,
            Grip.LATCHING: Event.RESUME_PICKING,
            Grip.GRIPPED: Event.RESUME_PICKING,
            Grip.PART: Event.RESUME_PLACING,
            Grip.RELEASING: Event.RESUME_VERIFYING,
        }[grip]

    @property
    def shows_another(self) -> bool:
        """Whether its shape is another one than was designed for the wish first."""
        return self.proposals.asked not in (None, self.generated)

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
            pace=self.pace,
            cancelling=self.cancelling,
            owner=self.owner,
            owner_name=self.owner_name,
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
            pace=record.pace,
            standing=standing,
            outcomes=list(record.parts),
            message=record.message,
            cancelling=record.cancelling,
            owner=record.owner,
            owner_name=record.owner_name,
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
            provenance=plan.provenance if plan is not None else "",
            parts_total=len(plan.steps) if plan is not None else 0,
            parts_placed=self.placed,
            predicted_s=sum(known) if durations and len(known) == len(durations) else None,
            pace=self.pace,
            checks=plan.checks if plan is not None else (),
            changes=plan.changes if plan is not None else (),
            questions=plan.questions if plan is not None else (),
            end_of_speech_s=self.end_of_speech_s,
            first_motion_s=self.first_motion_s,
            finished_s=self.finished_s,
        )


def _done(step: Step, standing: frozenset[Cell]) -> bool:
    """Whether what stands is as after the step, as far as its own part goes."""
    return (step.cell in standing) is (step.kind is StepKind.PLACE)
