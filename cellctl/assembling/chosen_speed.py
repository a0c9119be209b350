"""The speed that somebody chose with the pendant's slider, kept beyond every process.

A path waits behind the slider at 0 (``arm_link``). Whoever dies then leaves it there, and only a
file tells the next one what was chosen before.
"""

from __future__ import annotations

import os
from pathlib import Path

import structlog

_log = structlog.get_logger(__name__)


class ChosenSpeed:
    """The slider's place while no movement is being started.

    Args:
        file: where it is kept; None keeps it as long as this object lives.

    Attributes:
        fraction: the place, from 0 to 1; full speed where nobody has chosen yet.
    """

    def __init__(self, file: Path | None = None) -> None:
        self._file = file
        self.fraction = 1.0
        if file is not None and file.exists():
            try:
                read = float(file.read_text(encoding="ascii"))
            except (OSError, ValueError) as error:
                _log.warning("the chosen speed cannot be read", file=str(file), reason=str(error))
            else:
                self.fraction = read if 0.0 < read <= 1.0 else 1.0

    def choose(self, fraction: float) -> None:
        """Keep a new place. A file that cannot be written is logged: the arm moves all the same."""
        if fraction == self.fraction:
            return
        self.fraction = fraction
        if self._file is None:
            return
        new = self._file.with_suffix(".new")
        try:
            with new.open("w", encoding="ascii") as sink:
                sink.write(f"{fraction!r}\n")
                sink.flush()
                os.fsync(sink.fileno())
            new.replace(self._file)
        except OSError as error:
            _log.warning("the chosen speed cannot be kept", file=str(self._file), reason=str(error))
