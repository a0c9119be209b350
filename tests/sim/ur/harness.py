"""An emulated controller in a process of its own, and the real clients that talk to it."""

from __future__ import annotations

import itertools
import json
import math
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from types import TracebackType
from typing import Any, Self

from dashboard_client import DashboardClient
from rtde_control import RTDEControlInterface
from rtde_io import RTDEIOInterface
from rtde_receive import RTDEReceiveInterface

_numbers = itertools.count(1)
_POLL_S = 0.002

DISTANT_S = 10.0
"""Deadline for what should come soon, on a machine that is busy with other things."""


def fresh_host() -> str:
    """A loopback address that no other test process uses."""
    process = os.getpid()
    return f"127.{10 + process // 250 % 200}.{1 + process % 250}.{next(_numbers)}"


def wait_until(condition: Callable[[], object], timeout_s: float = DISTANT_S) -> None:
    """Wait for something to become true; fail when it does not."""
    deadline_s = time.monotonic() + timeout_s
    pause = threading.Event()
    while not condition():
        assert time.monotonic() < deadline_s, f"not within {timeout_s} s: {condition}"
        pause.wait(_POLL_S)


def distance_m(one: Sequence[float], other: Sequence[float]) -> float:
    """Between the positions of two poses."""
    return math.dist(one[:3], other[:3])


class Emulator:
    """``python -m cellctl.sim.ur`` on an address of its own.

    Args:
        options: fields of ``UrOptions``.
    """

    def __init__(self, **options: object) -> None:
        self.host = fresh_host()
        command = [sys.executable, "-m", "cellctl.sim.ur", "--host", self.host]
        for name, value in options.items():
            command.append(f"--{name.replace('_', '-')}={value}")
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def __enter__(self) -> Self:
        assert self._answer() == {"ready": self.host}
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with self._process as process:
            assert process.stdin is not None
            process.stdin.write("quit\n")
            process.stdin.flush()
            assert process.wait(DISTANT_S) == 0

    def tell(self, command: str) -> dict[str, Any]:
        """Give a command and return its answer."""
        assert self._process.stdin is not None
        self._process.stdin.write(command + "\n")
        self._process.stdin.flush()
        return self._answer()

    def inject(self, fault: str, arguments: str = "") -> None:
        """Cause a fault."""
        assert "done" in self.tell(f"inject {fault} {arguments}".strip())

    def clear(self, fault: str, arguments: str = "") -> None:
        """End a fault."""
        assert "done" in self.tell(f"clear {fault} {arguments}".strip())

    def truth(self) -> dict[str, Any]:
        """The controller's own account of itself."""
        return self.tell("truth")

    def _answer(self) -> dict[str, Any]:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        assert line, "the emulated controller has ended"
        answer: dict[str, Any] = json.loads(line)
        return answer


class Clients:
    """The real ``ur_rtde`` clients, connected.

    Args:
        host: the controller's address.
    """

    def __init__(self, host: str) -> None:
        self.receive = RTDEReceiveInterface(host)
        self.control = RTDEControlInterface(host)
        self.io = RTDEIOInterface(host)
        self.dashboard = DashboardClient(host)
        self.dashboard.connect()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.dashboard.disconnect()
        self.io.disconnect()
        self.control.disconnect()
        self.receive.disconnect()
        # Their sockets and timers are let go only when the objects are.
        del self.dashboard, self.io, self.control, self.receive

    def lifted(self, dz_m: float, dx_m: float = 0.0, dy_m: float = 0.0) -> list[float]:
        """A pose beside where the TCP is now."""
        x, y, z, rx, ry, rz = self.receive.getActualTCPPose()
        return [x + dx_m, y + dy_m, z + dz_m, rx, ry, rz]

    def wait_moving(self) -> None:
        """Wait until the TCP moves."""
        wait_until(lambda: self.tcp_speed_m_s() > 0.01)

    def wait_rest(self) -> None:
        """Wait until the joints rest."""
        wait_until(lambda: not any(self.receive.getActualQd()))

    def tcp_speed_m_s(self) -> float:
        """Speed of the TCP as the controller reports it."""
        return math.hypot(*self.receive.getActualTCPSpeed()[:3])
