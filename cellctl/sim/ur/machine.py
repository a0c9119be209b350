"""What a running program can reach of the controller."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Protocol

from cellctl.sim.ur.arm import Arm
from cellctl.sim.ur.options import Six, UrOptions, Vector
from cellctl.sim.ur.registers import Registers
from cellctl.sim.ur.watchdog import Watchdog


class Machine(Protocol):
    """The controller, as its control program sees it."""

    options: UrOptions
    registers: Registers
    arm: Arm
    watchdog: Watchdog
    watched_register: int
    """Index of the integer input register on which the watchdog counts writes."""
    joint_history: deque[Six]
    """Joint positions of the past cycles, the newest last."""

    def trip_protective(self, cause: str) -> None:
        """Make a protective stop."""
        ...

    def set_payload(self, mass_kg: float, cog_m: Vector, inertia: Six | None = None) -> None:
        """Take another payload."""
        ...


class ProgramError(Exception):
    """A runtime error of the program: the controller ends it. No client is told why."""


class Window:
    """The registers that one program uses: the lower or the upper range.

    Args:
        registers: the controller's memory.
        int_offset: index of the program's first integer register.
        double_offset: index of the program's first double register.
    """

    def __init__(self, registers: Registers, int_offset: int, double_offset: int) -> None:
        self._registers = registers
        self._int = int_offset
        self._double = double_offset

    def integer(self, index: int) -> int:
        """An argument from the client."""
        return self._registers.input_int[self._int + index]

    def number(self, index: int) -> float:
        """An argument from the client."""
        return self._registers.input_double[self._double + index]

    def six(self, index: int) -> Six:
        """Six arguments in a row, joints or a pose."""
        q0, q1, q2, q3, q4, q5 = (self.number(index + i) for i in range(6))
        return (q0, q1, q2, q3, q4, q5)

    def put_integer(self, index: int, value: int) -> None:
        """A result for the client."""
        self._registers.output_int[self._int + index] = value

    def put_numbers(self, values: Sequence[float]) -> None:
        """Results for the client, from the first register on."""
        start = self._double
        self._registers.output_double[start : start + len(values)] = [float(v) for v in values]
