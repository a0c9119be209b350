"""Which commands the machine would take in a state, from its table: so that a page knows."""

from __future__ import annotations

from functools import cache
from typing import Final

from cellctl.control.states import TRANSITIONS, Event, top_of

_EVENTS: Final[dict[str, tuple[Event, ...]]] = {
    "say": (Event.SAY, Event.CHANGE),
    "hear": (Event.HEAR,),
    "build": (Event.BUILD,),
    "take_apart": (Event.TAKE_APART,),
    "confirm": (Event.CONFIRM,),
    "another": (Event.CHANGE,),
    "pause": (Event.PAUSE,),
    "resume": (Event.RESUME_IDLE,),
    "cancel": (Event.CANCEL,),
    "reset": (Event.RESET,),
    "refill": (Event.REFILL,),
    "hand": (Event.HAND,),
    **dict.fromkeys(("clear", "hand_over", "missing", "count", "own"), (Event.BOOK,)),
    "recover": (Event.RESUME_IDLE,),
}
"""Commands whose fate is the table's; any of the events will do."""
_KEEPING: Final = frozenset(
    {"listening", "generating", "validating", "feeding", "assembling", "disassembling"}
)
"""States in which a visitor's wish is kept until its turn comes."""
_ALREADY: Final = frozenset({"paused_braking", "paused_resting"})
"""States in which a pause is taken, and changes nothing."""


@cache
def possible(
    state: str, *, asks_hand_over: bool = False, takes_apart: bool = False
) -> tuple[str, ...]:
    """The commands that can lead on from a state, sorted; ``stop`` always can.

    Args:
        state: the machine's.
        asks_hand_over: the conversation asks at rest whether somebody takes along what stands.
        takes_apart: the job under way takes apart what stands, of which there is one way only.

    What else must be so is known only when one is given: a part that is missing, a place that is
    empty. The reply says it then.
    """
    events = {row.event for row in TRANSITIONS if state in row.sources}
    found = {name for name, ways in _EVENTS.items() if events.intersection(ways)} | {"stop"}
    if top_of(state) in _KEEPING and state != "feeding_refilling":
        found.add("say")
    if state in _ALREADY:
        found.discard("pause")
    if asks_hand_over and state == "idle":
        found |= {"confirm", "cancel"}
    if takes_apart:
        found.discard("another")
    if top_of(state) in {"idle", "fault"} or state == "paused_resting":
        found.add("gripper")
    return tuple(sorted(found))
