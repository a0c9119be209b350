"""What was said, on disk: only where the policy says so."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Literal

import structlog

from cellctl.clock import Clock

log = structlog.get_logger(__name__)


class Transcript:
    """Keeps what people and the cell say, one file a day, one line of JSON a sentence.

    Args:
        policy: ``none`` keeps nothing.
        folder: where the files are; made when the first sentence is kept.
        clock: the calendar.
    """

    def __init__(self, policy: Literal["none", "text"], folder: Path, clock: Clock) -> None:
        self._keeps = policy == "text"
        self._folder = folder
        self._clock = clock

    def keep(self, who: Literal["visitor", "operator", "cell"], text: str) -> None:
        """Keep one sentence; a disk that is full costs the transcript, not the conversation."""
        if not self._keeps or not text:
            return
        now = self._clock.wall_time()
        line = json.dumps({"time": now.isoformat(), "who": who, "text": text}, ensure_ascii=False)
        try:
            self._folder.mkdir(mode=0o700, exist_ok=True)
            with (self._folder / f"{now:%Y-%m-%d}.jsonl").open("a", encoding="utf-8") as file:
                file.write(f"{line}\n")
        except OSError as error:
            log.warning("transcript cannot be kept", folder=str(self._folder), reason=str(error))
