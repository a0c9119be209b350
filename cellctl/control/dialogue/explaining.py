"""What is said when a sentence was not understood: first why, then more and more help."""

from __future__ import annotations

from cellctl.assembly import Intent, Request
from cellctl.clock import Clock
from cellctl.wording import REFERENCE_LANGUAGE, Line, Wording

_ANOTHER_VISITOR_S = 60.0
"""After so long it is likely somebody else who is not understood (cell time)."""
_HELP = ("explain.again", "explain.at_last")
_HELP_TYPED = ("explain.again", "explain.at_last_typed")
"""To somebody whose words were not spoken."""


class Explainer:
    """Explains, differently each time in a row.

    Args:
        wording: the cell's language.
        clock: tells how long ago the last time was.
    """

    def __init__(self, wording: Wording, clock: Clock) -> None:
        self._wording = wording
        self._clock = clock
        self._times = 0
        self._last_s = clock.now_s()

    def understood(self) -> None:
        """Something was understood: the next failure is a first one."""
        self._times = 0

    def explain(self, request: Request, *, typed: bool) -> Line:
        """What a request lacks, and what would help.

        Args:
            request: what was read.
            typed: its words were not spoken.
        """
        if request.refusal:
            return self._as_read("explain.refused", request.refusal)
        if request.intent is Intent.EDIT:
            return self._wording.line("explain.change")
        now_s = self._clock.now_s()
        if now_s - self._last_s > _ANOTHER_VISITOR_S:
            self._times = 0
        self._last_s = now_s
        self._times += 1
        if self._times > 1:
            help_given = _HELP_TYPED if typed else _HELP
            return self._wording.line(help_given[min(self._times - 2, len(help_given) - 1)])
        is_question = request.intent is Intent.QUERY
        key = "explain.question" if is_question else "explain.nothing"
        return self._as_read(key, request.reason)

    def refusal(self, request: Request) -> str:
        """What is said to a request that is no answer; empty where nothing more is known."""
        if request.refusal:
            return self._as_read("explain.refused", request.refusal).text
        return request.ask if self._wording.language == REFERENCE_LANGUAGE else ""

    def _as_read(self, key: str, reason: str) -> Line:
        """The reader's own reason, where it has one and writes in this language."""
        line = self._wording.line(key)
        if reason and self._wording.language == REFERENCE_LANGUAGE:
            return line.model_copy(update={"text": reason})
        return line
