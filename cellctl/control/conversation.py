"""What is said while the cell asks "Shall I build it?" and is neither yes nor no."""

from __future__ import annotations

from cellctl.assembly import Intent, Role, Utterance
from cellctl.control.cell import Cell
from cellctl.control.job import Job
from cellctl.control.states import Event
from cellctl.errors import RefusedError

_HINT = "Say yes, no, another one, or what to change, such as: make it taller."


async def take_another(cell: Cell, role: Role) -> str:
    """Design another shape for the same wish, and ask again.

    Raises:
        RefusedError: nothing waits for an answer, or there can be no other.
    """
    job = _asked_about(cell, role)
    if job.generated is None:
        raise RefusedError("That is a plan of its own; I know no other.", _HINT)
    await cell.controller.command(
        Event.CHANGE,
        job.begin_another,
        unless=lambda: "" if cell.active_job is job else "That came too late.",
    )
    return "I am looking for another one."


async def take_change(cell: Cell, utterance: Utterance, role: Role) -> str:
    """Change what was designed, or design something else instead, and ask again.

    Raises:
        RefusedError: it is no change and no wish, or shall not be built; the question stands.
    """
    job = _asked_about(cell, role)
    request = await cell.wishes.understand(utterance)
    if request.refusal:
        raise RefusedError(request.refusal, _HINT)
    if request.intent not in (Intent.DESIGN, Intent.EDIT):
        raise RefusedError(request.ask or "I asked whether to build it.", _HINT)
    if request.edits and all(edit.attribute == "looks" for edit in request.edits):
        # No description knows what is nicer; whoever asks for it can choose.
        return await take_another(cell, role)
    await cell.controller.command(
        Event.CHANGE,
        lambda: job.begin_change(request),
        unless=lambda: "" if cell.active_job is job else "That came too late.",
    )
    return "I am working out the change."


def _asked_about(cell: Cell, role: Role) -> Job:
    """The job that is asked about, which somebody of that role may change.

    Raises:
        RefusedError: there is none, or it is another's.
    """
    job = cell.active_job
    if job is None or cell.controller.state != "validating_confirming":
        raise RefusedError("Nothing waits for an answer.", "Say your wish.")
    if role is Role.VISITOR and job.role is not role:
        raise RefusedError("The operator began this job; only the operator changes it.", _HINT)
    if job.takes_apart:
        raise RefusedError("I asked whether to take it apart.", "Say yes or no.")
    return job
