"""What the emulated UR controller costs: ``python -m benchmarks.emulator_cpu [--seconds N]``.

Starts ``python -m cellctl.sim.ur`` as an e-Series at 500 Hz with the real receive and control
clients connected, at rest and on blended paths, and prints the share of one core that the
emulator's process uses and the packages that it sends.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from rtde_control import RTDEControlInterface
from rtde_receive import RTDEReceiveInterface

_HOST = "127.0.7.1"
_EDGE_M = 0.1


class _Emulator:
    """The process under measurement."""

    def __init__(self) -> None:
        self.process = subprocess.Popen(  # noqa: S603 - a command of our own
            [sys.executable, "-m", "cellctl.sim.ur", "--host", _HOST],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        if not self.process.stdout.readline():
            raise SystemExit("the emulated controller did not start")

    def packages(self) -> int:
        """RTDE packages that it has sent."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write("truth\n")
        self.process.stdin.flush()
        truth: dict[str, Any] = json.loads(self.process.stdout.readline())
        return int(truth["rtde"]["packages_sent"])

    def cpu_s(self) -> float:
        """Processor time that it has used."""
        text = Path(f"/proc/{self.process.pid}/stat").read_text(encoding="ascii")
        user, system = text.rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


class _Measurement:
    """Processor time, wall time and packages since its beginning."""

    def __init__(self, emulator: _Emulator) -> None:
        self._emulator = emulator
        self._packages = emulator.packages()
        self._cpu_s = emulator.cpu_s()
        self._wall_s = time.monotonic()

    def report(self, label: str) -> None:
        """Print what was measured."""
        wall_s = time.monotonic() - self._wall_s
        cpu = (self._emulator.cpu_s() - self._cpu_s) / wall_s
        packages = (self._emulator.packages() - self._packages) / wall_s
        sys.stdout.write(f"{label:<28} {cpu:6.1%} of a core  {packages:6.0f} packages/s\n")


def _square(receive: RTDEReceiveInterface, laps: int) -> list[list[float]]:
    x, y, z, *turn = receive.getActualTCPPose()
    corners = [(0.0, _EDGE_M), (_EDGE_M, _EDGE_M), (_EDGE_M, 0.0), (0.0, 0.0)] * laps
    path = [[x, y + dy, z + dz, *turn, 0.25, 1.2, 0.02] for dy, dz in corners]
    path[-1][-1] = 0.0
    return path


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=8.0, help="length of each measurement")
    seconds: float = parser.parse_args().seconds
    emulator = _Emulator()
    with emulator.process:
        measurement = _Measurement(emulator)
        time.sleep(seconds)
        measurement.report("alone")
        receive = RTDEReceiveInterface(_HOST)
        control = RTDEControlInterface(_HOST)
        measurement = _Measurement(emulator)
        time.sleep(seconds)
        measurement.report("receive + control, at rest")
        laps = max(1, round(seconds / (4 * _EDGE_M / 0.25)))
        measurement = _Measurement(emulator)
        control.moveL(_square(receive, laps))
        measurement.report("receive + control, on a path")
        control.disconnect()
        receive.disconnect()
        emulator.process.terminate()
    return 0


if __name__ == "__main__":
    sys.exit(main())
