"""``Mouth``: the daemon's end of the process that owns the loudspeaker."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable

from cellctl.assembly import Value
from cellctl.sound.process import SoundProcess
from cellctl.speaking.events import (
    Began,
    Chime,
    Condition,
    Ended,
    FromMouth,
    Hush,
    MouthEvent,
    MouthSettings,
    Prepare,
    Ring,
    Say,
)
from cellctl.wording import Line

_DOUBT_S = 5.0
"""Nobody is in danger while the voice is late: making a sound may keep a busy computer so long."""


class Mouth:
    """A ``Speaker`` with a loudspeaker: run ``run`` as a task.

    Args:
        settings: how to speak; its loudspeaker is not ``none``.
        phrases: what will be said again and again: made beforehand.
        tell: gets every event, with the text that it is about; empty for a chime.
    """

    def __init__(
        self,
        settings: MouthSettings,
        phrases: Iterable[str],
        tell: Callable[[MouthEvent, str], None],
    ) -> None:
        self._prepare = Prepare(texts=tuple(phrases), language=settings.language)
        self._tell = tell
        self._number = 0
        self._unsaid: dict[int, str] = {}
        self._condition: Condition | None = None
        """The newest that the process told."""
        self._process = SoundProcess(
            "voice", "cellctl.speaking.child", settings.model_dump_json(), self, doubt_s=_DOUBT_S
        )

    @property
    def pid(self) -> int | None:
        """Process id of the mouth, while it runs."""
        return self._process.pid

    @property
    def speaking(self) -> bool:
        """Whether something is being said now, or about to be."""
        return any(self._unsaid.values())

    @property
    def busy(self) -> bool:
        """The same, chimes included."""
        return bool(self._unsaid)

    def say(self, line: Line) -> None:
        """See ``Speaker``."""
        number = self._take_up(line.text)
        self._send(Say(number=number, text=line.text, language=line.language), number)

    def ring(self, chime: Chime) -> None:
        """Sound a chime after what is being said."""
        number = self._take_up("")
        self._send(Ring(number=number, chime=chime), number)

    def hush(self) -> None:
        """See ``Speaker``."""
        self._process.send(Hush())

    async def run(self) -> None:
        """Keep the process at work until cancelled."""
        await self._process.run()

    def started(self) -> Iterable[Value]:
        """See ``Owner``."""
        return (self._prepare,)

    def take(self, line: bytes) -> None:
        """See ``Owner``."""
        match event := FromMouth.validate_json(line):
            case Condition():
                self._condition = event
                self._tell(event, "")
            case Began():
                self._tell(event, self._unsaid.get(event.number, ""))
            case Ended():
                self._tell(event, self._unsaid.pop(event.number, ""))

    def lost(self, why: str) -> None:
        """See ``Owner``."""
        for number in list(self._unsaid):
            self._leave_out(number)
        self._tell(Condition(state="lost", sentence=why), "")

    def answers_again(self) -> None:
        """See ``Owner``."""
        if self._condition is not None:
            self._tell(self._condition, "")

    def _take_up(self, text: str) -> int:
        self._number += 1
        self._unsaid[self._number] = text
        return self._number

    def _send(self, order: Say | Ring, number: int) -> None:
        if self._process.pid is None:
            self._leave_out(number)  # it stands on the screen
        else:
            self._process.send(order)

    def _leave_out(self, number: int) -> None:
        text = self._unsaid.pop(number, "")
        self._tell(Ended(number=number, at_s=time.monotonic(), complete=False), text)
