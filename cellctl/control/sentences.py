"""What the cell says to the people in front of it, in one sentence a state."""

from __future__ import annotations

from cellctl.control.job import Job
from cellctl.errors import CellFault

_STATES = {
    "starting": "I am getting ready.",
    "idle": "What shall I build?",
    "listening_waiting": "I am about to listen.",
    "listening_hearing": "I am listening.",
    "listening_interpreting": "I am thinking about what you said.",
    "generating": "I am designing it.",
    "validating_discretising": "I am turning the shape into voxels.",
    "validating_checking": "I am checking that it can be built.",
    "validating_sequencing": "I am working out the order of the parts.",
    "feeding_indexing": "I am waiting for the next part.",
    "feeding_presenting": "The next part is arriving.",
    "assembling_picking": "I am picking a part up.",
    "assembling_placing": "I am placing a part.",
    "assembling_verifying": "I am letting the part go.",
    "assembling_retreating": "I am moving out of the way.",
    "paused_braking": "I am coming to rest.",
    "paused_resting": "I am paused.",
    "fault_recovering": "The operator is bringing me back.",
}


def describe(state: str, job: Job | None, fault: CellFault | None, *, pitch_m: float) -> str:
    """The present state in words."""
    if state.startswith("fault") and fault is not None and state != "fault_recovering":
        return f"{fault.message} {fault.hint}"
    if state == "validating_confirming" and job is not None and job.plan is not None:
        return question(job, pitch_m)
    if state == "idle" and job is not None and job.message:
        return f"{job.message} {_STATES['idle']}"
    if state.startswith("assembling") and job is not None and job.plan is not None:
        part = min(job.placed + 1, len(job.plan.steps))
        return f"{_STATES[state][:-1]} ({part} of {len(job.plan.steps)})."
    return _STATES[state]


def question(job: Job, pitch_m: float) -> str:
    """What is asked before the first motion."""
    plan = job.plan
    assert plan is not None
    sizes = " x ".join(f"{edge * pitch_m * 100:.0f}" for edge in plan.assembly.size)
    known = [step.duration_s for step in plan.steps if step.duration_s is not None]
    parts = f"{plan.parts} part{'s' if plan.parts != 1 else ''}"
    time = f", about {_duration(sum(known))}" if len(known) == len(plan.steps) else ""
    changes = "".join(f" {change.what}" for change in plan.changes)
    title = plan.title[:1].upper() + plan.title[1:]
    asked = "".join(f" {text}" for text in plan.questions)
    return f"{title}, {sizes} cm, {parts}{time}.{changes}{asked} Shall I build it?"


def finished(job: Job) -> str:
    """What is said when the arm is home again."""
    assert job.plan is not None
    if job.step is None:
        return f"Your {job.plan.title} is finished."
    return cancelled(job)


def cancelled(job: Job) -> str:
    """What is said when a job ended before its object was complete."""
    if job.plan is None or not job.placed:
        return "All right, I have dropped it."
    return f"All right, I stopped after {job.placed} of {len(job.plan.steps)} parts."


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{max(1, round(seconds / 10)) * 10} seconds"
    return f"{round(seconds / 60)} minutes"
