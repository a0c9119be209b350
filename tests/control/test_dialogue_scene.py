"""What is offered is what the machine would take, in every state."""

from __future__ import annotations

import itertools

import pytest

from cellctl.control.dialogue.scene import Scene
from cellctl.control.states import LEAVES, MOTION_STATES, Event, decide

EVENTS = {
    "yes": Event.CONFIRM,
    "no": Event.DECLINE,
    "change": Event.CHANGE,
    "another": Event.CHANGE,
    "stop": Event.STOP,
    "cancel": Event.CANCEL,
    "take_apart": Event.TAKE_APART,
    "hand_over": Event.BOOK,
}


@pytest.mark.parametrize("state", LEAVES)
def test_only_what_the_machine_takes_is_offered(state: str) -> None:
    for active, takes_apart, standing in itertools.product((False, True), repeat=3):
        scene = Scene(state, "waiting", active, takes_apart, standing)
        for offer in scene.offers:
            if offer in EVENTS:
                assert decide(state, EVENTS[offer]).verdict == "accepted", (scene, offer)


@pytest.mark.parametrize("state", sorted(MOTION_STATES))
def test_stop_is_offered_whenever_the_arm_may_move(state: str) -> None:
    assert "stop" in Scene(state).offers


def test_a_yes_is_offered_only_where_something_is_asked() -> None:
    for state in LEAVES:
        scene = Scene(state, active=True)
        assert ("yes" in scene.offers) == bool(scene.question) == ("no" in scene.offers)


def test_nobody_is_asked_to_talk_to_closed_ears() -> None:
    assert "talk" in Scene("idle", "waiting").offers
    assert "talk" not in Scene("idle", "muted").offers
    assert "talk" not in Scene("idle", "off").offers
