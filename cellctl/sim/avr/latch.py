"""The gripper's latch as metal: a servo that turns it, and the two wires to the robot.

What the status line says is up to the board's program; the world hears of the latch itself.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from cellctl.sim.avr.servo import Servo
from cellctl.sim.latch import LatchFault
from cellctl.sim.world import World

OPEN_US: Final = 1050.0
"""Turned at least this far, the latch is open; as the servo's pulse."""
CLOSED_US: Final = 1450.0
"""Turned at least this far the other way, it is closed."""
HOME_US: Final = 1500.0
SUPPLY_V: Final = 5.0
SAGGING_V: Final = 3.5
"""What is left of the supply when it sags."""


class ServoLatch:
    """The latch that a compiled gripper turns; the world hears when it has closed or opened.

    Args:
        world: where the parts are.
        set_supply: changes the board's supply, in volts.
    """

    deaf_s = 0.0
    """The program itself judges how long a level of the command line must last."""

    def __init__(self, world: World, set_supply: Callable[[float], None]) -> None:
        self._world = world
        self._set_supply = set_supply
        self._faults: set[LatchFault] = set()
        self.servo = Servo(HOME_US)
        self.told_open = False
        """Level of the command line."""
        self.line = False
        """Level that the board puts on the status line."""
        self._closed = True

    @property
    def closed(self) -> bool:
        """Whether the latch is closed and at rest."""
        return self._closed and not self.moving

    @property
    def moving(self) -> bool:
        """Whether it is neither open nor closed."""
        return OPEN_US < self.servo.position_us < CLOSED_US

    @property
    def holds_part(self) -> bool:
        """What the switch in the gripper feels."""
        return self._world.feels_part

    @property
    def status(self) -> bool:
        """Level of the status line, as the robot reads it."""
        return self.line and LatchFault.SILENT not in self._faults

    def command(self, high: bool) -> None:
        """Level of the command line: high asks for an open latch."""
        self.told_open = high

    def advance(self, dt_s: float) -> None:
        """Nothing of its own: the board's pulses move it."""

    def reboot(self) -> None:
        """Nothing of its own: what power does to a board is up to the board."""

    def follow(self) -> None:
        """The servo may have turned: tell the world what that does."""
        if not self._closed and self.servo.position_us >= CLOSED_US:
            self._closed = True
            self._world.latch_closed()
        elif self._closed and self.servo.position_us <= OPEN_US:
            self._closed = False
            self._world.latch_opened()

    def inject(self, fault: LatchFault) -> None:
        """Break something; what a fault means here stands in ``docs/emulated-cell.md``."""
        self._faults.add(fault)
        self._apply()

    def clear(self, fault: LatchFault) -> None:
        """Mend it; nothing happens where it is not broken."""
        self._faults.discard(fault)
        self._apply()

    def truth(self) -> dict[str, Any]:
        """The latch as it is, for the record."""
        return {
            "latched": self.closed,
            "moving": self.moving,
            "status": self.status,
            "faults": sorted(self._faults),
        }

    def _apply(self) -> None:
        self.servo.blocked = LatchFault.STUCK in self._faults
        self.servo.supply_v = SAGGING_V if LatchFault.FAULT in self._faults else SUPPLY_V
        self._set_supply(self.servo.supply_v)
