"""A command of ``cellctl`` at a terminal of its own, and a person who types."""

from __future__ import annotations

import os
import pty
import select
import subprocess
import sys
import time
from pathlib import Path
from types import TracebackType
from typing import Self

DEADLINE_S = 40.0


class Terminal:
    """``cellctl ARGUMENTS`` on a pseudo-terminal.

    Args:
        config: the configuration, in its environment.
        arguments: what is typed after ``cellctl``.
    """

    def __init__(self, config: Path, *arguments: str) -> None:
        self._ours, theirs = pty.openpty()
        self.shown = ""
        self._read_to = 0
        try:
            self._process = subprocess.Popen(
                # Whoever runs the tests in the background of a script has interrupts ignored, and
                # hands that down; a person's terminal has not.
                ["env", "--default-signal=INT", sys.executable, "-m", "cellctl", *arguments],
                stdin=theirs,
                stdout=theirs,
                stderr=theirs,
                env={**os.environ, "CELLCTL_CONFIG": str(config), "COLUMNS": "200"},
                start_new_session=True,
            )
        finally:
            os.close(theirs)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._process as process:
            process.kill()
        os.close(self._ours)

    def see(self, *texts: str) -> str:
        """Wait until one of these is shown after what was seen before; which one."""
        deadline_s = time.monotonic() + DEADLINE_S
        while True:
            fresh = self.shown[self._read_to :]
            found = [(fresh.index(text), text) for text in texts if text in fresh]
            if found:
                at, text = min(found)
                self._read_to += at + len(text)
                return text
            assert time.monotonic() < deadline_s, f"no {texts} in {fresh!r}"
            assert self._take(), f"ended without {texts}: {self.shown!r}"

    def type(self, text: str) -> None:
        """Type a line."""
        os.write(self._ours, f"{text}\n".encode())

    def interrupt(self) -> None:
        """Press Ctrl-C."""
        os.killpg(self._process.pid, 2)

    def status(self) -> int:
        """Wait for the end; its exit status."""
        while self._take():
            pass
        return self._process.wait(DEADLINE_S)

    def _take(self) -> bool:
        """Take in what is shown next; False when the command has ended."""
        if not select.select([self._ours], [], [], 1.0)[0]:
            return True
        try:
            data = os.read(self._ours, 1 << 16)
        except OSError:
            return False
        self.shown += data.decode("utf-8", "replace")
        return bool(data)
