"""The conversation, walked exhaustively: every place and input is decided, and only a yes moves."""

from __future__ import annotations

from collections import deque
from functools import cache

import pytest

from cellctl.control.dialogue.events import EVENTS_OF
from cellctl.control.dialogue.scene import Scene
from cellctl.control.dialogue.table import STRANGERS, TABLE, Act, Decision, Input, Place, decide
from cellctl.control.states import (
    COMMANDS,
    FAULTS,
    LEAVES,
    MOTION_STATES,
    TRANSITIONS,
    Event,
    top_of,
)

DECISIONS: dict[tuple[Place, Input, bool], Decision] = {
    (place, said, stranger): decide(place, said, stranger=stranger)
    for place in Place
    for said in Input
    for stranger in (False, True)
}
MACHINE = {
    (source, row.event): row.target or source for row in TRANSITIONS for source in row.sources
}
"""Where an event leads that the machine takes."""
CELL = frozenset(said for said in Input if said.value.startswith("cell_"))
ASKING = frozenset({Place.ASKING_BUILD, Place.ASKING_APART})


def test_every_pair_is_decided_once_and_for_all() -> None:
    assert len(DECISIONS) == len(Place) * len(Input) * 2
    for rows in (TABLE, STRANGERS):
        pairs = [(place, row.said) for row in rows for place in row.places]
        assert len(pairs) == len(set(pairs))
    assert {act for act, _ in ((d.act, d.place) for d in DECISIONS.values())} == set(Act)


def test_only_a_yes_of_the_owner_to_an_open_question_confirms() -> None:
    confirming = {key for key, decision in DECISIONS.items() if decision.act is Act.CONFIRM}
    assert confirming == {(place, Input.YES, False) for place in ASKING}


def test_only_a_yes_to_its_own_question_writes_off_what_stands() -> None:
    handing = {key[:2] for key, decision in DECISIONS.items() if decision.act is Act.HAND_OVER}
    assert handing == {(Place.ASKING_HAND_OVER, Input.YES)}


def test_silence_is_a_no_wherever_something_is_asked_and_nothing_elsewhere() -> None:
    for place in Place:
        assert decide(place, Input.SILENCE) == (
            decide(place, Input.NO)
            if place in ASKING | {Place.ASKING_HAND_OVER}
            else Decision(Act.NOTHING, place)
        )


@pytest.mark.parametrize("act", sorted(set(Act) - {Act.CONFIRM, Act.RESUME}))
def test_no_other_act_leads_to_motion(act: Act) -> None:
    """Whatever state the machine is in, and whatever its stages report afterwards."""
    for event in EVENTS_OF.get(act, ()):
        for state in LEAVES:
            if top_of(state) in {"feeding", "assembling", "disassembling"}:
                continue  # it moves already, by an earlier yes
            after = MACHINE.get((state, event))
            if after is not None:
                assert after not in MOTION_STATES, (act, state)
                assert not _without_a_person(after) & MOTION_STATES


@cache
def _without_a_person(start: str) -> frozenset[str]:
    """States that a machine reaches by itself, where the policy asks before it builds."""
    waived = {Event.PLANNED_WAIVED, Event.PLANNED_TAKING}
    alone = [e for e in Event if e not in COMMANDS | FAULTS | waived]
    found, queue = {start}, deque([start])
    while queue:
        state = queue.popleft()
        for event in alone:
            after = MACHINE.get((state, event), state)
            if after not in found:
                found.add(after)
                queue.append(after)
    return frozenset(found)


def test_the_machines_question_is_all_that_the_conversation_decides() -> None:
    """What else it passes on are words of command, and wishes that the machine takes at rest."""
    words = {Act.STOP, Act.PAUSE, Act.RESUME, Act.CANCEL}
    begins = {Act.BEGIN, Act.BEGIN_AGAIN, Act.TAKE_APART}
    books = {Act.HAND_OVER}
    asked = {Act.CONFIRM, Act.DECLINE, Act.CHANGE, Act.ANOTHER}
    assert EVENTS_OF.keys() - words - begins - books == asked
    for act in asked:
        for event in EVENTS_OF[act]:
            assert _taken(event) == {"validating_confirming"}
    for act in begins:
        for event in EVENTS_OF[act]:
            assert _taken(event) == {"idle"}


def _taken(event: Event) -> set[str]:
    return {state for state, taken in MACHINE if taken is event}


def test_a_voice_never_resets_a_fault() -> None:
    assert Event.RESET not in {event for events in EVENTS_OF.values() for event in events}
    for said in set(Input) - CELL:
        decision = decide(Place.FAULT, said)
        assert decision.place is Place.FAULT
        for event in EVENTS_OF.get(decision.act, ()):
            for state in ("fault_held", "fault_stopped", "fault_emergency"):
                assert MACHINE.get((state, event), state) == state


def test_a_word_of_command_is_passed_on_everywhere() -> None:
    for said in (Input.STOP, Input.PAUSE, Input.RESUME):
        for place in Place:
            for stranger in (False, True):
                assert DECISIONS[place, said, stranger].act.value == said.value


def test_what_is_asked_is_answered_everywhere_and_changes_nothing() -> None:
    for said in (Input.QUESTION, Input.REPEAT, Input.HELP, Input.NAME):
        for place in Place:
            decision = decide(place, said)
            assert decision.place is place
            assert decision.act not in EVENTS_OF


@pytest.mark.parametrize("place", Place)
def test_the_conversation_is_always_where_the_machine_is(place: Place) -> None:
    for state in LEAVES:
        for takes_apart in (False, True):
            scene = Scene(state, takes_apart=takes_apart, active=True)
            after = decide(place, scene.input).place
            asks = place is Place.ASKING_HAND_OVER and state == "idle"
            expected = "ready" if scene.phase == "ready" else None
            if scene.phase == "asking":
                expected = "asking_apart" if takes_apart else "asking_build"
            elif scene.phase in {"building", "taking_apart"}:
                expected = "working"
            assert after.value == ("asking_hand_over" if asks else expected or scene.phase)


def test_a_stranger_gets_no_more_than_the_owner() -> None:
    for place in Place:
        for said in Input:
            theirs, own = DECISIONS[place, said, True], DECISIONS[place, said, False]
            if theirs != own:
                assert place in ASKING
                assert theirs.act in {Act.NOT_YOURS, Act.QUEUE, Act.EXPLAIN}
                assert theirs.place is place
