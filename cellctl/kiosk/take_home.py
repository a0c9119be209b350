"""Files of jobs that the page hands out: the shape, the plan as a 3D file, and pictures."""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from dataclasses import dataclass
from typing import Final

from cellctl.assembly import Role
from cellctl.kiosk.bus_link import BusLink
from cellctl.messages import FileData, FileKind

_KEPT: Final = 40
"""Files that are kept, so that a visitor's phone finds them after the next wish has begun."""
_KEPT_BYTES: Final = 100_000_000


@dataclass(frozen=True)
class JobFile:
    """One file, as the bus gave it."""

    data: FileData
    content: bytes


class JobFiles:
    """Asks the bus once for each file, however many browsers want it.

    Args:
        link: the way to the cell.
    """

    def __init__(self, link: BusLink) -> None:
        self._link = link
        self._files: OrderedDict[tuple[str, FileKind], JobFile] = OrderedDict()
        self._asking = asyncio.Lock()

    async def get(self, job_id: str, kind: FileKind) -> JobFile:
        """A file of the job under way, of the last one, or of one that was asked for before.

        Raises:
            CellctlError: there is none, or it cannot be had any more.
        """
        async with self._asking:
            key = (job_id, kind)
            if (kept := self._files.get(key)) is not None:
                self._files.move_to_end(key)
                return kept
            data, content = await self._link.file(kind, job_id, role=Role.VISITOR)
            found = self._files[key] = JobFile(data, content)
            self._forget()
            return found

    def _forget(self) -> None:
        """Let go of the oldest while there is too much."""
        while len(self._files) > 1 and (
            len(self._files) > _KEPT
            or sum(len(file.content) for file in self._files.values()) > _KEPT_BYTES
        ):
            self._files.popitem(last=False)
