"""The machine, walked exhaustively: every state and event is decided, and nothing wedges."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

import pytest
from transitions.extensions import HierarchicalMachine

from cellctl.control.states import (
    COMMANDS,
    FAULTS,
    LEAVES,
    MOTION_STATES,
    TRANSITIONS,
    Decision,
    Event,
    decide,
    leaves_of,
    top_of,
)

DECISIONS: dict[tuple[str, Event], Decision] = {
    (state, event): decide(state, event) for state in LEAVES for event in Event
}


def reachable(start: str, follow: Callable[[str, Event], bool]) -> set[str]:
    """All states that can be reached from one by the events that ``follow`` lets through."""
    found, queue = {start}, deque([start])
    while queue:
        state = queue.popleft()
        for event in Event:
            decision = DECISIONS[state, event]
            if follow(state, event) and decision.state not in found:
                found.add(decision.state)
                queue.append(decision.state)
    return found


def test_every_pair_is_decided_once_and_for_all() -> None:
    assert len(DECISIONS) == len(LEAVES) * len(Event)
    for (state, event), decision in DECISIONS.items():
        assert decision.state in LEAVES, (state, event)
        if decision.verdict != "accepted":
            assert decision.state == state, (state, event)


def test_a_command_is_never_ignored_and_a_result_never_refused() -> None:
    for (state, event), decision in DECISIONS.items():
        if event in COMMANDS:
            assert decision.verdict != "ignored", (state, event)
        else:
            assert decision.verdict != "refused", (state, event)


def test_a_refusal_says_why() -> None:
    for pair, decision in DECISIONS.items():
        assert bool(decision.reason) == (decision.verdict == "refused"), pair


def test_the_table_is_what_the_machine_does() -> None:
    table = {
        (source, row.event): row.target or source for row in TRANSITIONS for source in row.sources
    }
    accepted = {
        pair: decision.state
        for pair, decision in DECISIONS.items()
        if decision.verdict == "accepted"
    }
    assert accepted == table


def test_no_pair_stands_twice_in_the_table() -> None:
    pairs = [(source, row.event) for row in TRANSITIONS for source in row.sources]
    assert len(pairs) == len(set(pairs))


@pytest.mark.parametrize("state", LEAVES)
def test_every_state_can_be_reached_and_left_to_idle(state: str) -> None:
    assert state in reachable("starting", lambda _state, _event: True)
    assert "idle" in reachable(state, lambda _state, _event: True)


@pytest.mark.parametrize("state", leaves_of("fault"))
def test_nothing_leads_from_a_fault_to_motion_without_a_reset(state: str) -> None:
    without_reset = reachable(state, lambda _state, event: event is not Event.RESET)
    if state == "fault_recovering":
        without_reset = reachable("fault_held", lambda _state, event: event is not Event.RESET)
    assert not without_reset & MOTION_STATES
    assert {top_of(other) for other in without_reset} == {"fault"}


@pytest.mark.parametrize("state", leaves_of("fault", "paused"))
def test_nothing_leads_to_motion_without_a_persons_command(state: str) -> None:
    alone = reachable(state, lambda _state, event: event not in COMMANDS)
    # A movement by hand was commanded already, and leads to no other.
    assert not (alone - {state}) & MOTION_STATES


@pytest.mark.parametrize("state", LEAVES)
def test_stop_is_accepted_everywhere_and_ends_motion(state: str) -> None:
    decision = DECISIONS[state, Event.STOP]
    assert decision.verdict == "accepted"
    assert decision.state not in MOTION_STATES
    assert top_of(decision.state) in {"idle", "paused", "fault"}


@pytest.mark.parametrize("state", leaves_of("assembling", "feeding"))
def test_stop_during_a_build_brakes_and_rests(state: str) -> None:
    assert DECISIONS[state, Event.STOP].state == "paused_braking"
    assert DECISIONS["paused_braking", Event.AT_REST].state == "paused_resting"


@pytest.mark.parametrize("state", LEAVES)
def test_an_emergency_is_taken_in_every_state(state: str) -> None:
    assert DECISIONS[state, Event.FAULT_EMERGENCY].state == "fault_emergency"


@pytest.mark.parametrize("event", sorted(FAULTS))
def test_a_fault_never_becomes_a_lesser_one(event: Event) -> None:
    severity = ["fault_held", "fault_stopped", "fault_emergency"]
    for before in severity:
        after = DECISIONS[before, event].state
        assert severity.index(after) >= severity.index(before)


def test_reset_clears_a_fault_to_paused_and_to_nothing_else() -> None:
    for state in ("fault_held", "fault_stopped", "fault_emergency"):
        assert DECISIONS[state, Event.RESET].state == "fault_recovering"
    assert DECISIONS["fault_recovering", Event.RECOVERED].state == "paused_resting"
    left = {
        decision.state
        for (state, _), decision in DECISIONS.items()
        if top_of(state) == "fault" and top_of(decision.state) != "fault"
    }
    assert left == {"paused_resting"}


@pytest.mark.parametrize("state", leaves_of("assembling"))
def test_pause_and_cancel_wait_for_the_next_safe_point(state: str) -> None:
    for event in (Event.PAUSE, Event.CANCEL):
        assert DECISIONS[state, event] == Decision("accepted", state)
    assert DECISIONS[state, Event.PAUSE_NOW].state == "paused_braking"


def test_only_a_resume_leads_out_of_a_pause_or_a_stop() -> None:
    left = {
        event
        for event in Event
        if top_of(DECISIONS["paused_resting", event].state) not in {"paused", "fault"}
    }
    assert left == {event for event in Event if event.value.startswith("resume_")}


def test_what_people_say_of_parts_is_taken_at_rest_only_and_moves_nothing() -> None:
    accepting = {state for state in LEAVES if DECISIONS[state, Event.BOOK].verdict == "accepted"}
    assert accepting == {"idle", "paused_resting", "fault_held", "fault_stopped", "fault_emergency"}
    assert all(DECISIONS[state, Event.BOOK].state == state for state in accepting)


def test_parts_may_be_laid_on_the_belt_at_any_time_and_end_only_the_wait_for_them() -> None:
    for state in LEAVES:
        goes_on = "feeding_indexing" if state == "feeding_refilling" else state
        assert DECISIONS[state, Event.REFILL] == Decision("accepted", goes_on)


@pytest.mark.parametrize("state", LEAVES)
def test_a_hand_moves_the_arm_out_of_a_pause_and_into_it_only(state: str) -> None:
    decision = DECISIONS[state, Event.HAND]
    if state == "paused_resting":
        assert decision == Decision("accepted", "paused_moving")
    else:
        assert decision.verdict == "refused"
    for event in Event:
        after = DECISIONS["paused_moving", event].state
        assert top_of(after) in {"paused", "fault"}, event


def test_a_hand_movement_can_be_ended_by_its_end_a_stop_a_pause_and_a_fault() -> None:
    ends = {event for event in Event if DECISIONS["paused_moving", event].state != "paused_moving"}
    assert ends == {Event.HAND_DONE, Event.STOP, Event.PAUSE, *FAULTS}


def test_what_is_left_over_from_before_is_never_taken_up_without_a_person() -> None:
    assert DECISIONS["starting", Event.RECALLED].state == "paused_resting"
    after = reachable("paused_resting", lambda _state, event: event not in COMMANDS)
    assert {top_of(state) for state in after} == {"paused", "fault"}


def test_a_missed_pick_is_no_fault() -> None:
    assert DECISIONS["assembling_placing", Event.PICK_AGAIN].state == "feeding_indexing"


# What the library has got wrong before, where this design would meet it if it used it so.


def test_library_a_trigger_that_is_not_valid_leaves_the_state_alone() -> None:
    machine = HierarchicalMachine(
        states=["a", {"name": "b", "children": ["x", "y"]}],
        transitions=[{"trigger": "go", "source": "a", "dest": "b_x"}],
        initial="a",
        auto_transitions=False,
        ignore_invalid_triggers=True,
    )
    assert machine.trigger("go")
    assert not machine.trigger("go")
    assert machine.state == "b_x"


def test_library_a_nested_event_is_decided_by_the_leaf_and_fires_once() -> None:
    fired: list[str] = []
    machine = HierarchicalMachine(
        states=[{"name": "b", "children": ["x", "y"]}, "c"],
        transitions=[
            {"trigger": "go", "source": "b_x", "dest": "b_y", "after": lambda: fired.append("x")},
            {"trigger": "go", "source": "b_y", "dest": "c", "after": lambda: fired.append("y")},
        ],
        initial="b_x",
        auto_transitions=False,
    )
    machine.trigger("go")
    assert (machine.state, fired) == ("b_y", ["x"])


def test_library_a_trigger_inside_a_callback_is_not_needed() -> None:
    """The machine has no callbacks: an event is over before the next one begins."""
    assert all(set(vars(row)) == {"event", "sources", "target"} for row in TRANSITIONS)
