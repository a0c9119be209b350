"""The firmware's pure logic compiled for this computer, with every check the compiler has."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

from tests.leaks import REPOSITORY

FIRMWARE = REPOSITORY / "firmware"
HOST = Path(__file__).parent / "host"
SANITISERS = (
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover=all",
    "-fno-omit-frame-pointer",
)
STRICT = ("-Wall", "-Wextra", "-Wconversion", "-Wsign-conversion", "-Wshadow", "-Werror")
LOGIC = {
    "lines": ["common/line.c", "common/crc8.c"],
    "gripper_board": [
        *(f"common/{name}.c" for name in ("line", "crc8", "session", "debounce", "reset")),
        *(f"gripper/{name}.c" for name in ("calibration", "gripper", "latch", "survivors")),
    ],
    "conveyor_board": [
        *(f"common/{name}.c" for name in ("line", "crc8", "session", "debounce")),
        *(f"conveyor/{name}.c" for name in ("belt", "conveyor", "ramp")),
    ],
}
"""Which of the firmware's files each program of ``host`` is made of."""


def compile_program(name: str, folder: Path) -> Path:
    """Compile one of ``LOGIC``; the firmware's own files are compiled as they are."""
    program = folder / name
    board = name.partition("_")[0]
    subprocess.run(
        [
            "gcc",
            *("-std=gnu11", "-g", "-O1", "-fshort-enums", "-DF_CPU=10000000UL"),
            *SANITISERS,
            *STRICT,
            f"-I{FIRMWARE / 'common'}",
            f"-I{FIRMWARE / board}",
            "-o",
            program,
            HOST / f"{name}.c",
            *(FIRMWARE / source for source in LOGIC[name]),
        ],
        check=True,
        timeout=120,
    )
    return program


class HostProgram:
    """A program of ``host`` that takes commands, one a line, and answers each with ``done``.

    A finding of a sanitiser ends it, and then every further command fails.
    """

    def __init__(self, program: Path) -> None:
        self._process = subprocess.Popen(
            [program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def __enter__(self) -> HostProgram:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.close()
        code = self._process.wait(timeout=10)
        self._process.stdout.close()
        assert code == 0, f"the program ended with {code}"

    def do(self, command: str) -> list[str]:
        """Carry out a command; returns the lines that it told."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(command + "\n")
        self._process.stdin.flush()
        told: list[str] = []
        for line in self._process.stdout:
            if line == "done\n":
                return told
            told.append(line.rstrip("\n"))
        raise AssertionError(f"the program ended at {command!r}")


@dataclass(frozen=True)
class Change:
    """A change of the gripper's outputs."""

    time_ms: int
    status: bool
    pulse_us: int
    """0: the servo is let go."""

    @classmethod
    def parse(cls, line: str) -> Change:
        """Read ``TIME_MS status S pulse P``."""
        time_ms, _, status, _, pulse_us = line.split()
        return cls(int(time_ms), status == "1", int(pulse_us))
