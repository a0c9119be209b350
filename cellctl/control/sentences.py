"""What the cell says to the people in front of it, in one sentence a state."""

from __future__ import annotations

from cellctl.assembly import BuildPlan
from cellctl.control.job import Job
from cellctl.control.ledger import Ledger
from cellctl.control.recovery import Doubt
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
    "feeding_refilling": "The belt is empty.",
    "assembling_picking": "I am picking a part up.",
    "assembling_placing": "I am placing a part.",
    "assembling_verifying": "I am letting the part go.",
    "assembling_retreating": "I am moving out of the way.",
    "disassembling_gripping": "I am taking hold of a part.",
    "disassembling_parting": "I am taking a part off.",
    "disassembling_returning": "I am bringing a part back.",
    "disassembling_verifying": "I am laying the part on the belt.",
    "paused_braking": "I am coming to rest.",
    "paused_resting": "I am paused.",
    "paused_moving": "The operator is moving me by hand.",
    "fault_recovering": "The operator is bringing me back.",
}


def describe(
    state: str,
    job: Job | None,
    fault: CellFault | None,
    doubt: Doubt | None,
    ledger: Ledger,
    *,
    pitch_m: float,
    recalled: bool = False,
) -> str:
    """The present state in words; ``recalled``: this daemon found it so when it started."""
    own = {
        "idle": lambda: idle(job, ledger),
        "paused_resting": lambda: paused(job, doubt, ledger),
        "feeding_refilling": lambda: refilling(job, ledger),
    }
    if state in own:
        found = "I was ended in the middle of it and started again. " if recalled else ""
        return found + own[state]()
    if state.startswith("fault") and fault is not None and state != "fault_recovering":
        return f"{fault.message} {fault.hint}"
    if job is None or job.plan is None:
        return _STATES[state]
    if state == "validating_confirming":
        return question(job, pitch_m)
    if state.startswith(("assembling", "disassembling")):
        part = min(job.placed + 1, len(job.plan.steps))
        return f"{_STATES[state][:-1]} ({part} of {len(job.plan.steps)})."
    return _STATES[state]


def idle(job: Job | None, ledger: Ledger) -> str:
    """What became of the last job, and what is needed before the next one."""
    message = f"{job.message} " if job is not None and job.message else ""
    return f"{message}{_occupied(ledger) or _STATES['idle']}"


def paused(job: Job | None, doubt: Doubt | None, ledger: Ledger) -> str:
    """What is believed of the cell while it stands still, and what it needs to go on."""
    said = [_STATES["paused_resting"]]
    active = job is not None and job.finished_s is None
    if active and job is not None and job.plan is not None:
        done = "moves done" if job.removes else "placed"
        said = [f"Paused: {job.placed} of {len(job.plan.steps)} {done}."]
    if doubt is not None:
        said.append(
            f"{doubt.sentence}: look, then say resume if it is {_WHERE[doubt.believed]}, or tell "
            "where it is with `cellctl recover`."
        )
        return " ".join(said)
    if ledger.holding:
        said.append("The gripper holds a part.")
    elif ledger.gripped is not None:
        said.append("The latch has closed on a part that stands.")
    if active and ledger.standing:
        said.append("Look whether all placed parts still stand.")
    said.append("Say resume to go on.")
    return " ".join(said)


_WHERE = {
    "gripper": "in the gripper",
    "cell": "at its cell",
    "station": "at the pick station",
    "stock": "in the stock",
    "scrap": "scrap",
    "unknown": "gone",
}


def refilling(job: Job | None, ledger: Ledger) -> str:
    """What is needed when the belt has run empty."""
    if not ledger.counts.stock:
        return (
            "The belt and the stock are empty. Find more parts and tell it with "
            "`cellctl inventory set stock=N`."
        )
    left = job.left_to_place if job is not None else 0
    return (
        f"The belt is empty and {_parts(left)} {_is(left)} still to place. "
        "Lay parts on the belt and say `cellctl refill`."
    )


def _occupied(ledger: Ledger) -> str:
    count = len(ledger.standing)
    if not count:
        return ""
    return (
        f"{_parts(count)} {'stands' if count == 1 else 'stand'} in the workspace. What shall I "
        "make of it? Or take the object along (`cellctl hand-over`), or have it taken apart "
        "(`cellctl take-apart`)."
    )


def _is(count: int) -> str:
    return "is" if count == 1 else "are"


def _parts(count: int) -> str:
    return "1 part" if count == 1 else f"{count} parts"


def question(job: Job, pitch_m: float) -> str:
    """What is asked before the first motion."""
    plan = job.plan
    assert plan is not None
    if job.takes_apart:
        return (
            f"{_parts(len(plan.steps))} go back to the belt{_about(plan)}. Shall I take it apart?"
        )
    sizes = " x ".join(f"{edge * pitch_m * 100:.0f}" for edge in plan.assembly.size)
    changes = "".join(f" {change.what}" for change in plan.changes)
    stays = f"{job.note} So it stays as it was: " if job.note else ""
    title = plan.title[:1].upper() + plan.title[1:]
    asked = "".join(f" {text}" for text in plan.questions)
    parts = len(plan.assembly.cells)
    do = "change what stands into it" if job.removes else "build it"
    return (
        f"{stays}{title}, {sizes} cm, {_parts(parts)}{_about(plan)}.{changes}{asked} Shall I {do}?"
    )


def _about(plan: BuildPlan) -> str:
    known = [step.duration_s for step in plan.steps if step.duration_s is not None]
    return f", about {_duration(sum(known))}" if len(known) == len(plan.steps) else ""


def finished(job: Job) -> str:
    """What is said when the arm is home again."""
    assert job.plan is not None
    if job.step is None:
        return "It is taken apart." if job.takes_apart else f"Your {job.plan.title} is finished."
    return cancelled(job)


def cancelled(job: Job) -> str:
    """What is said when a job ended before its object was complete."""
    if job.plan is None or not job.placed:
        return "All right, I have dropped it."
    what = "moves" if job.removes else "parts"
    return f"All right, I stopped after {job.placed} of {len(job.plan.steps)} {what}."


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{max(1, round(seconds / 10)) * 10} seconds"
    return f"{round(seconds / 60)} minutes"
