"""What the daemon tells its mouth, and what the mouth tells the daemon.

Both cross a socket between two processes, one line of JSON each.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from cellctl.assembly import Value
from cellctl.config import VoiceSection
from cellctl.messages import VoiceCondition

ENVELOPE_STEP_S = 0.032
"""Of the levels in ``Began``."""

Chime = Literal["listening", "heard"]
"""Sounds that need no words: "say it now", and "that was heard"."""


class MouthSettings(Value):
    """What the mouth's process is started with."""

    voice: VoiceSection
    language: str
    """What is mostly spoken: its voice is loaded before anything has to be said."""


class Prepare(Value):
    """Make these texts' sounds when there is nothing else to do: they will be said."""

    kind: Literal["prepare"] = "prepare"
    texts: tuple[str, ...]
    language: str


class Say(Value):
    """Say this after what is being said."""

    kind: Literal["say"] = "say"
    number: int
    """Of the daemon's choice; ``Began`` and ``Ended`` carry it."""
    text: str
    language: str


class Ring(Value):
    """Sound a chime after what is being said."""

    kind: Literal["ring"] = "ring"
    number: int
    chime: Chime


class Hush(Value):
    """Be silent at once, and forget everything that waits."""

    kind: Literal["hush"] = "hush"


Order = Prepare | Say | Ring | Hush
ToMouth: TypeAdapter[Order] = TypeAdapter(Annotated[Order, Field(discriminator="kind")])


class Condition(Value):
    """How the mouth is, from now on."""

    kind: Literal["condition"] = "condition"
    state: VoiceCondition
    device: str = ""
    """The loudspeaker's name; empty while there is none."""
    voice: str = ""
    """Who speaks; empty until something was said."""
    sentence: str = ""
    """The same in words for the people in the room."""


class Began(Value):
    """Something is heard from now on."""

    kind: Literal["began"] = "began"
    number: int
    at_s: float
    """When its first sound comes out of the loudspeaker, by this machine's monotonic clock."""
    envelope: tuple[float, ...]
    """Root mean square of each ``ENVELOPE_STEP_S``, of full scale 32768."""


class Ended(Value):
    """It is not heard any more."""

    kind: Literal["ended"] = "ended"
    number: int
    at_s: float
    """When its last sound came out, by this machine's monotonic clock."""
    complete: bool
    """Nobody interrupted it, and the loudspeaker was there."""


MouthEvent = Condition | Began | Ended
FromMouth: TypeAdapter[MouthEvent] = TypeAdapter(Annotated[MouthEvent, Field(discriminator="kind")])
