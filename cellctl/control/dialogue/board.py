"""What people see and hear of the conversation: the topic ``dialogue``, and lines said aloud."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime, timedelta

from cellctl.clock import Clock
from cellctl.control.cell import Cell
from cellctl.control.dialogue.naming import Naming
from cellctl.control.dialogue.questions import Questions
from cellctl.control.dialogue.scene import Scene
from cellctl.messages import (
    DialogueData,
    EarsCondition,
    QueueEntry,
    SpeechData,
    StateData,
    StatusData,
)
from cellctl.speaking import Speaker
from cellctl.wording import Line

_SAID = ("ask.", "idle.", "done.", "waits.", "state.idle")
"""Beginnings of the keys of sentences that are said when the state changes; others are shown."""
_WAITS_FOR_PEOPLE = frozenset({"waiting", "fault"})


class DialogueBoard:
    """Follows what the daemon publishes, and tells the conversation's side of it.

    Args:
        cell: what the conversation is about.
        clock: tells the calendar time.
        ears: whether the cell listens.
        queue: the wishes that wait.
        speaker: says lines aloud.
        publish: sends a status message.
    """

    def __init__(
        self,
        cell: Cell,
        clock: Clock,
        *,
        ears: Callable[[], EarsCondition],
        queue: Callable[[], tuple[QueueEntry, ...]],
        speaker: Speaker,
        publish: Callable[[StatusData], None],
    ) -> None:
        self._cell = cell
        self._clock = clock
        self._ears = ears
        self._queue = queue
        self._naming = Naming(cell.sentences.wording)
        self._hand_over = False
        self._speaker = speaker
        self._publish = publish
        self._number = 0
        self.questions = Questions()
        """Those asked lately, by name."""
        self.asked = ""
        """Words of the newest."""
        self.data = self._told = DialogueData(phase="starting")
        """What the bus shows."""

    def note(self, data: StatusData) -> None:
        """Something was published: tell what follows from it for the conversation."""
        match data:
            case SpeechData():
                self._heard(data)
            case StateData() if data.state != data.previous:
                self._entered(data.state)
        self.refresh()

    def say(self, line: Line) -> None:
        """Say a line: on the screen, and aloud."""
        self._number += 1
        said = line.model_copy(update={"number": self._number})
        self._change(line=said)
        self._speaker.say(said)
        self.refresh()

    def refresh(self) -> None:
        """Publish, where anything has changed."""
        scene = self.scene()
        self._change(
            phase=scene.phase,
            question=scene.question,
            offers=scene.offers,
            speaking=self._speaker.speaking,
            queue=self._queue(),
            waits=self._cell.line if scene.phase in _WAITS_FOR_PEOPLE else None,
        )
        job = self._cell.active_job
        if job is not None:
            self._change(owner=job.owner, owner_name=job.owner_name)
        if scene.phase != "asking":
            self.questions.close()
            self._change(deadline=None)
        self._change(asked=self.questions.open)
        if self.data != self._told:
            self._told = self.data
            self._publish(self.data)

    def scene(self) -> Scene:
        """What the conversation is about now."""
        job = self._cell.active_job
        return Scene(
            state=self._cell.controller.state,
            ears=self._ears(),
            active=job is not None,
            takes_apart=job is not None and job.takes_apart,
            standing=bool(self._cell.builder.standing),
            hand_over=self._hand_over,
        )

    def heard(self, text: str) -> None:
        """Somebody said or typed something."""
        self._change(heard=text, understood="")

    def hush(self) -> None:
        """Stop speaking."""
        self._speaker.hush()
        self.refresh()

    def ask_hand_over(self, deadline: datetime | None, line: Line | None = None) -> None:
        """It is asked whether somebody takes along what stands; None: no longer."""
        self._hand_over = deadline is not None
        if line is not None:
            self._ask(line)
        self._change(deadline=deadline)
        self._cell.asks_hand_over(self._hand_over)
        self.refresh()

    def _heard(self, data: SpeechData) -> None:
        request = data.request
        if request is None or not request.buildable:
            self._change(heard=data.utterance.text)
            return
        wish = self._naming.wish(request)
        line = self._cell.sentences.wording.line(
            "understood.wish", wish=wish[:1].upper() + wish[1:]
        )
        self._change(heard=data.utterance.text, understood=line.text)
        self.say(line)

    def _entered(self, state: str) -> None:
        line = self._cell.line
        if state == "validating_confirming":
            config = self._cell.config
            open_s = config.policy.confirmation_timeout_s / config.cell.clock_rate
            self._change(deadline=self._clock.wall_time() + timedelta(seconds=open_s))
            self._ask(line)
        if line.key.startswith(_SAID):
            self.say(line)

    def _ask(self, line: Line) -> None:
        """A question is open from now on."""
        self.asked = line.text
        self.questions.ask(line.text, aloud=self._speaker.aloud)

    def _change(self, **changes: object) -> None:
        self.data = self.data.model_copy(update=changes)
