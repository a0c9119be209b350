"""What the ears expect to hear of the cell's own voice: a pure object that counts samples.

Whoever speaks tells when a sentence began and how loud each of its moments is. How loud that is at
the microphone depends on the room, on both volumes, and on whether the sound server cancels the
echo: it is learned while the cell speaks. A sound counts as a person's only if it is clearly louder
than the echo that is expected at that moment.
"""

from __future__ import annotations

from collections import deque

LATE_S = 0.45
"""An echo may come so much later than it was said to be played: sound on its way through drivers,
server and room ..."""
EARLY_S = 0.1
"""... or earlier."""
MARGIN = 1.8
"""How much louder than the learned echo a person has to be: 5 dB."""
SHARE = 0.75
"""Share of the moments that are fainter than the learned echo: a moment is compared with the
loudest one around it, and most are fainter than that. People who talk over the cell for
less than the rest of ``MEMORY_S`` do not count as echo."""
REMEMBERED_S = 2.0
"""A wake word is noticed so late."""
MEMORY_S = 8.0
"""Speech of the cell's own that the echo is learned from."""
LEARNING_S = 0.4
"""So much of it must have been heard before anybody else is: for the very first word."""
_LEAST_PLAYED = 300.0
"""Level of full scale 32768 below which what is played teaches nothing."""


class OwnVoice:
    """The cell's own voice at the microphone.

    Args:
        chunk_s: how much sound ``covers`` is asked about at a time.
        step_s: of the levels that ``began`` gets.
    """

    def __init__(self, chunk_s: float, step_s: float) -> None:
        self._step_s = step_s
        self._least = max(1, round(LEARNING_S / chunk_s))
        self._ratios: deque[float] = deque(maxlen=round(MEMORY_S / chunk_s))
        self._sentences: deque[tuple[float, tuple[float, ...]]] = deque()
        self._echo: float | None = None

    def began(self, at_s: float, levels: tuple[float, ...]) -> None:
        """A sentence is heard from now on.

        Args:
            at_s: when its first sound leaves the loudspeaker.
            levels: root mean square of each step.
        """
        self._sentences.append((at_s, levels))

    def ended(self, at_s: float) -> None:
        """Whatever is being said has ended, or was cut off, at this time."""
        self._sentences = deque(
            (start_s, levels[: max(0, round((at_s - start_s) / self._step_s))])
            for start_s, levels in self._sentences
        )

    def covers(self, now_s: float, level: float) -> bool:
        """Whether a sound of this level, heard until now, may be the cell's own voice."""
        played = self._played(now_s)
        if played < _LEAST_PLAYED:
            return False
        self._ratios.append(level / played)
        self._echo = self._learned()
        return self._echo is None or level < MARGIN * self._echo * played

    def spoke(self, now_s: float) -> bool:
        """Whether the cell itself speaks, or did until a moment ago: ``REMEMBERED_S``."""
        self._forget(now_s)
        return any(start_s < now_s + EARLY_S for start_s, _ in self._sentences)

    def _played(self, now_s: float) -> float:
        """The loudest moment that may be heard now; 0 for none."""
        self._forget(now_s)
        loudest = 0.0
        for start_s, levels in self._sentences:
            first = int((now_s - LATE_S - start_s) / self._step_s)
            last = int((now_s + EARLY_S - start_s) / self._step_s)
            loudest = max(loudest, max(levels[max(0, first) : max(0, last + 1)], default=0.0))
        return loudest

    def _forget(self, now_s: float) -> None:
        while self._sentences:
            start_s, levels = self._sentences[0]
            if now_s - REMEMBERED_S <= start_s + len(levels) * self._step_s:
                return
            self._sentences.popleft()

    def _learned(self) -> float | None:
        """Level at the microphone for each level that is played; None before it is known."""
        if len(self._ratios) < self._least:
            return None
        return sorted(self._ratios)[int(SHARE * len(self._ratios))]
