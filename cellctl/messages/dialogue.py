"""Topic ``dialogue``: the conversation, as the people in front of the cell have it."""

from __future__ import annotations

import hashlib
from datetime import datetime
from typing import Literal

from pydantic import Field

from cellctl.assembly import Value
from cellctl.wording import Line

DialoguePhase = Literal[
    "starting", "ready", "thinking", "asking", "building", "taking_apart", "waiting", "fault"
]
"""``ready``: for a wish; ``asking``: a question is open, and what it is about says
``question``; ``waiting``: paused, or somebody has to do something; ``fault``: an operator has."""

Question = Literal["", "build", "take_apart", "hand_over"]
"""What a yes would be for: build it (or change what stands into it), take apart what stands, or
write off what stands because a visitor takes it along."""

Offer = Literal[
    "yes", "no", "another", "change", "talk", "stop", "cancel", "take_apart", "hand_over"
]
"""What makes sense to say or to press now."""


def visitor_mark(secret: str) -> str:
    """What everybody may know of a visitor: enough to tell one from another; empty for none."""
    return hashlib.sha256(secret.encode()).hexdigest()[:12] if secret else ""


class QueueEntry(Value):
    """A wish that waits for its turn."""

    ticket: int
    """Its number; grows from wish to wish."""
    wish: str
    """What was understood, in words."""
    owner: str
    """Mark of the visitor; empty for the one in front of the cell."""
    name: str = ""
    """What the visitor wants to be called."""
    since: datetime


class DialogueData(Value):
    """Topic ``dialogue``: the conversation, as the people in front of the cell have it."""

    phase: DialoguePhase
    question: Question = ""
    asked: str = ""
    """Name of the question that is open, for the answer to it: no two questions ever have the same;
    empty while nothing is asked."""
    heard: str = ""
    """The last sentence that was heard or typed; empty once it is of no interest any more."""
    understood: str = ""
    """What was made of it, in words for the visitor; empty for nothing."""
    line: Line | None = None
    """The last thing said."""
    speaking: bool = False
    """Whether it is being said aloud now."""
    waits: Line | None = None
    """Why the cell waits for people, as visitors are told it; None while it does not. What those
    who help it have to do say the topics ``state`` and ``fault``."""
    offers: tuple[Offer, ...] = ()
    deadline: datetime | None = None
    """When silence will count as a no; None while nothing is asked."""
    owner: str = ""
    """Mark of the visitor whose job is under way; empty for the one in front of the cell."""
    owner_name: str = ""
    """What that visitor wants to be called."""
    queue: tuple[QueueEntry, ...] = Field(default=())
    """Wishes that wait for their turn, the next one first."""
