"""Recognising a request while it may still go on: whoever was finished has not waited for it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

from cellctl.assembly import Utterance
from cellctl.errors import HearingError
from cellctl.listening.ears.events import Draft, Segment


class Drafts:
    """At most one recognition that nobody waits for yet.

    Args:
        hear: recognises sound; raises HearingError.
    """

    def __init__(self, hear: Callable[[bytes], Awaitable[Utterance]]) -> None:
        self._hear = hear
        self._task: asyncio.Task[Utterance | HearingError] | None = None
        self._mark = 0

    def begin(self, draft: Draft) -> None:
        """Recognise what may be complete, unless the recogniser is still busy with an earlier one:
        to break that off would cost its process."""
        if self._task is None or self._task.done():
            self._mark = draft.mark
            self._task = asyncio.create_task(self._recognise(draft.pcm), name="draft")

    async def result(self, segment: Segment) -> Utterance:
        """The words of what is complete now.

        Raises:
            HearingError: it cannot be recognised.
        """
        task = self._task
        if task is None or self._mark != segment.mark:
            return await self._hear(segment.pcm)
        result = await task
        if isinstance(result, HearingError):
            raise result
        return result

    async def close(self) -> None:
        """End what nobody waits for any more."""
        if self._task is not None:
            self._task.cancel()
            await asyncio.gather(self._task, return_exceptions=True)

    async def _recognise(self, pcm: bytes) -> Utterance | HearingError:
        try:
            return await self._hear(pcm)
        except HearingError as error:
            return error
