"""Placements that jolt: how hard a part arrives at its seat, and whether it stays there then.

The only published figures are a table of eight trials with one object: at speed and acceleration of
1 and 1, 1.5 and 1.5 (m/s, m/s2), and at 1 and 0.5, 1.5 and 0.75, 2 and 1 it stood; at 2 and 2, 2.5
and 2.5, and at 2.5 and 1.25 it failed. What was commanded decides, not the speed that was reached:
on a way as short as those down to a cell it is limited by the acceleration, and no limit on it, or
on the acceleration, tells the eight apart. Their product does: all that stood have 2.25 at most,
all that failed 3.125 at least. So it is taken for the measure of the jolt.
"""

from __future__ import annotations

_ARRIVING_M = 0.003
"""A movement brings a part to its seat if it brings it down by so much: pressing on it does not."""


class Impact:
    """Follows the movements of a tool, and knows how hard the last one down was."""

    def __init__(self) -> None:
        self.jolt_m2_s3 = 0.0
        """Commanded speed times acceleration of the last movement that brought the tool down."""
        self._commanded = (0.0, 0.0)
        self._down_m = 0.0

    def command(self, speed_m_s: float, acceleration_m_s2: float) -> None:
        """What is asked of the movement under way."""
        if (speed_m_s, acceleration_m_s2) != self._commanded:
            self._commanded = (speed_m_s, acceleration_m_s2)
            self._down_m = 0.0

    def move(self, up_m: float) -> None:
        """The tool has moved by so much along the vertical."""
        self._down_m = self._down_m - up_m if up_m < 0.0 else 0.0
        if self._down_m >= _ARRIVING_M:
            speed_m_s, acceleration_m_s2 = self._commanded
            self.jolt_m2_s3 = speed_m_s * acceleration_m_s2
