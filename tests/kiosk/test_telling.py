"""What the visitor's view says of a cell, from a snapshot alone."""

from __future__ import annotations

import pytest

from cellctl.assembly import Role, Utterance
from cellctl.kiosk.visitor.telling import Need, telling
from cellctl.messages import DialogueData, DialoguePhase, JobData, StateData
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


@pytest.mark.parametrize("phase", ["building", "taking_apart", "waiting", "fault"])
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
