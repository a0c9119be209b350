"""After a reset of the gripper's board: it has kept its latch, and confirms nothing."""

from __future__ import annotations

import structlog

from cellctl.boards.constants import ResetCause
from cellctl.control.building import Builder
from cellctl.control.controller import Controller
from cellctl.control.job import Grip, Job
from cellctl.control.moving import ArmAndLatch
from cellctl.control.states import top_of
from cellctl.errors import CellFault

log = structlog.get_logger(__name__)

_MOVING = frozenset({"feeding", "assembling", "disassembling"})


async def settle_reset(
    cause: ResetCause | None,
    *,
    hands: ArmAndLatch,
    builder: Builder,
    controller: Controller,
    job: Job | None,
) -> None:
    """Stop and ask when there is a part in the latch, unless a latch was confirmed since.

    While the cell is at rest nothing is done: ``resume`` asks by itself. An act in which the latch
    moves makes good by itself: see ``LatchGripper``.

    Args:
        cause: what the board told; None where it told nothing.
        hands: the arm and its latch.
        builder: knows what the latch has.
        controller: takes the fault.
        job: the one under way.
    """
    hands.forget_opening()
    if not _carries(builder, controller):
        return
    try:
        proven = await hands.proves_latched()
    except CellFault as fault:  # the arm is away too, which is a fault of its own
        log.warning("nobody can tell whether the latch is confirmed", reason=str(fault))
        return
    if proven or not _carries(builder, controller):
        return
    told = f" ({cause.value})" if cause is not None else ""
    part = f"Part {job.step.index + 1}" if job is not None and job.step else "The part"
    builder.doubt_held(
        f"{part} should be in the gripper, whose board was reset{told}", believed="gripper"
    )
    controller.post_fault(CellFault("gripper_reset", f"{part} is in it, as it seems."))


def _carries(builder: Builder, controller: Controller) -> bool:
    """Whether a part that nobody doubts is on its way."""
    moving = top_of(controller.state) in _MOVING
    return moving and builder.grip is Grip.PART and builder.doubt is None
