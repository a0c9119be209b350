"""The controller's watchdog on a client's writes (``rtde_set_watchdog`` with the action "stop").

Time is counted in the emulator's own ticks: a tick that comes late because the machine is busy
counts as ``stall_s`` at most, and the input that waited meanwhile is read first. So a loaded
machine trips nothing, while a client that writes no more is noticed after the window and one tick.
"""

from __future__ import annotations

import time


class Watchdog:
    """Counts wall time since the watched register was last written.

    Args:
        stall_s: the most that one tick may count.
    """

    def __init__(self, stall_s: float) -> None:
        self._stall_s = stall_s
        self.window_s: float | None = None
        """Longest allowed silence in wall seconds; None when not armed."""
        self.silence_s = 0.0
        self.trips = 0
        self.last_trip_silence_s: float | None = None
        """Counted silence at the last trip."""
        self.last_trip_wall_s: float | None = None
        """The same by the system's clock, stalls included."""
        self._written_at_s = time.monotonic()

    def arm(self, frequency_hz: float) -> None:
        """Expect a write at least so often; 0 disarms."""
        self.window_s = 1.0 / frequency_hz if frequency_hz > 0.0 else None
        self.silence_s = 0.0

    def disarm(self) -> None:
        """Expect nothing any more."""
        self.window_s = None

    def written(self) -> None:
        """The watched register was written."""
        self.silence_s = 0.0
        self._written_at_s = time.monotonic()

    def due(self, elapsed_s: float) -> bool:
        """Whether this tick of wall time would end the window, if nothing is found unread."""
        self.silence_s += min(elapsed_s, self._stall_s)
        return self.window_s is not None and self.silence_s >= self.window_s - 1e-9

    def trip(self) -> None:
        """Record that the silence was too long, and disarm."""
        self.trips += 1
        self.last_trip_silence_s = self.silence_s
        self.last_trip_wall_s = time.monotonic() - self._written_at_s
        self.disarm()
