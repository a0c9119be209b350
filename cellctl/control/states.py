"""The cell's state machine: states and transitions, and nothing else. No I/O, no clocks.

``decide`` answers every pair of state and event: *accepted* (with the state it leads to, which may
be the same), *ignored* (a result that came too late to matter) or *refused* (a command that this
state does not allow, with the reason). The diagram in the docs is drawn from ``TRANSITIONS``.

Deferred commands: ``pause`` and ``cancel`` are accepted while the arm works, without a change of
state; the controller posts ``pause_now`` or ``wind_up`` at the next safe point.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from typing import Literal

from transitions.extensions import HierarchicalMachine


class Event(StrEnum):
    """Everything that can happen to the machine."""

    # Results of the stages and devices.
    STARTED = "started"
    RECALLED = "recalled"
    """Started, and something is left over from before: a job, or a part in doubt."""
    SPEECH_STARTED = "speech_started"
    HEARD = "heard"
    REJECTED = "rejected"
    UNDERSTOOD = "understood"
    DESIGNED = "designed"
    DISCRETISED = "discretised"
    CHECKED = "checked"
    PLANNED = "planned"
    KEPT = "kept"
    """A change cannot be made: what was planned before is asked about again."""
    PLANNED_WAIVED = "planned_waived"
    PLANNED_TAKING = "planned_taking"
    """Planned, confirmation waived, and a part is to be taken off first."""
    BELT_EMPTY = "belt_empty"
    PART_NEAR = "part_near"
    PART_READY = "part_ready"
    PICKED = "picked"
    PICK_AGAIN = "pick_again"
    PLACED = "placed"
    NEXT_PART_READY = "next_part_ready"
    NEXT_PART_AWAITED = "next_part_awaited"
    NEXT_PART_STANDS = "next_part_stands"
    """The next step takes a part off."""
    GRIPPED = "gripped"
    GRIP_AGAIN = "grip_again"
    PARTED = "parted"
    PARTED_TO_PLACE = "parted_to_place"
    """The part that was taken off is the one to be placed next."""
    RETURNED = "returned"
    WIND_UP = "wind_up"
    COMPLETED = "completed"
    PAUSE_NOW = "pause_now"
    AT_REST = "at_rest"
    HAND_DONE = "hand_done"
    RECOVERED = "recovered"
    FAULT_HELD = "fault_held"
    FAULT_STOPPED = "fault_stopped"
    FAULT_EMERGENCY = "fault_emergency"
    # Commands of people.
    SAY = "say"
    HEAR = "hear"
    BUILD = "build"
    TAKE_APART = "take_apart"
    CONFIRM = "confirm"
    CONFIRM_TAKING = "confirm_taking"
    """``confirm`` where a part is to be taken off first."""
    DECLINE = "decline"
    CHANGE = "change"
    """Instead of yes or no: change what is planned, or plan something else."""
    PAUSE = "pause"
    STOP = "stop"
    CANCEL = "cancel"
    RESET = "reset"
    REFILL = "refill"
    BOOK = "book"
    """A person says what became of parts: cleared, handed over, missing, counted, found."""
    HAND = "hand"
    """A movement by an operator's hand."""
    # One command, ``resume``: the controller picks the variant from how far the job has come.
    RESUME_IDLE = "resume_idle"
    RESUME_STARTING = "resume_starting"
    RESUME_INTERPRETING = "resume_interpreting"
    RESUME_GENERATING = "resume_generating"
    RESUME_VALIDATING = "resume_validating"
    RESUME_CONFIRMING = "resume_confirming"
    RESUME_FEEDING = "resume_feeding"
    RESUME_PICKING = "resume_picking"
    RESUME_PLACING = "resume_placing"
    RESUME_VERIFYING = "resume_verifying"
    RESUME_GRIPPING = "resume_gripping"
    RESUME_PARTING = "resume_parting"
    RESUME_RETURNING = "resume_returning"
    RESUME_PUTTING_BACK = "resume_putting_back"
    RESUME_RETREATING = "resume_retreating"


COMMANDS = frozenset(
    {Event.SAY, Event.HEAR, Event.BUILD, Event.TAKE_APART, Event.CONFIRM, Event.CONFIRM_TAKING}
    | {Event.DECLINE, Event.CHANGE, Event.PAUSE}
    | {Event.STOP, Event.CANCEL, Event.RESET, Event.REFILL, Event.BOOK, Event.HAND}
    | {event for event in Event if event.value.startswith("resume_")}
)
FAULTS = frozenset({Event.FAULT_HELD, Event.FAULT_STOPPED, Event.FAULT_EMERGENCY})

STATES: dict[str, tuple[str, ...]] = {
    "starting": (),
    "idle": (),
    "listening": ("waiting", "hearing", "interpreting"),
    "generating": (),
    "validating": ("discretising", "checking", "sequencing", "confirming"),
    "feeding": ("indexing", "presenting", "refilling"),
    "assembling": ("picking", "placing", "verifying", "retreating"),
    "disassembling": ("gripping", "parting", "returning", "verifying"),
    "paused": ("braking", "resting", "moving"),
    "fault": ("held", "stopped", "emergency", "recovering"),
}
"""Top-level states and their substates."""

LEAVES: tuple[str, ...] = tuple(
    leaf
    for top, subs in STATES.items()
    for leaf in ([f"{top}_{sub}" for sub in subs] if subs else [top])
)
"""The states that the machine can rest in, as ``top`` or ``top_sub``."""

MOTION_STATES = frozenset(
    {"assembling_picking", "assembling_placing", "assembling_verifying", "assembling_retreating"}
    | {"disassembling_gripping", "disassembling_parting", "disassembling_returning"}
    | {"disassembling_verifying", "paused_moving"}
)
"""States in which the arm may move: by its plan, or by an operator's hand."""


def leaves_of(*tops: str) -> list[str]:
    """All leaves under the given top-level states."""
    return [leaf for leaf in LEAVES if top_of(leaf) in tops]


def top_of(state: str) -> str:
    """The top-level state of a leaf."""
    return state.split("_", maxsplit=1)[0]


@dataclass(frozen=True)
class Transition:
    """One row of the table; ``target`` None means: accepted, and the state stays."""

    event: Event
    sources: tuple[str, ...]
    target: str | None


_WORKING = leaves_of("assembling", "disassembling")
_LET_GO = ["assembling_verifying", "disassembling_verifying"]
_DESIGNING = [
    "generating",
    "validating_discretising",
    "validating_checking",
    "validating_sequencing",
]
_BRINGING = ["feeding_indexing", "feeding_presenting"]
_BEFORE_MOTION = ["starting", *leaves_of("generating", "validating", "feeding")]
_FAULT_AT_REST = ["fault_held", "fault_stopped", "fault_emergency"]
_NO_FAULT = [leaf for leaf in LEAVES if top_of(leaf) != "fault"]

_TABLE: list[tuple[Event, list[str], str | None]] = [
    (Event.STARTED, ["starting"], "idle"),
    (Event.RECALLED, ["starting"], "paused_resting"),
    # Words.
    (Event.SAY, ["idle"], "listening_interpreting"),
    (Event.HEAR, ["idle"], "listening_waiting"),
    (Event.SPEECH_STARTED, ["listening_waiting"], "listening_hearing"),
    (Event.HEARD, ["listening_hearing"], "listening_interpreting"),
    (Event.UNDERSTOOD, ["listening_interpreting"], "generating"),
    # A shape and a plan.
    (Event.BUILD, ["idle"], "validating_discretising"),
    (Event.DESIGNED, ["generating"], "validating_discretising"),
    (Event.DISCRETISED, ["validating_discretising"], "validating_checking"),
    (Event.CHECKED, ["validating_checking"], "validating_sequencing"),
    (Event.PLANNED, ["validating_sequencing"], "validating_confirming"),
    (Event.TAKE_APART, ["idle"], "validating_checking"),
    (Event.PLANNED_WAIVED, ["validating_sequencing"], "feeding_indexing"),
    (Event.PLANNED_TAKING, ["validating_sequencing"], "disassembling_gripping"),
    (Event.CONFIRM, ["validating_confirming"], "feeding_indexing"),
    (Event.CONFIRM_TAKING, ["validating_confirming"], "disassembling_gripping"),
    (Event.DECLINE, ["validating_confirming"], "idle"),
    (Event.CHANGE, ["validating_confirming"], "generating"),
    (Event.KEPT, _DESIGNING, "validating_confirming"),
    (Event.REJECTED, [*leaves_of("listening"), *_DESIGNING], "idle"),
    # Part after part.
    (Event.BELT_EMPTY, ["feeding_indexing"], "feeding_refilling"),
    (Event.REFILL, ["feeding_refilling"], "feeding_indexing"),
    (Event.PART_NEAR, ["feeding_indexing"], "feeding_presenting"),
    (Event.PART_READY, _BRINGING, "assembling_picking"),
    (Event.PICKED, ["assembling_picking"], "assembling_placing"),
    (Event.PICK_AGAIN, ["assembling_picking", "assembling_placing"], "feeding_indexing"),
    (Event.PLACED, ["assembling_placing"], "assembling_verifying"),
    (Event.NEXT_PART_READY, _LET_GO, "assembling_picking"),
    (Event.NEXT_PART_AWAITED, _LET_GO, "feeding_indexing"),
    (Event.NEXT_PART_STANDS, _LET_GO, "disassembling_gripping"),
    (
        Event.WIND_UP,
        [*leaves_of("feeding"), *_LET_GO, "disassembling_gripping", "disassembling_parting"],
        "assembling_retreating",
    ),
    # Taking off part after part; a job may begin with one in the gripper.
    (Event.GRIPPED, ["disassembling_gripping"], "disassembling_parting"),
    (Event.GRIP_AGAIN, ["disassembling_parting"], "disassembling_gripping"),
    (
        Event.PARTED,
        ["disassembling_gripping", "disassembling_parting"],
        "disassembling_returning",
    ),
    (Event.PARTED_TO_PLACE, ["disassembling_parting"], "assembling_placing"),
    (Event.RETURNED, ["disassembling_returning"], "disassembling_verifying"),
    (Event.COMPLETED, ["assembling_retreating"], "idle"),
    # Pause at the next safe point; where nothing moves, that is now.
    (Event.PAUSE, _WORKING, None),
    (Event.PAUSE_NOW, _WORKING, "paused_braking"),
    (Event.PAUSE, ["idle", *leaves_of("generating", "validating")], "paused_resting"),
    (Event.PAUSE, leaves_of("feeding"), "paused_braking"),
    (Event.PAUSE, ["paused_braking", "paused_resting"], None),
    (Event.PAUSE, ["paused_moving"], "paused_braking"),
    # Stop works from everywhere. With nothing under way there is nothing to hold.
    (
        Event.STOP,
        [*_BEFORE_MOTION, *_WORKING, "paused_resting", "paused_moving"],
        "paused_braking",
    ),
    (Event.STOP, leaves_of("listening"), "idle"),
    (Event.STOP, ["idle", "paused_braking", *leaves_of("fault")], None),
    (Event.AT_REST, ["paused_braking"], "paused_resting"),
    # Cancel ends the job and leaves what stands; a part on its way is placed first. Out of a pause
    # or a stop only an operator's resume leads, with or without a job.
    (Event.CANCEL, leaves_of("listening", "generating", "validating"), "idle"),
    (Event.CANCEL, leaves_of("feeding"), "assembling_retreating"),
    (Event.CANCEL, _WORKING, None),
    (Event.CANCEL, ["paused_resting"], "paused_braking"),
    # What people say of parts moves nothing.
    (Event.REFILL, [leaf for leaf in LEAVES if leaf != "feeding_refilling"], None),
    (Event.BOOK, ["idle", "paused_resting", *_FAULT_AT_REST], None),
    # An operator's hand: out of a pause, and back into it.
    (Event.HAND, ["paused_resting"], "paused_moving"),
    (Event.HAND_DONE, ["paused_moving"], "paused_resting"),
    # Only from rest, and only by a person.
    (Event.RESUME_IDLE, ["paused_resting"], "idle"),
    (Event.RESUME_STARTING, ["paused_resting"], "starting"),
    (Event.RESUME_INTERPRETING, ["paused_resting"], "listening_interpreting"),
    (Event.RESUME_GENERATING, ["paused_resting"], "generating"),
    (Event.RESUME_VALIDATING, ["paused_resting"], "validating_discretising"),
    (Event.RESUME_CONFIRMING, ["paused_resting"], "validating_confirming"),
    (Event.RESUME_FEEDING, ["paused_resting"], "feeding_indexing"),
    (Event.RESUME_PICKING, ["paused_resting"], "assembling_picking"),
    (Event.RESUME_PLACING, ["paused_resting"], "assembling_placing"),
    (Event.RESUME_VERIFYING, ["paused_resting"], "assembling_verifying"),
    (Event.RESUME_RETREATING, ["paused_resting"], "assembling_retreating"),
    (Event.RESUME_GRIPPING, ["paused_resting"], "disassembling_gripping"),
    (Event.RESUME_PARTING, ["paused_resting"], "disassembling_parting"),
    (Event.RESUME_RETURNING, ["paused_resting"], "disassembling_returning"),
    (Event.RESUME_PUTTING_BACK, ["paused_resting"], "disassembling_verifying"),
    # A fault may strike anywhere; a worse one replaces a lesser one, never the reverse.
    (Event.FAULT_HELD, [*_NO_FAULT, "fault_recovering"], "fault_held"),
    (Event.FAULT_STOPPED, [*_NO_FAULT, "fault_held", "fault_recovering"], "fault_stopped"),
    (Event.FAULT_EMERGENCY, [*_NO_FAULT, *leaves_of("fault")], "fault_emergency"),
    (Event.RESET, _FAULT_AT_REST, "fault_recovering"),
    (Event.RECOVERED, ["fault_recovering"], "paused_resting"),
]

TRANSITIONS: tuple[Transition, ...] = tuple(
    Transition(event, tuple(sources), target) for event, sources, target in _TABLE
)
"""The whole table."""


@dataclass(frozen=True)
class Decision:
    """What an event does in a state."""

    verdict: Literal["accepted", "ignored", "refused"]
    state: str
    """The state after the event."""
    reason: str = ""
    """Why a command is refused, for whoever gave it."""


_REFUSALS: dict[Event, str] = {
    Event.CONFIRM: "Nothing waits for a yes.",
    Event.CONFIRM_TAKING: "Nothing waits for a yes.",
    Event.DECLINE: "Nothing waits for a no.",
    Event.CHANGE: "Nothing waits for a change.",
    Event.RESET: "There is no fault to reset.",
    Event.BOOK: "Parts can be counted only when the cell is idle, paused or in a fault.",
    Event.HAND: "The arm can be moved by hand only when the cell is paused: pause it first.",
}
_BUSY = {
    "starting": "The cell is still starting.",
    "paused": "The cell is paused: resume or cancel first.",
    "fault": "The cell is in a fault: see its remedy, then reset.",
}


_ON_ITS_WAY = {
    "paused_braking": "The arm is still coming to rest.",
    "paused_moving": "The arm still moves by the operator's hand: wait, or stop it.",
}


def _refusal(state: str, event: Event) -> str:
    top = top_of(state)
    if event in _REFUSALS:
        return _REFUSALS[event]
    if event.value.startswith("resume_"):
        if top == "paused":
            return _ON_ITS_WAY[state]
        return _BUSY["fault"] if top == "fault" else "The cell is not paused."
    if event in {Event.CANCEL, Event.PAUSE}:
        if state in _ON_ITS_WAY:
            return _ON_ITS_WAY[state]
        return _BUSY["fault"] if top == "fault" else f"There is no job to {event.value}."
    return _BUSY.get(top, f"The cell is busy ({top}).")


class CellMachine:
    """The machine in one cell: where it is, and what an event would do."""

    def __init__(self, state: str = "starting") -> None:
        self.state = state
        nested: list[str | dict[str, object]] = [
            {"name": top, "children": list(subs)} if subs else top for top, subs in STATES.items()
        ]
        rows: list[dict[str, object]] = [
            {"trigger": row.event.value, "source": list(row.sources), "dest": row.target}
            for row in TRANSITIONS
        ]
        self._machine = HierarchicalMachine(
            model=self,
            states=nested,
            transitions=rows,
            initial=state,
            auto_transitions=False,
            send_event=False,
            ignore_invalid_triggers=True,
        )

    def feed(self, event: Event) -> Decision:
        """Apply an event and say what it did."""
        before = self.state
        accepted: bool = self.trigger(event.value)  # type: ignore[attr-defined]
        if accepted:
            return Decision("accepted", self.state)
        if event in COMMANDS:
            return Decision("refused", before, _refusal(before, event))
        return Decision("ignored", before)


def decide(state: str, event: Event) -> Decision:
    """What ``event`` does in ``state``, without a machine of one's own."""
    machine = _spare_machine()
    machine.state = state
    return machine.feed(event)


@cache
def _spare_machine() -> CellMachine:
    # To make one takes some twenty times as long as to ask it.
    return CellMachine()
