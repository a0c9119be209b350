"""The controller's watchdog on a client's writes (``rtde_set_watchdog`` with the action "stop").

It runs by wall time, counted in the emulator's own ticks: a tick that comes late because the
machine is busy counts as ``stall_s`` at most, and the input that waited meanwhile is read first. So
a loaded machine trips nothing, while a client that writes no more is noticed after the window and
one tick.
"""

from __future__ import annotations

from collections.abc import Callable


class Watchdog:
    """Counts wall time since the watched register was last written.

    Args:
        stall_s: the most that one tick may count.
        wall_clock: monotonic wall time in seconds.
    """

    def __init__(self, stall_s: float, wall_clock: Callable[[], float]) -> None:
        self._stall_s = stall_s
        self._wall_clock = wall_clock
        self.window_s: float | None = None
        """Longest allowed silence in wall seconds; None when not armed."""
        self.silence_s = 0.0
        self.trips = 0
        self.last_trip_silence_s: float | None = None
        """Counted silence at the last trip."""
        self.last_trip_wall_s: float | None = None
        """The same by the wall clock, stalls included."""
        self._written = False
        self._written_at_s = self._wall_clock()

    def arm(self, frequency_hz: float) -> None:
        """Expect a write at least so often; 0 disarms."""
        self.window_s = 1.0 / frequency_hz if frequency_hz > 0.0 else None
        self._written = True

    def disarm(self) -> None:
        """Expect nothing any more."""
        self.window_s = None

    def written(self) -> None:
        """The watched register was written."""
        self._written = True
        self._written_at_s = self._wall_clock()

    def due(self, elapsed_s: float) -> bool:
        """Whether this tick of wall time would end the window, if nothing is found unread."""
        if self._written:
            # It came in somewhere during this tick; the silence is counted from the tick's end.
            self._written = False
            self.silence_s = 0.0
        else:
            self.silence_s += min(elapsed_s, self._stall_s)
        return self.window_s is not None and self.silence_s >= self.window_s - 1e-9

    def trip(self) -> None:
        """Record that the silence was too long, and disarm."""
        self.trips += 1
        self.last_trip_silence_s = self.silence_s
        self.last_trip_wall_s = self._wall_clock() - self._written_at_s
        self.disarm()
