"""Answers to what visitors ask; nothing is done for them."""

from __future__ import annotations

from collections.abc import Callable

from cellctl.control.cell import Cell
from cellctl.control.dialogue.reading import Topic
from cellctl.control.dialogue.table import Place
from cellctl.control.job import Job
from cellctl.messages import QueueEntry
from cellctl.wording import Line


class Answers:
    """Answers questions from what the cell knows now.

    Args:
        cell: what they are about.
        queue: the wishes that wait.
    """

    def __init__(self, cell: Cell, queue: Callable[[], tuple[QueueEntry, ...]]) -> None:
        self._cell = cell
        self._queue = queue
        self._wording = cell.sentences.wording

    def answer(  # noqa: PLR0911 - one way out a topic
        self, topic: Topic, place: Place
    ) -> Line:
        """The answer to a question.

        Args:
            topic: what it is about.
            place: where the conversation is.
        """
        match topic:
            case "can_make":
                pitch = f"{self._cell.config.voxel.pitch_m * 100:g}"
                return self._line("answer.can_make", pitch=pitch)
            case "how_long":
                return self._how_long(place)
            case "doing":
                return self._doing(place)
            case "parts_left":
                return self._parts(place)
            case "why":
                return self._why(place)
            case "queue":
                return self._waiting()
            case "who":
                return self._line("answer.who")
            case "thanks":
                return self._thanks(place)

    def _line(self, key: str, **fields: object) -> Line:
        return self._wording.line(key, **fields)

    def _how_long(self, place: Place) -> Line:
        job = self._cell.active_job
        left_s = job.left_s if job is not None else None
        match place:
            case Place.WAITING | Place.FAULT:
                return self._line("answer.how_long_waiting")
            case Place.THINKING | Place.STARTING:
                return self._line("answer.how_long_thinking")
            case Place.WORKING | Place.ASKING_BUILD | Place.ASKING_APART if left_s is not None:
                asking = "working" if place is Place.WORKING else "asking"
                duration = self._cell.sentences.about(left_s)
                return self._line(f"answer.how_long_{asking}", duration=duration)
            case _:
                return self._line("answer.how_long_ready")

    def _doing(self, place: Place) -> Line:
        cell, job = self._cell, self._cell.active_job
        if place is Place.ASKING_HAND_OVER:
            return self._line("answer.doing_hand_over")
        if place is Place.READY and (cell.job is None or cell.job.outcome != "built"):
            # Not what became of the last wish: that was said.
            asks = cell.sentences.idle(None, cell.builder.ledger).text
            return self._line("answer.doing_ready", sentence=asks)
        if place is not Place.WORKING or job is None or job.plan is None:
            return self._line("answer.doing", sentence=cell.line.text)
        progress = {"done": job.placed, "total": len(job.plan.steps)}
        if job.takes_apart:
            return self._line("answer.doing_apart", **progress)
        return self._line("answer.doing_working", object=cell.sentences.thing(job), **progress)

    def _parts(self, place: Place) -> Line:
        job = self._cell.active_job
        busy = place in {Place.WORKING, Place.WAITING, Place.ASKING_BUILD}
        if busy and job is not None and job.plan is not None:
            return self._line("answer.parts_left", count=job.left_to_place)
        return self._line("answer.parts_have", count=self._cell.builder.ledger.counts.available)

    def _why(self, place: Place) -> Line:
        cell, job = self._cell, self._cell.active_job
        match place:
            case Place.FAULT | Place.WAITING | Place.STARTING:
                line = self._line("answer.doing", sentence=cell.line.text)
            case Place.ASKING_HAND_OVER:
                line = self._line("answer.doing_hand_over")
            case Place.ASKING_APART:
                line = self._line("explain.asked_apart")
            case Place.ASKING_BUILD if job is not None:
                line = self._why_so(job)
            case Place.WORKING:
                line = self._line("answer.why_working")
            case _ if cell.job is not None and cell.job.message:
                line = self._line("answer.why_last", message=cell.job.message)
            case _:
                line = self._line("answer.why_nothing")
        return line

    def _why_so(self, job: Job) -> Line:
        changes = job.plan.changes if job.plan is not None else ()
        translated = self._wording.translated
        told = [translated(part) for change in changes for part in (change.what, change.why)]
        # Why what was asked for last was not changed comes first.
        if reasons := " ".join(filter(None, [translated(job.note), *told])):
            return self._line("answer.why_asking", reasons=reasons)
        return self._line("answer.why_as_asked")

    def _thanks(self, place: Place) -> Line:
        match place:
            case Place.ASKING_BUILD:
                return self._line("answer.thanks_asking")
            case Place.READY if self._cell.builder.standing:
                return self._line("answer.thanks_standing")
            case _:
                return self._line("answer.thanks")

    def _waiting(self) -> Line:
        entries = self._queue()
        if not entries:
            return self._line("answer.queue_empty")
        wishes = ", ".join(entry.wish for entry in entries)
        return self._line("answer.queue", count=len(entries), wishes=wishes)
