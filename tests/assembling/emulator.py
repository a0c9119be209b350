"""The emulated controller as a process of its own, as the tests here meet it."""

from __future__ import annotations

import itertools
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from cellctl.config import CellConfig

_DEADLINE_S = 10.0
# Another run of the tests beside this one begins elsewhere.
_ADDRESSES = itertools.islice(itertools.cycle(range(20, 39)), os.getpid() % 19, None)


class Emulator:
    """One emulated controller on a loopback address of its own, at rest at the cell's home.

    Args:
        config: the cell; its host is not used.
        options: more options of ``python -m cellctl.sim.ur``.
    """

    def __init__(self, config: CellConfig, *options: str) -> None:
        self.host = f"127.0.0.{next(_ADDRESSES)}"
        robot = config.robot
        self.config = config.model_copy(
            update={"robot": robot.model_copy(update={"host": self.host})}
        )
        version = "3.15" if robot.rtde_frequency_hz == 125 else "5.12"
        home = ",".join(str(angle) for angle in robot.home_rad)
        command = [sys.executable, "-m", "cellctl.sim.ur", "--host", self.host]
        command += ["--model", robot.model, "--controller-version", version]
        command += [f"--initial-joints-rad={home}", *options]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def __enter__(self) -> Self:
        try:
            assert "ready" in self._read()
        except BaseException:
            self.__exit__(None, None, None)
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._process as process:
            process.terminate()

    def truth(self) -> dict[str, Any]:
        """The controller's own account of itself."""
        return self.tell("truth")

    def tell(self, command: str) -> dict[str, Any]:
        """Give a command and return its answer."""
        assert self._process.stdin is not None
        self._process.stdin.write(command + "\n")
        self._process.stdin.flush()
        answer = self._read()
        assert "error" not in answer, answer
        return answer

    def wait_until(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The first truth that is as wanted."""
        deadline_s = time.monotonic() + _DEADLINE_S
        while not wanted(truth := self.truth()):
            assert time.monotonic() < deadline_s, truth
        return truth

    def _read(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, "the emulated controller has ended"
        answer: dict[str, Any] = json.loads(line)
        return answer
