"""A yes counts for the question that it was an answer to, whatever comes between them."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from cellctl.control.controller import Controller, Post
from cellctl.control.daemon import Daemon
from cellctl.control.dialogue.questions import Questions
from cellctl.control.states import Event
from cellctl.errors import CellctlError, RefusedError
from cellctl.speaking.events import Began
from tests.cell.harness import cell_config

TO_THE_QUESTION = (
    *(Event.STARTED, Event.SAY, Event.UNDERSTOOD),
    *(Event.DESIGNED, Event.DISCRETISED, Event.CHECKED, Event.PLANNED),
)
TIMES = st.floats(0.0, 60.0)


class Asking:
    """Stages that do nothing, behind a machine that asks."""

    def __init__(self) -> None:
        self.questions = Questions()
        self.names: list[str] = []
        self.begun: list[str] = []
        """The question that was open whenever a build began."""

    async def run_stage(self, name: str, post: Post) -> None:  # noqa: ARG002 - does nothing
        await asyncio.Event().wait()

    def request_ended(self, error: CellctlError) -> None:
        raise AssertionError(error)

    def changed(self, event: Event, before: str, after: str) -> None:  # noqa: ARG002
        if after == "feeding_indexing" and before == "validating_confirming":
            self.begun.append(self.questions.open)
        if after == "validating_confirming":
            self.names.append(self.questions.ask(f"question {len(self.names)}", aloud=False))
        else:
            self.questions.close()


@given(
    st.lists(
        st.one_of(
            st.just("change"),
            st.just("asked again"),
            st.tuples(st.just("yes"), st.integers(0, 4)),
            st.just("let it work"),
        ),
        max_size=12,
    )
)
@settings(max_examples=50, deadline=None)
def test_only_a_yes_to_the_open_question_begins_a_build(steps: list[str | tuple[str, int]]) -> None:
    async def life() -> None:
        stages = Asking()
        controller = Controller(stages, lambda _data, _state: None)
        questions = stages.questions
        running = asyncio.create_task(controller.run())
        for event in TO_THE_QUESTION:
            controller.post(event)
        await controller.probe()
        assert controller.state == "validating_confirming"
        answers: list[tuple[str, asyncio.Task[object]]] = []
        for step in steps:
            match step:
                case "change":
                    controller.post(Event.CHANGE)
                case "asked again":
                    controller.post(Event.KEPT)
                case "let it work":
                    await controller.probe()
                case (_, back):
                    name = stages.names[max(0, len(stages.names) - 1 - int(back))]
                    unless = _unless(questions, name)
                    yes = controller.command(Event.CONFIRM, unless=unless)
                    answers.append((name, asyncio.create_task(yes)))
                    await asyncio.sleep(0)  # it is in the inbox, behind what came before
        told = await asyncio.gather(*(task for _, task in answers), return_exceptions=True)
        taken = [
            name
            for (name, _), reply in zip(answers, told, strict=True)
            if not isinstance(reply, RefusedError)
        ]
        assert taken == stages.begun
        running.cancel()
        await asyncio.gather(running, return_exceptions=True)

    asyncio.run(life())


def _unless(questions: Questions, name: str) -> Callable[[], str]:
    return lambda: "" if questions.is_open(name) else "That was another question."


@given(st.lists(st.tuples(TIMES, st.one_of(st.none(), TIMES)), min_size=1, max_size=6), TIMES)
def test_speech_answers_no_question_whose_words_had_not_begun(
    asked: list[tuple[float, float | None]], spoken_s: float
) -> None:
    """Each question is asked at a moment, and voiced so long after it, or left to the screen."""
    now_s = 0.0
    questions = Questions(lambda: now_s)
    heard_from: dict[str, float] = {}
    asked = sorted(asked, key=lambda one: one[0])
    voices: list[tuple[float, str]] = []
    for number, (at_s, delay_s) in enumerate(asked):
        now_s = at_s
        text = f"question {number}"
        name = questions.ask(text, aloud=delay_s is not None)
        heard_from[name] = at_s + (delay_s or 0.0)
        if delay_s is not None:
            voices.append((heard_from[name], text))
    for at_s, text in voices:
        questions.voiced(text, at_s)
    meant = questions.meant(spoken_s)
    could = [name for name, from_s in heard_from.items() if from_s <= spoken_s]
    assert meant == (could[-1] if could else "")
    if questions.is_open(meant):
        assert heard_from[meant] <= spoken_s


def test_the_daemons_voice_tells_when_a_question_is_heard(tmp_path: Path) -> None:
    made = Daemon(cell_config(journal={"path": str(tmp_path / "journal.db")}))
    try:
        questions = made.dialogue.questions
        name = questions.ask("Shall I build it?", aloud=True)
        for heed in made.voice.heeded_by:
            heed(Began(number=1, at_s=5.0, envelope=()), "Shall I build it?")
        assert questions.meant(4.9) == ""
        assert questions.meant(5.1) == name
    finally:
        made.bus.close()


def test_a_question_that_is_never_said_aloud_can_be_answered() -> None:
    """Somebody spoke meanwhile, so that it was left to the screen."""
    questions = Questions(lambda: 1.0)
    name = questions.ask("Shall I build it?", aloud=True)
    assert questions.meant(2.0) == ""
    questions.voiced("Something else.", 2.0)
    assert questions.meant(3.0) == ""
    questions.voiced("Shall I build it?", 3.0)
    assert questions.meant(2.9) == ""
    assert questions.is_open(questions.meant(3.1))
    questions.close()
    assert questions.meant(3.1) == name
    assert not questions.is_open(name)
