"""What the conversation is about now, as a value: from it follows what can be said."""

from __future__ import annotations

from dataclasses import dataclass

from cellctl.control.dialogue.table import Input
from cellctl.control.states import top_of
from cellctl.messages import DialoguePhase, EarsCondition, Offer, Question

_PHASES: dict[str, DialoguePhase] = {
    "starting": "starting",
    "idle": "ready",
    "listening": "thinking",
    "generating": "thinking",
    "validating": "thinking",
    "validating_confirming": "asking",
    "feeding": "building",
    "feeding_refilling": "waiting",
    "assembling": "building",
    "disassembling": "building",
    "paused": "waiting",
    "fault": "fault",
}
"""By state, or by its top level."""
_INPUTS: dict[DialoguePhase, Input] = {
    "starting": Input.CELL_STARTS,
    "ready": Input.CELL_RESTS,
    "thinking": Input.CELL_THINKS,
    "asking": Input.CELL_ASKS_BUILD,
    "building": Input.CELL_WORKS,
    "taking_apart": Input.CELL_WORKS,
    "waiting": Input.CELL_WAITS,
    "fault": Input.CELL_FAILS,
}
_LEAVABLE = frozenset({"feeding_refilling", "paused_resting"})
"""States of waiting in which a job can be cancelled; in the others it first comes to rest."""
_EARS_AT_WORK = frozenset({"listening", "waiting", "recording", "slow"})


@dataclass(frozen=True)
class Scene:
    """What bears on what can be said."""

    state: str
    """The machine's."""
    ears: EarsCondition = "off"
    active: bool = False
    """A job is under way, be it paused."""
    takes_apart: bool = False
    """That job takes apart what stands."""
    standing: bool = False
    """Something stands in the workspace."""
    hand_over: bool = False
    """It is asked whether somebody takes it along."""

    @property
    def phase(self) -> DialoguePhase:
        """Where the conversation is."""
        phase = _PHASES.get(self.state) or _PHASES[top_of(self.state)]
        if phase == "ready" and self.hand_over:
            return "asking"
        return "taking_apart" if phase == "building" and self.takes_apart else phase

    @property
    def input(self) -> Input:
        """Where the machine is, as the conversation's table has it."""
        if self.phase == "asking" and self.state != "validating_confirming":
            return Input.CELL_RESTS
        if self.phase == "asking" and self.takes_apart:
            return Input.CELL_ASKS_APART
        return _INPUTS[self.phase]

    @property
    def question(self) -> Question:
        """What a yes would be for."""
        if self.phase != "asking":
            return ""
        if self.state != "validating_confirming":
            return "hand_over"
        return "take_apart" if self.takes_apart else "build"

    @property
    def offers(self) -> tuple[Offer, ...]:
        """What makes sense to say or to press now."""
        offers: list[Offer] = []
        match self.phase:
            case "asking":
                offers += ["yes", "no"]
                offers += ["another", "change"] if self.question == "build" else []
            case "ready" if self.standing:
                offers += ["take_apart", "hand_over"]
            case "thinking":
                offers += ["stop", "cancel"]
            case "building" | "taking_apart":
                offers += ["stop", "cancel"]
            case "waiting":
                offers += ["stop"] if self.state != "paused_resting" else []
                offers += ["cancel"] if self.active and self.state in _LEAVABLE else []
        if self.ears in _EARS_AT_WORK and self.phase not in {"starting", "fault"}:
            offers.append("talk")
        return tuple(offers)
