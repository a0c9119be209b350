"""The one clock of the emulated cell: cell time in slices, paced by wall time."""

from __future__ import annotations

import math

SLICE_WALL_S = 0.002
"""What the emulators are advanced by at once, up to half of it more (wall time): an e-Series
controller's cycle, so that it streams at its full rate after a late wake-up too."""
BURST_SLICES = 250
"""So many slices are handed out before sockets get their turn again."""
STALL_S = 1.0
"""Wall time that the cell catches up on; a longer stall is left out of cell time."""


class SimClock:
    """Cell time, as far as the emulators have been advanced.

    It follows wall time multiplied by ``rate``, as the daemon's clock does. What the machine cannot
    keep up with is counted in ``lost_s``.

    Args:
        rate: cell seconds per wall second.
        wall_s: monotonic wall time at cell time 0.
    """

    def __init__(self, rate: float, wall_s: float) -> None:
        if not rate > 0.0:
            raise ValueError(f"clock rate must be greater than 0, not {rate}")
        self.rate = rate
        self.now_s = 0.0
        self.slice_s = SLICE_WALL_S * rate
        self.lost_s = 0.0
        """Cell time left out, because this process was stalled or too slow."""
        self._wall_s = wall_s
        self._due_s = 0.0

    def slices(self, wall_s: float) -> list[float]:
        """The slices of cell time that are due at a monotonic wall time, in order.

        ``now_s`` counts them as done. Several bursts may be due: see ``behind``.
        """
        self._due_s += max(0.0, wall_s - self._wall_s) * self.rate
        self._wall_s = wall_s
        excess_s = self._due_s - STALL_S * self.rate
        if excess_s > 0.0:
            self.lost_s += excess_s
            self._due_s -= excess_s
        if self._due_s <= 0.0:
            return []
        # All alike: a rest of its own after each slice would cost as much as a whole one.
        count = max(1, math.ceil(self._due_s / self.slice_s - 0.5))
        slice_s = self._due_s / count
        if count > BURST_SLICES:
            count = BURST_SLICES
            self._due_s -= count * slice_s
        else:
            self._due_s = 0.0
        self.now_s += count * slice_s
        return [slice_s] * count

    @property
    def behind(self) -> bool:
        """Whether more is due than the last burst."""
        return self._due_s > 0.0
