"""What a page is told to be possible is what the conversation and the machine take, everywhere."""

from __future__ import annotations

import itertools

import pytest

from cellctl.control.dialogue.events import EVENTS_OF
from cellctl.control.dialogue.scene import Scene
from cellctl.control.dialogue.table import Act, Input, Place, decide
from cellctl.control.possible import possible
from cellctl.control.states import LEAVES, Event
from cellctl.control.states import decide as machine

SAID = {
    "confirm": Input.YES,
    "another": Input.ANOTHER,
    "say": Input.WISH,
    "take_apart": Input.TAKE_APART,
    "hand_over": Input.HAND_OVER,
    "stop": Input.STOP,
    "pause": Input.PAUSE,
    "cancel": Input.CANCEL,
}
"""Commands of the visitor's door, and what they are for the conversation; ``say``: at its best."""
WITHOUT_THE_MACHINE = {Act.QUEUE, Act.ASK_HAND_OVER, Act.LEAVE}
"""Acts that do something all the same."""
ALREADY = {("pause", "paused_braking"), ("pause", "paused_resting")}
"""Taken, and of no effect."""


def does(state: str, place: Place, command: str) -> bool:
    """Whether a command does something at a place, whoever gives it."""
    acts = {decide(place, SAID[command], stranger=stranger).act for stranger in (False, True)}
    events = {event for act in acts for event in EVENTS_OF.get(act, ())}
    if command == "hand_over":
        events.add(Event.BOOK)  # an operator says it without being asked again
    taken = any(machine(state, event).verdict == "accepted" for event in events)
    return taken or bool(acts & WITHOUT_THE_MACHINE)


@pytest.mark.parametrize("state", LEAVES)
def test_what_is_possible_is_what_does_something_at_every_place(state: str) -> None:
    for asks_hand_over, takes_apart in itertools.product((False, True), repeat=2):
        if asks_hand_over and state != "idle":
            continue
        scene = Scene(state, active=True, takes_apart=takes_apart, hand_over=asks_hand_over)
        before = Place.ASKING_HAND_OVER if asks_hand_over else Place.STARTING
        place = decide(before, scene.input).place
        told = possible(state, asks_hand_over=asks_hand_over, takes_apart=takes_apart)
        for command in SAID:
            expected = does(state, place, command) and (command, state) not in ALREADY
            assert (command in told) == expected, (command, place, told)
