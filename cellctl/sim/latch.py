"""The latch gripper on the robot's pins, as a plain emulator.

Command line: high unlatches, low latches, so that a broken wire keeps the voxel. Status line: high
only while a completed latch is confirmed; low during travel and while open; a 5 Hz toggle tells of
a fault. The latch holds by itself: on loss of power or link it stays where it is. At boot it does
not move, and a latch that was closed by an earlier life is not confirmed.
"""

from __future__ import annotations

from enum import StrEnum

from cellctl.sim.world import World

DEAF_S = 0.006
"""A board looks at its command line for so long before it believes a new level; this emulator
hears of it at once, or not at all."""
TRAVEL_S = 0.35
"""Cell time from a command to the latch being open or closed."""
TOGGLE_HALF_PERIOD_S = 0.1
"""5 Hz: the status line changes its level this often while the gripper reports a fault."""


class LatchFault(StrEnum):
    """What can be wrong with the gripper."""

    SILENT = "silent"
    """The latch moves, its status line stays low."""
    FAULT = "fault"
    """The latch does not move, and the status line toggles."""
    STUCK = "stuck"
    """The latch does not move, and nothing tells."""


class Latch:
    """The gripper's latch; tells the world when it has closed or opened.

    Args:
        world: where the parts are.
        travel_s: cell time from a command to its completion.
    """

    deaf_s = DEAF_S

    def __init__(self, world: World, travel_s: float = TRAVEL_S) -> None:
        self._world = world
        self.travel_s = travel_s
        """Cell time from a command to its completion; the board's calibration may change it."""
        self.cycles = 0
        """Latches completed."""
        self._faults: set[LatchFault] = set()
        self._closed = True
        self._wanted_closed = True
        self._confirmed = False
        self._travelled_s: float | None = None
        """How long the latch has been on its way; None while it rests."""
        self._toggle_s = 0.0

    @property
    def closed(self) -> bool:
        """Whether the latch is closed and at rest."""
        return self._closed and self._travelled_s is None

    @property
    def moving(self) -> bool:
        """Whether the latch is on its way."""
        return self._travelled_s is not None

    @property
    def confirmed(self) -> bool:
        """Whether a latch was completed, and nothing changed since."""
        return self._confirmed

    @property
    def holds_part(self) -> bool:
        """What the switch in the gripper feels."""
        return self._world.feels_part

    @property
    def told_open(self) -> bool:
        """Whether the command line is high."""
        return not self._wanted_closed

    @property
    def faulty(self) -> bool:
        """Whether the gripper reports a fault of its own."""
        return LatchFault.FAULT in self._faults

    @property
    def status(self) -> bool:
        """Level of the status line."""
        if LatchFault.FAULT in self._faults:
            return int(self._toggle_s / TOGGLE_HALF_PERIOD_S) % 2 == 0
        if LatchFault.SILENT in self._faults:
            return False
        return self._confirmed

    def command(self, high: bool) -> None:
        """Level of the command line: high unlatches. Repeating a level changes nothing."""
        wanted_closed = not high
        if wanted_closed == self._wanted_closed:
            return
        self._wanted_closed = wanted_closed
        self._confirmed = False
        self._travelled_s = 0.0

    def advance(self, dt_s: float) -> None:
        """Let cell time pass."""
        self._toggle_s += dt_s
        if self._travelled_s is None or self._faults & {LatchFault.STUCK, LatchFault.FAULT}:
            return
        self._travelled_s += dt_s
        # Half a microsecond less: sums of time steps fall short of their target by rounding.
        if self._travelled_s < self.travel_s - 5e-7:
            return
        self._travelled_s = None
        self._closed = self._wanted_closed
        if self._closed:
            self._confirmed = True
            self.cycles += 1
            self._world.latch_closed()
        else:
            self._world.latch_opened()

    def inject(self, fault: LatchFault) -> None:
        """Break something; a blocked latch goes on from where it is once that is cleared."""
        self._faults.add(fault)
        self._toggle_s = 0.0

    def clear(self, fault: LatchFault) -> None:
        """Mend it; nothing happens where it is not broken."""
        self._faults.discard(fault)

    def reboot(self) -> None:
        """Cut the power for a moment: the latch stays where it is, and is no longer confirmed.

        A latch caught in mid-travel stays as it was before. The board takes the present level of
        the command line for granted, and moves at the next change.
        """
        self._travelled_s = None
        self._confirmed = False
        self._toggle_s = 0.0

    def truth(self) -> dict[str, object]:
        """The latch as it is, for the record."""
        return {
            "latched": self.closed,
            "moving": self.moving,
            "status": self.status,
            "faults": sorted(self._faults),
        }
