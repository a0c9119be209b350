"""Files of jobs that the page hands out: the shape, the plan as a 3D file, and pictures.

The visitor's door gives away the files of the last job only. Those of an object that was built are
fetched when it is finished, so that a phone finds them after the next wish has begun.
"""

from __future__ import annotations

import asyncio
from collections import OrderedDict
from dataclasses import dataclass
from typing import Final

import structlog

from cellctl.assembly import BuildPlan, Role
from cellctl.config import CellConfig
from cellctl.drawing.svg import assembly_svg
from cellctl.errors import CellctlError
from cellctl.kiosk.bus_link import BusLink
from cellctl.kiosk.words import Words
from cellctl.messages import FileData, FileKind

log = structlog.get_logger(__name__)

_TAKEN_HOME: Final[tuple[FileKind, ...]] = ("plan", "steps")
_KEPT: Final = 40
"""Files that are kept, so that a visitor's phone finds them after the next wish has begun."""
_KEPT_BYTES: Final = 100_000_000


@dataclass(frozen=True)
class JobFile:
    """One file, as the bus gave it."""

    data: FileData
    content: bytes
    plan_id: str | None = None
    """Of the plan that was asked about then; a change makes another one for the same job."""


class JobFiles:
    """Asks the bus once for each file, however many browsers want it.

    Args:
        link: the way to the cell.
    """

    def __init__(self, link: BusLink) -> None:
        self._link = link
        self._fetched = ""
        """The job whose files were fetched last when it was finished."""
        self._fetching: asyncio.Task[None] | None = None
        self._files: OrderedDict[tuple[str, FileKind], JobFile] = OrderedDict()
        self._titles: OrderedDict[str, str] = OrderedDict()
        self._asking = asyncio.Lock()

    async def get(self, job_id: str, kind: FileKind) -> JobFile:
        """A file of the job under way, of the last one, or of one that was asked for before.

        Raises:
            CellctlError: there is none, or it cannot be had any more.
        """
        async with self._asking:
            key, plan_id = (job_id, kind), self._plan_id(job_id)
            kept = self._files.get(key)
            if kept is not None and plan_id in {None, kept.plan_id}:
                self._files.move_to_end(key)
                return kept
            data, content = await self._link.file(kind, job_id, role=Role.VISITOR)
            found = self._files[key] = JobFile(data, content, plan_id)
            self._files.move_to_end(key)
            self._forget()
            return found

    def _plan_id(self, job_id: str) -> str | None:
        """The plan of a job as it is known now; None for a job that is not the last one."""
        snapshot = self._link.mirror.snapshot
        job = snapshot.job if snapshot is not None else None
        return job.plan_id if job is not None and job.job_id == job_id else None

    async def plan(self, job_id: str) -> BuildPlan:
        """The plan of a job.

        Raises:
            CellctlError: as of ``get``.
        """
        return BuildPlan.model_validate_json((await self.get(job_id, "plan")).content)

    def title(self, job_id: str, plan: BuildPlan) -> str:
        """What the object of a job is called, in the cell's language where the cell has said it."""
        title = self._titles.get(job_id) or plan.title
        return title[:1].upper() + title[1:]

    def built(self) -> None:
        """Fetch the files of a job that has just ended well; to be called after every change."""
        snapshot = self._link.mirror.snapshot
        job = snapshot.job if snapshot is not None else None
        if job is not None and job.outcome == "built" and job.job_id != self._fetched:
            self._fetched = job.job_id
            self._titles[job.job_id] = job.title
            while len(self._titles) > _KEPT:
                self._titles.popitem(last=False)
            self._fetching = asyncio.create_task(self._fetch(job.job_id), name="take home")

    async def _fetch(self, job_id: str) -> None:
        for kind in _TAKEN_HOME:
            try:
                await self.get(job_id, kind)
            except CellctlError as error:
                log.warning("a file cannot be fetched", job=job_id, kind=kind, reason=str(error))

    def _forget(self) -> None:
        """Let go of the oldest while there is too much."""
        while len(self._files) > 1 and (
            len(self._files) > _KEPT
            or sum(len(file.content) for file in self._files.values()) > _KEPT_BYTES
        ):
            self._files.popitem(last=False)


def picture_svg(plan: BuildPlan, title: str, config: CellConfig, words: Words) -> str:
    """A picture of the object of a plan, with its name and how many parts it has."""
    edges = " x ".join(f"{round(edge * plan.pitch_m * 100)}" for edge in plan.assembly.size)
    count = len(plan.assembly.cells)
    caption = words.say("take.caption", count=count, size=edges, cell=config.cell.name)
    return assembly_svg(plan.assembly.cells, config.grid, title=title, caption=caption)


def take_home_path(job_id: str) -> str:
    """Where the page of what to take home is."""
    return f"/take/{job_id}"
