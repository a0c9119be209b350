"""The cell's voice in the daemon: what is said aloud, and what the bus shows of it."""

from __future__ import annotations

from collections.abc import Callable

import structlog

from cellctl.config import CellConfig
from cellctl.messages import StatusData, VoiceData
from cellctl.notices import NOTICES
from cellctl.speaking.events import Began, Chime, Condition, Ended, MouthEvent, MouthSettings
from cellctl.speaking.mouth import Mouth
from cellctl.wording import Line, Wording
from cellctl.wording.wording import WRITTEN, fields_of

log = structlog.get_logger(__name__)

_SELDOM_SAID = ("place.", *WRITTEN)
"""Messages that are parts of others, or said too seldom to be made beforehand."""


class LiveVoice:
    """A ``Speaker``; a cell without a loudspeaker has one that leaves everything to the screen.

    Args:
        config: the cell.
        wording: what it may say.
        publish: sends a status message.
    """

    def __init__(
        self,
        config: CellConfig,
        wording: Wording,
        publish: Callable[[StatusData], None],
    ) -> None:
        self._publish = publish
        self.heeded_by: list[Callable[[Began | Ended, str], None]] = []
        """Those who get whatever is heard of the cell's own voice, with its text."""
        self._chimes = config.voice.chimes
        self._mouth: Mouth | None = None
        if config.voice.loudspeaker != "none":
            settings = MouthSettings(voice=config.voice, language=wording.language)
            self._mouth = Mouth(settings, fixed_phrases(wording), self._take)
        self.data = VoiceData(state="off" if self._mouth is None else "starting")
        """What the bus shows."""

    @property
    def speaking(self) -> bool:
        """See ``Speaker``."""
        return self._mouth is not None and self._mouth.speaking

    @property
    def aloud(self) -> bool:
        """See ``Speaker``."""
        return self.data.state in {"quiet", "speaking"}

    def say(self, line: Line) -> None:
        """See ``Speaker``."""
        if self._mouth is not None:
            self._mouth.say(line)

    def ring(self, chime: Chime) -> None:
        """Sound a chime, unless they are switched off or something is being said."""
        if self._mouth is not None and self._chimes and not self._mouth.busy:
            self._mouth.ring(chime)

    def listens(self) -> None:
        """Somebody wants to speak: fall silent, and sound the chime for it."""
        if self._mouth is not None:
            self._mouth.hush()
            if self._chimes:
                self._mouth.ring("listening")

    def hush(self) -> None:
        """See ``Speaker``."""
        if self._mouth is not None:
            self._mouth.hush()

    async def run(self) -> None:
        """Speak until cancelled; without a loudspeaker there is nothing to do."""
        if self._mouth is not None:
            await self._mouth.run()

    def _take(self, event: MouthEvent, text: str) -> None:
        if isinstance(event, Condition):
            self._changed(event)
            return
        for heed in self.heeded_by:
            heed(event, text)
        self.data = self.data.model_copy(
            update={"saying": text if isinstance(event, Began) else ""}
        )
        self._publish(self.data)

    def _changed(self, condition: Condition) -> None:
        bad = condition.state in {"lost", "silent"}
        if bad and condition.state != self.data.state:
            log.warning("voice", state=condition.state, why=condition.sentence)
        self.data = self.data.model_copy(
            update={
                "state": condition.state,
                "device": condition.device,
                "voice": condition.voice or self.data.voice,
                "sentence": condition.sentence,
                "notice": NOTICES["loudspeaker_lost"] if bad else None,
            }
        )
        self._publish(self.data)


def fixed_phrases(wording: Wording) -> list[str]:
    """What is said in the same words every time."""
    return [
        forms[0]
        for key, forms in wording.messages.items()
        if not key.startswith(_SELDOM_SAID) and not fields_of(forms)
    ]
