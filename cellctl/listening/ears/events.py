"""What the ears tell the daemon, and what the daemon tells the ears.

Both cross a socket between two processes, one line of JSON each. Samples are 16 kHz mono 16 bit
PCM; they are never written anywhere.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import ConfigDict, Field, TypeAdapter

from cellctl.assembly import Value
from cellctl.listening.recogniser import Samples
from cellctl.messages import EarsCondition

SpokenAfter = Literal["", "wake_word", "push_to_talk", "open"]
"""What made the ears take speech for a request; empty when nothing did."""
Expecting = Literal["request", "command"]
"""What may be said: a whole sentence, or nothing but yes, no, stop and the like."""

OWN_VOICE_STEP_S = 0.032
"""Of the levels in ``OwnVoiceBegan``."""


class Condition(Value):
    """How the ears are, from now on."""

    kind: Literal["condition"] = "condition"
    state: EarsCondition
    device: str = ""
    """The microphone's name; empty while there is none."""
    sentence: str = ""
    """The same in words for the people in the room."""


class WakeWordHeard(Value):
    """Somebody said the wake word; what is said next is a request."""

    kind: Literal["wake_word"] = "wake_word"
    word: str


class NoSpeech(Value):
    """Nobody said anything after the wake word or the button."""

    kind: Literal["no_speech"] = "no_speech"


class Segment(Value):
    """One utterance, from just before its first sound to the silence that ended it."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", ser_json_bytes="base64", val_json_bytes="base64"
    )

    kind: Literal["segment"] = "segment"
    pcm: bytes
    after: SpokenAfter
    mark: int = 0
    """Tells whether anything was said since: see ``Draft``."""
    speech_end_s: float
    """When the last speech in it ended: seconds of sound in the pipeline's own events, this
    machine's monotonic clock in those of ``Ears``."""
    speech_s: float
    """How long before that the first speech in it began; more than its sound lasts where only the
    end of long speech is passed on."""

    @property
    def samples(self) -> Samples:
        """The sound as an array."""
        return np.frombuffer(self.pcm, dtype=np.int16)


class Draft(Value):
    """A request that may be complete: unless its speaker goes on, a ``Segment`` with the same
    ``mark`` follows."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", ser_json_bytes="base64", val_json_bytes="base64"
    )

    kind: Literal["draft"] = "draft"
    pcm: bytes
    mark: int


Heard = WakeWordHeard | NoSpeech | Draft | Segment
"""What comes out of the pipeline."""
EarsEvent = Condition | Heard
"""What the daemon gets."""
FromEars: TypeAdapter[EarsEvent] = TypeAdapter(Annotated[EarsEvent, Field(discriminator="kind")])


class Expect(Value):
    """From now on this is what may be said."""

    kind: Literal["expect"] = "expect"
    what: Expecting


class Listen(Value):
    """Take what is said next for a request: somebody pressed the button."""

    kind: Literal["listen"] = "listen"


class Mute(Value):
    """Close the microphone, or open it again."""

    kind: Literal["mute"] = "mute"
    muted: bool


class OwnVoiceBegan(Value):
    """The cell itself is heard from now on."""

    kind: Literal["own_voice_began"] = "own_voice_began"
    at_s: float
    """When its first sound leaves the loudspeaker, by this machine's monotonic clock."""
    levels: tuple[float, ...]
    """Root mean square of each ``OWN_VOICE_STEP_S``, of full scale 32768."""
    wakes: bool
    """It says the wake word itself."""


class OwnVoiceEnded(Value):
    """The cell itself is not heard any more."""

    kind: Literal["own_voice_ended"] = "own_voice_ended"
    at_s: float


Order = Expect | Listen | Mute | OwnVoiceBegan | OwnVoiceEnded
"""What the daemon tells the ears."""
ToEars: TypeAdapter[Order] = TypeAdapter(Annotated[Order, Field(discriminator="kind")])
