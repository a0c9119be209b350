"""What was built: the journal's jobs, and each of them again, step by step."""

from __future__ import annotations

import asyncio
from datetime import datetime
from typing import Any

from nicegui import ui

from cellctl.kiosk.components import Button, Text, attempt, attribute, box, shown
from cellctl.kiosk.operator.desk import Desk
from cellctl.kiosk.operator.replay import Moment, moments
from cellctl.kiosk.scene.pictures import Picture
from cellctl.kiosk.scene.view import CellView
from cellctl.kiosk.shell import duration
from cellctl.messages import (
    ActData,
    HistoryCommand,
    HistoryData,
    JobCommand,
    JobRecordData,
    JobSummary,
)

_PAGE = 15
_STEP_S = 0.6
"""From one step of a replay to the next (wall time)."""
_MOST_ACTS = 400
"""So many of a job's acts are listed, the newest."""


class History:
    """The list of jobs, and the one that is looked at."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._before: int | None = None
        say = desk.words.say
        with box("div", "grid grid--history"):
            with box("section", "panel", aria_labelledby="jobs"):
                with box("div", "panel__head"):
                    Text("h2", say("history.jobs"), "panel__title").props["id"] = "jobs"
                    Button(say("history.refresh"), self.open, kind="quiet", picture="another")
                self._count = Text("p", "", "small")
                self._list = box("ul", "jobs")
                self._more = Button(say("history.more"), self._next, kind="quiet")
            self._replay = Replay(desk)
        shown(self._more, False)

    async def open(self) -> None:
        """Show the newest jobs."""
        self._list.clear()
        self._before = None
        await self._next()

    async def _next(self) -> None:
        body = HistoryCommand(limit=_PAGE, before=self._before)
        page = await self._desk.ask(body, HistoryData)
        self._before = page.next_before
        self._count.say(self._desk.words.say("history.count", count=page.total))
        shown(self._more, page.next_before is not None)
        with self._list:
            for job in page.jobs:
                self._line(job)

    def _line(self, job: JobSummary) -> None:
        words = self._desk.words

        async def look() -> None:
            await self._replay.open(job.job_id)

        with box("li"), box("button", "job", type="button") as line:
            Text("span", job.title or job.what or job.job_id, "job__title")
            Text("span", words.say(f"outcome.{job.outcome or 'open'}"), f"tag tag--{job.outcome}")
            took = duration(words, job.seconds) if job.seconds else ""
            parts = words.say("op.parts_done", done=job.parts_done, total=job.steps)
            told = (when(job.began_at), parts if job.steps else "", took)
            Text("span", " · ".join(part for part in told if part), "job__facts")
        line.on("click", lambda: attempt(line, look))


class Replay:
    """One job: its object after each step, and its acts."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._moments: tuple[Moment, ...] = ()
        self._at = 0
        self._playing = False
        say = desk.words.say
        with box("section", "panel replay", aria_labelledby="replay") as self._whole:
            self._title = Text("h2", say("history.choose"), "panel__title")
            self._title.props["id"] = "replay"
            self._facts = Text("p", "", "small")
            with box("div", "replay__stage") as self._stage:
                with box("div", "scene replay__scene"):
                    self._view = CellView(desk.page.site.config, say("history.scene"))
                    self._view.props["data-no3d"] = say("visit.no_3d")
                with box("div", "replay__controls"):
                    self._play = Button(say("history.play"), self._toggle, picture="play")
                    Button(say("history.back"), self._back)
                    Button(say("history.on"), self._on)
                    self._slider = ui.element("input").classes("replay__slider")
                    self._slider.props.update(
                        {"type": "range", "min": 0, "aria-label": say("history.step_label")}
                    )
                    self._slider.on(
                        "input", self._slid, js_handler="(event) => emit(event.target.value)"
                    )
                self._said = Text("p", "", "replay__said")
                self._said.props["role"] = "status"
            with box("details", "acts") as self._details:
                Text("summary", say("history.acts"))
                self._acts = box("ol", "acts__list")
        self._timer = ui.timer(_STEP_S, self._tick, active=False)
        shown(self._stage, False)
        shown(self._details, False)

    async def open(self, job_id: str) -> None:
        """Look at a job.

        Raises:
            CellctlError: it cannot be read.
        """
        record = await self._desk.ask(JobCommand(job_id=job_id), JobRecordData)
        # What a long job leaves is worked out beside the loop that serves all pages.
        self._moments = await asyncio.to_thread(moments, record)
        words, job = self._desk.words, record.job
        self._title.say(job.title or job.what or job.job_id)
        told = (f"“{job.what}”" if job.what else "", when(job.began_at), job.message)
        self._facts.say(" · ".join(part for part in told if part))
        shown(self._stage, bool(self._moments))
        shown(self._details, bool(record.acts))
        attribute(self._slider, "max", str(max(0, len(self._moments) - 1)))
        self._acts.clear()
        with self._acts:
            for act in record.acts[-_MOST_ACTS:]:
                Text("li", act_line(act, words.say(f"act_outcome.{act.outcome or 'open'}")))
        self._stop()
        self._go(len(self._moments) - 1)

    def _go(self, at: int) -> None:
        if not self._moments:
            return
        self._at = min(max(0, at), len(self._moments) - 1)
        now, words = self._moments[self._at], self._desk.words
        last = len(self._moments) - 1
        label = words.say("history.at", step=self._at, total=last, count=len(now.standing))
        self._view.show(Picture("cell", standing=now.standing, planned=now.planned), label)
        said = label
        if now.kind is not None and now.cell is not None:
            done = words.say(f"history.{now.kind.value}", cell=list(now.cell))
            said = f"{label} {done} {words.say('history.took', seconds=f'{now.took_s:.1f}')}"
            if now.retries:
                said += f" {words.say('history.retries', count=now.retries)}"
        self._said.say(said)
        attribute(self._slider, "value", str(self._at))
        ui.run_javascript(f"document.getElementById('{self._slider.html_id}').value = '{self._at}'")

    async def _toggle(self) -> None:
        if self._playing:
            self._stop()
            return
        if self._at >= len(self._moments) - 1:
            self._go(0)
        self._playing = True
        self._play.label.say(self._desk.words.say("history.hold"))
        self._timer.activate()

    def _stop(self) -> None:
        self._playing = False
        self._play.label.say(self._desk.words.say("history.play"))
        self._timer.deactivate()

    def _tick(self) -> None:
        self._go(self._at + 1)
        if self._at >= len(self._moments) - 1:
            self._stop()

    async def _back(self) -> None:
        self._stop()
        self._go(self._at - 1)

    async def _on(self) -> None:
        self._stop()
        self._go(self._at + 1)

    def _slid(self, event: Any) -> None:
        self._stop()
        self._go(int(event.args))


def when(time: datetime) -> str:
    """A moment in the cell's own time zone."""
    return f"{time.astimezone():%Y-%m-%d %H:%M:%S}"


def act_line(act: ActData, outcome: str) -> str:
    """An act in a line: when, what, where, how long, and what became of it."""
    where = f" {list(act.cell)}" if act.cell is not None else ""
    took = ""
    if act.settled_at is not None:
        seconds = (act.settled_at - act.intended_at).total_seconds()
        took = f" {seconds:.1f} s" if seconds > 0 else ""
    detail = f": {act.detail}" if act.detail else ""
    time = f"{act.intended_at.astimezone():%H:%M:%S}"
    return f"{time} {act.kind.replace('_', ' ')}{where} · {outcome}{took}{detail}"
