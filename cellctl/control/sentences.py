"""What the cell says to the people in front of it and to those who look after it, in one sentence a
state."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import TypeVar

from cellctl.assembly import BuildPlan, Change, Role, Value
from cellctl.control.dialogue.naming import Naming
from cellctl.control.job import Job
from cellctl.control.ledger import Ledger
from cellctl.control.plainly import BY_FAULT, plainly
from cellctl.control.recovery import Doubt
from cellctl.errors import CellctlError, CellFault, FaultEntry
from cellctl.generating.wording import with_article
from cellctl.messages import FaultData, JobData
from cellctl.wording import REFERENCE_LANGUAGE, Line, Wording

_OF_A_FAULT = ("title", "remedy")
"""What the message files have of each fault. Its causes are for those who mend it."""

_REMEMBERED = 256
"""Translations of what was published."""

T = TypeVar("T", bound=Value)


class Sentences:
    """Puts the state of the cell into words.

    Args:
        wording: the messages of the cell's language.
        pitch_m: edge of a voxel.
        copies_limit: how many of a kind one visitor gets.
        available: how many parts there are to build with.
    """

    def __init__(
        self, wording: Wording, pitch_m: float, copies_limit: int, available: Callable[[], int]
    ) -> None:
        self.wording = wording
        self._pitch_m = pitch_m
        self._copies_limit = copies_limit
        self._available = available
        self._naming = Naming(wording)
        # The same few sentences are published again with every part.
        self._translated = lru_cache(_REMEMBERED)(wording.translated)

    def describe(
        self,
        state: str,
        job: Job | None,
        fault: CellFault | None,
        doubt: Doubt | None,
        ledger: Ledger,
        *,
        recalled: bool = False,
    ) -> Line:
        """The present state in words, with what to do where the cell waits for people.

        ``recalled``: this daemon found it so when it started.
        """
        own = {
            "idle": lambda: self.idle(job, ledger),
            "paused_resting": lambda: self.paused(job, doubt, ledger),
            "feeding_refilling": lambda: self.refilling(job, ledger),
        }
        if state in own:
            found = [self.wording.line("state.recalled")] if recalled else []
            return _joined([*found, own[state]()])
        if state.startswith("fault") and fault is not None and state != "fault_recovering":
            message, hint = map(self.wording.translated, (fault.message, fault.hint))
            return self._line("state.fault", message=message, hint=hint)
        if state == "validating_confirming" and job is not None and job.plan is not None:
            return self.question(job)
        if state.startswith(("assembling", "disassembling")):
            return self._working(state, job)
        return self._line(f"state.{state}")

    def for_visitors(self, state: str, fault: CellFault | None) -> Line | None:
        """What visitors are told where ``describe`` says what others have to do; None elsewhere."""
        if state == "feeding_refilling":
            return self._line("waits.no_parts")
        if state == "paused_resting":
            return self._line("waits.look")
        if state.startswith("fault") and fault is not None and state != "fault_recovering":
            return self._line(BY_FAULT[fault.code])
        return None

    def _line(self, key: str, **fields: object) -> Line:
        return self.wording.line(key, **fields)

    def _working(self, state: str, job: Job | None) -> Line:
        doing = self.wording.text(f"state.{state}")
        if job is None or job.plan is None:
            return Line(key=f"state.{state}", text=f"{doing}.", language=self.wording.language)
        total = len(job.plan.steps)
        return self._line(
            "state.working", doing=doing, part=min(job.placed + 1, total), total=total
        )

    def idle(self, job: Job | None, ledger: Ledger) -> Line:
        """What became of the last job, and what is needed before the next one."""
        count = len(ledger.standing)
        now = self._line("idle.occupied", count=count) if count else self._line("state.idle")
        if job is None or not job.message:
            return now
        return now.model_copy(update={"text": f"{job.message} {now.text}"})

    def paused(self, job: Job | None, doubt: Doubt | None, ledger: Ledger) -> Line:
        """What is believed of the cell while it stands still, and what it needs to go on."""
        said = [self._line("state.paused_resting")]
        active = job is not None and job.finished_s is None
        if active and job is not None and job.plan is not None:
            key = "paused.moved" if job.removes else "paused.placed"
            said = [self._line(key, done=job.placed, total=len(job.plan.steps))]
        if doubt is not None:
            place = self.wording.text(f"place.{doubt.believed}")
            sentence = self.wording.translated(doubt.sentence)
            said.append(self._line("paused.doubt", sentence=sentence, place=place))
            return _joined(said)
        if ledger.holding:
            said.append(self._line("paused.holding"))
        elif ledger.gripped is not None:
            said.append(self._line("paused.gripped"))
        if active and ledger.standing:
            said.append(self._line("paused.look"))
        return _joined([*said, self._line("paused.resume")])

    def refilling(self, job: Job | None, ledger: Ledger) -> Line:
        """What is needed when the belt has run empty."""
        if not ledger.counts.stock:
            return self._line("refilling.nothing_left")
        left = job.left_to_place if job is not None else 0
        return self._line("refilling.left", count=left)

    def question(self, job: Job) -> Line:
        """What is asked before the first motion."""
        plan = job.plan
        assert plan is not None, "a question is about a plan"
        if job.takes_apart:
            return self._line("ask.take_apart", amount=self._amount(len(plan.steps), plan))
        title = self.name(job)
        sizes = " x ".join(f"{edge * self._pitch_m * 100:.0f}" for edge in plan.assembly.size)
        said = (*(change.what for change in plan.changes), *plan.questions)
        notes = [*(self.wording.translated(text) for text in said), *self._counted(job)]
        asked = self._line(
            "ask.change_over" if job.removes else "ask.build",
            object=title[:1].upper() + title[1:] + self._source(plan),
            size=sizes,
            amount=self._amount(len(plan.assembly.cells), plan),
            notes="".join(f" {note}" for note in notes),
        )
        if not job.note:
            other = job.shows_another
            return self._line("ask.another", question=asked.text) if other else asked
        why = self.wording.translated(job.note)
        return self._line("ask.unchanged", why=why, question=asked.text)

    def _source(self, plan: BuildPlan) -> str:
        """Who made the shape, without details, where it was not designed here."""
        source = plan.provenance.partition(";")[0].partition(" (")[0].partition(": ")[0]
        named = source not in ("", "from a description")
        return f", {self.wording.translated(source)}" if named else ""

    def copies_left(self, job: Job) -> int:
        """How many more of its object come after the first; none where that would be too many."""
        wanted = job.request.count if job.request is not None else 1
        return wanted - 1 if 1 < wanted <= self._copies_possible(job) else 0

    def _copies_possible(self, job: Job) -> int:
        parts = job.plan.parts if job.plan is not None else 0
        return min(self._copies_limit, self._available() // parts) if parts else 1

    def _counted(self, job: Job) -> list[str]:
        """What is said to a wish for several of a kind."""
        if job.request is None or job.request.count <= 1 or len(job.request.objects) > 1:
            return []
        if self.copies_left(job):
            return [self.wording.text("ask.one_by_one")]
        most = self._copies_possible(job)
        if most > 1:
            return [self.wording.text("ask.too_many", most=most)]
        return [self.wording.text("ask.too_many_parts")]

    def name(self, job: Job) -> str:
        """What the job is about, in the cell's language where that knows it."""
        title = job.plan.title if job.plan is not None else ""
        return self._naming.title(job.request, title)

    def thing(self, job: Job) -> str:
        """The same with its article, such as ``a stool with four legs``; a file has a bare name."""
        name = self.name(job)
        english = self.wording.language == REFERENCE_LANGUAGE
        return with_article(name) if english and name and job.request is not None else name

    def _amount(self, parts: int, plan: BuildPlan) -> str:
        """How many parts, and how long they take where that is known."""
        amount = self.wording.text("count.parts", count=parts)
        known = [step.duration_s for step in plan.steps if step.duration_s is not None]
        if len(known) < len(plan.steps):
            return amount
        return f"{amount}, {self.about(sum(known))}"

    def about(self, seconds: float) -> str:
        """A duration as people say it: ``about 3 minutes``."""
        if seconds < 90:
            rounded = max(1, round(seconds / 10)) * 10
            duration = self.wording.text("count.seconds", count=rounded)
        else:
            duration = self.wording.text("count.minutes", count=round(seconds / 60))
        return self.wording.text("count.about", duration=duration)

    def refusal(self, error: CellctlError, role: Role) -> str:
        """Why a wish ended; to a visitor without what only an operator can use."""
        return self.wording.translated(str(error) if role is Role.OPERATOR else plainly(error))

    def shown(self, data: T) -> T:
        """What the bus shows, in the cell's language: names, changes, questions, and what faults
        say. Codes, figures, and what stands in logs stay as they are."""
        if self.wording.language == REFERENCE_LANGUAGE:
            return data
        translated, shown = self._translated, dict[str, object]()
        match data:
            case JobData():
                shown["title"] = self._naming.title(data.request, data.title)
                shown["questions"] = tuple(map(translated, data.questions))
                shown["changes"] = tuple(
                    Change(what=translated(change.what), why=translated(change.why))
                    for change in data.changes
                )
            case FaultData(entry=FaultEntry(code=code) as entry):
                told = {name: self.wording.text(f"fault.{code}.{name}") for name in _OF_A_FAULT}
                shown["entry"] = entry.model_copy(update=told)
                shown["detail"] = translated(data.detail)
                shown["later"] = tuple(map(translated, data.later))
        return data.model_copy(update=shown)

    def finished(self, job: Job) -> str:
        """What is said when the arm is home again."""
        assert job.plan is not None, "a job that moved the arm has a plan"
        if job.step is not None:
            return self.cancelled(job)
        if job.takes_apart:
            return self.wording.text("done.taken_apart")
        return self.wording.text("done.built", object=self.name(job))

    def cancelled(self, job: Job) -> str:
        """What is said when a job ended before its object was complete."""
        if job.plan is None or not job.placed:
            return self.wording.text("done.dropped")
        key = "done.stopped_moves" if job.removes else "done.stopped_parts"
        return self.wording.text(key, done=job.placed, total=len(job.plan.steps))


def _joined(lines: list[Line]) -> Line:
    """Several lines said in one breath; it goes by the last one's key, which is what counts."""
    return lines[-1].model_copy(update={"text": " ".join(line.text for line in lines)})
