"""What the visitor's view says of a cell, from a snapshot alone."""

from __future__ import annotations

import pytest

from cellctl.assembly import Change, Role, Utterance
from cellctl.errors import CATALOGUE
from cellctl.kiosk.visitor.telling import Need, beside, in_other_words, telling
from cellctl.messages import DialogueData, DialoguePhase, FaultData, JobData, StateData
from cellctl.wording import Line
from tests.kiosk.test_mirror import snapshot


def state(name: str) -> StateData:
    return StateData(state=name, previous="idle", event="x")


@pytest.mark.parametrize(
    ("name", "phase", "need"),
    [
        ("paused_resting", "waiting", "look"),
        ("paused_moving", "waiting", ""),
        ("paused_braking", "waiting", ""),
        ("feeding_refilling", "waiting", "parts"),
        ("fault_held", "fault", "help"),
        ("feeding_indexing", "building", ""),
        ("idle", "ready", ""),
    ],
)
def test_people_are_called_where_only_they_can_help(
    name: str, phase: DialoguePhase, need: Need
) -> None:
    assert telling(snapshot(state=state(name), dialogue=DialogueData(phase=phase))).need == need


@pytest.mark.parametrize("phase", ["building", "waiting", "fault"])
def test_what_others_say_meanwhile_is_not_told_of_the_job_under_way(phase: DialoguePhase) -> None:
    talk = DialogueData(phase=phase, heard="a small bench", understood="A small bench.")
    job = JobData(
        job_id="1",
        role=Role.VISITOR,
        utterance=Utterance(text="build me a table", source="text"),
        title="table",
    )
    now = telling(snapshot(state=state("assembling_placing"), dialogue=talk, job=job))
    assert (now.heard, now.understood) == ("build me a table", "Table")


def test_a_question_is_about_what_was_said_last() -> None:
    talk = DialogueData(phase="asking", question="build", heard="make it taller", understood="Yes.")
    job = JobData(
        job_id="1",
        role=Role.VISITOR,
        utterance=Utterance(text="a table", source="text"),
        title="table",
    )
    now = telling(snapshot(state=state("validating_confirming"), dialogue=talk, job=job))
    assert (now.heard, now.understood) == ("make it taller", "Yes.")


def test_a_fault_is_told_in_the_words_that_were_said_whatever_is_said_since() -> None:
    fault = FaultData(entry=CATALOGUE["belt_jam"], detail="Das Band lief.")
    waits = Line(key="waits.belt", text="Mein Band bringt mir keine Teile.", language="de")
    answer = Line(key="answer.queue_empty", text="Niemand wartet.", language="de")
    talk = DialogueData(phase="fault", line=answer, waits=waits)
    now = telling(snapshot(state=state("fault_held"), dialogue=talk, fault=fault))
    assert (now.sentence, now.language) == ("Mein Band bringt mir keine Teile.", "de")


@pytest.mark.parametrize(
    ("sentence", "left"),
    [
        ("Shall I build it?", ""),
        ("A stool, 30 parts. One leg moved in. Shall I build it?", "A stool, 30 parts."),
        ("A stool, 30 parts. Shall I change it?", "A stool, 30 parts. Shall I change it?"),
    ],
)
def test_what_the_screen_says_elsewhere_is_not_said_twice(sentence: str, left: str) -> None:
    changes = (Change(what="One leg moved in.", why="It would come apart."),)
    assert beside(sentence, "Shall I build it?", changes) == left


@pytest.mark.parametrize(
    ("heard", "understood", "differs"),
    [
        ("I would like a table with three legs", "A table with three legs.", False),
        ("a table with three legs", "A table with three legs.", False),
        ("I would like a table", "Table", False),
        ("make it taller", "All right, I see whether I can.", True),
        ("a stole with four legs", "A stool with four legs.", True),
        ("a stool", "", False),
    ],
)
def test_what_was_heard_and_understood_is_shown_once_where_it_is_the_same(
    heard: str, understood: str, differs: bool
) -> None:
    assert in_other_words(heard, understood) == differs


def test_what_was_changed_is_told_only_of_what_is_to_be_built() -> None:
    change = Change(what="One leg moved in.", why="It would come apart.")
    job = JobData(job_id="1", role=Role.VISITOR, title="table", changes=(change,))
    for question, told in (("build", (change,)), ("take_apart", ()), ("hand_over", ())):
        talk = DialogueData.model_validate({"phase": "asking", "question": question})
        now = telling(snapshot(state=state("idle"), dialogue=talk, job=job))
        assert now.changes == told
