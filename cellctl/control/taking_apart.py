"""The stages in which parts come off what stands and go back to the belt, or to their new cells."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from cellctl.assembly import PartOutcome
from cellctl.control.controller import Post
from cellctl.control.dismantling import Dismantler
from cellctl.control.job import Grip, Job, Phase
from cellctl.control.states import Event

_TAKEN = {
    "to_belt": Event.PARTED,
    "to_place": Event.PARTED_TO_PLACE,
    "again": Event.GRIP_AGAIN,
}


class TakingApart:
    """What the cell does in the states under ``disassembling``.

    Args:
        builder: the acts.
        check: looks the robot and the belt over before the first motion.
        show: tells everyone of a step that is done.
        next_event: which event leads from a finished step to the next.
    """

    def __init__(
        self,
        builder: Dismantler,
        *,
        check: Callable[[], Awaitable[None]],
        show: Callable[[Job, PartOutcome], None],
        next_event: Callable[[Job], Event],
    ) -> None:
        self._builder = builder
        self._check = check
        self._show = show
        self._next_event = next_event

    async def grip(self, job: Job, post: Post) -> None:
        """Close the latch on the part that is to come off."""
        job.phase = Phase.BUILDING
        if self._builder.grip is Grip.PART:
            # Left over from a job that was cancelled: it goes to the belt first.
            post(Event.PARTED)
            return
        if job.cancelling:
            post(Event.WIND_UP)
            return
        if job.pausing:
            post(Event.PAUSE_NOW)
            return
        await self._check()
        await self._builder.grip_standing(job)
        post(Event.GRIPPED)

    async def part(self, job: Job, post: Post) -> None:
        """Take it off; a part that is cancelled before that stands on."""
        if job.cancelling and not self._builder.taking_cut_off:
            post(Event.WIND_UP)
            return
        if job.pausing:
            post(Event.PAUSE_NOW)
            return
        await self._check()
        taken = await self._builder.take_off(job)
        if taken == "to_place":
            self._show(job, job.outcomes[-1])
        post(_TAKEN[taken])

    async def bring_back(self, job: Job, post: Post) -> None:
        """Bring it to the pick station."""
        if job.pausing:
            post(Event.PAUSE_NOW)
            return
        await self._check()
        await self._builder.bring_back(job)
        post(Event.RETURNED)

    async def put_back(self, job: Job, post: Post) -> None:
        """Let it go there."""
        outcome = await self._builder.put_back(job)
        if outcome is not None:
            self._show(job, outcome)
        post(self._next_event(job))
