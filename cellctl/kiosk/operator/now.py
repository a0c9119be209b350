"""The head of the operator's view: what the cell does, and what leads on from there."""

from __future__ import annotations

from typing import Final

from cellctl.kiosk.components import Button, Text, asked_of, attribute, box, shown
from cellctl.kiosk.operator.desk import Desk
from cellctl.kiosk.shell import duration
from cellctl.messages import ConfirmCommand, MuteCommand, PlainCommand, Snapshot

_FAULTS: Final = {"fault_held", "fault_stopped", "fault_emergency"}
"""States in which nothing moves before a reset."""


def order(name: str) -> PlainCommand:
    """One of the commands without arguments."""
    return PlainCommand.model_validate({"command": name})


class Now:
    """State, sentence, job, and the buttons that are always there."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._asked = ""
        """Name of the question that yes was pressed for."""
        words = desk.words
        with box("section", "now", aria_label=words.say("op.now")) as self._whole:
            with box("div", "now__words"):
                with box("p", "now__where"):
                    self._state = Text("span", "", "now__state")
                    self._detail = Text("span", "", "now__detail")
                self._sentence = Text("h1", "", "now__sentence")
                self._job = Text("p", "", "now__job")
                self._stale = Text("p", "", "now__stale")
                self._stale.props["role"] = "status"
            with box("div", "now__actions"):
                self._buttons = self._make_buttons()

    def _make_buttons(self) -> dict[str, Button]:
        desk, say = self._desk, self._desk.words.say
        plain = desk.ordering

        return {
            "stop": Button(say("act.stop"), plain(order("stop")), kind="danger", picture="stop"),
            "yes": Button(
                say("act.yes"),
                desk.asking_first("confirm", self._agree, self._what_a_yes_does),
                picture="yes",
            ),
            "no": Button(
                say("act.no"), plain(ConfirmCommand(answer=False, asked="")), picture="no"
            ),
            "reset": Button(say("act.reset"), plain(order("reset")), kind="strong"),
            "resume": Button(
                say("act.resume"),
                desk.asking_first("resume", plain(order("resume")), self._what_resumes),
                kind="strong",
                picture="play",
            ),
            "pause": Button(say("act.pause"), plain(order("pause")), picture="pause"),
            "cancel": Button(
                say("act.cancel"), desk.asking_first("cancel", plain(order("cancel")))
            ),
            "unmute": Button(
                say("act.unmute"), plain(MuteCommand(command="unmute")), picture="mic"
            ),
            "mute": Button(say("act.mute"), plain(MuteCommand(command="mute")), picture="muted"),
        }

    async def _agree(self) -> None:
        """A yes to the question that stood there when it was pressed, and to no later one."""
        await self._desk.order(ConfirmCommand(answer=True, asked=self._asked))

    def _what_a_yes_does(self) -> str:
        """What a yes to the open question leads to."""
        snapshot = self._desk.snapshot
        self._asked = self._buttons["yes"].asked
        hands_over = snapshot is not None and snapshot.dialogue.question == "hand_over"
        return self._desk.words.say("sure.hand_over" if hands_over else "sure.confirm")

    def _what_resumes(self) -> str:
        """What resuming will do, and what it takes for granted."""
        snapshot, words = self._desk.snapshot, self._desk.words
        assert snapshot is not None, "resume is offered for a cell that is known"
        under_way = snapshot.job is not None and not snapshot.job.outcome
        told = words.say("sure.resume_job" if under_way else "sure.resume_idle")
        return f"{told} {words.say('sure.resume_doubt')}" if snapshot.doubt else told

    def show(self) -> None:
        """Show the cell as it is known now."""
        desk, words, mirror = self._desk, self._desk.words, self._desk.page.site.mirror
        snapshot = mirror.snapshot
        if snapshot is None:
            self._state.say(words.say("page.connecting"))
            self._sentence.say(words.say("page.never_sentence"))
        else:
            top, _, sub = snapshot.state.state.partition("_")
            attribute(self._whole, "data-state", top)
            self._state.say(words.say(f"state.{top}"))
            self._detail.show(words.say(f"state.{snapshot.state.state}") if sub else "")
            below = _told_below(snapshot)
            told = words.say(below) if below else snapshot.state.sentence
            self._sentence.say(told or words.say(f"state.{top}"))
        self._job.show(_job(desk, snapshot) if snapshot is not None else "")
        age = duration(words, mirror.age_s) if mirror.stale and snapshot is not None else ""
        self._stale.show(words.say("page.stale_sentence", age=age) if age else "")
        self._show_buttons(snapshot)

    def _show_buttons(self, snapshot: Snapshot | None) -> None:
        desk = self._desk
        for name in ("reset", "resume", "pause", "cancel"):
            possible = desk.takes(name)
            self._buttons[name].enable(possible)
            shown(self._buttons[name], possible or name == "pause")
        asked_of(self._whole, snapshot.dialogue.asked if snapshot is not None else "")
        for name in ("yes", "no"):
            shown(self._buttons[name], desk.takes("confirm"))
        ears = snapshot.ears.state if snapshot is not None else "off"
        shown(self._buttons["unmute"], ears == "muted")
        shown(self._buttons["mute"], ears not in {"muted", "off", "lost"})


def _told_below(snapshot: Snapshot) -> str:
    """Key of what leads on to the panel right below, which tells all of it; empty without one."""
    state = snapshot.state.state
    if state in _FAULTS:
        return "op.fault"
    return "op.doubt" if state == "paused_resting" and snapshot.doubt else ""


def _job(desk: Desk, snapshot: Snapshot) -> str:
    """The job in a line."""
    job, words = snapshot.job, desk.words
    if job is None:
        return ""
    what = job.title or (job.utterance.text if job.utterance is not None else job.job_id)
    outcome = words.say(f"outcome.{job.outcome or 'open'}")
    if not job.parts_total:
        return f"{what} · {outcome}"
    done = words.say("op.parts_done", done=job.parts_placed, total=job.parts_total)
    return f"{what} · {done} · {outcome}"
