"""A model servo: turns towards the pulse it is given, and stays where it is when there is none."""

from __future__ import annotations

from collections import deque
from typing import Final

SPEED_US_S: Final = 2000.0
"""How fast it turns, as change of pulse per second: 45 degrees take 0.25 s."""
FRAME_S: Final = 0.025
"""Without another pulse for this long it is let go. Pulses come every 20 ms."""
SUPPLY_MIN_V: Final = 4.0
"""Below it, it does not turn."""
PULSE_MIN_US: Final = 500.0
PULSE_MAX_US: Final = 2500.0
"""Other pulses are none."""
PULSES_KEPT: Final = 100


class Servo:
    """One servo on one pin.

    Args:
        position_us: where it is at first, as the pulse that would keep it there.
    """

    def __init__(self, position_us: float) -> None:
        self.position_us = position_us
        self.supply_v = 5.0
        self.blocked = False
        """Whether something keeps it from turning."""
        self.pulses_us: deque[float] = deque(maxlen=PULSES_KEPT)
        """The lengths of the newest pulses that it was given."""
        self._target_us = position_us
        self._driven_until_s = 0.0
        self._rose_s: float | None = None
        self._time_s = 0.0

    @property
    def driven(self) -> bool:
        """Whether it is told where to go."""
        return self._time_s < self._driven_until_s

    def level(self, time_s: float, high: bool) -> None:
        """Its line has changed its level."""
        self._turn(time_s)
        if high:
            self._rose_s = time_s
            return
        if self._rose_s is None:
            return
        pulse_us = (time_s - self._rose_s) * 1e6
        self._rose_s = None
        if PULSE_MIN_US <= pulse_us <= PULSE_MAX_US:
            self.pulses_us.append(pulse_us)
            self._target_us = pulse_us
            self._driven_until_s = time_s + FRAME_S

    def advance(self, to_s: float) -> None:
        """Let time pass, up to this one."""
        self._turn(to_s)

    def _turn(self, to_s: float) -> None:
        turning_s = min(to_s, self._driven_until_s) - self._time_s
        self._time_s = max(self._time_s, to_s)
        if turning_s <= 0.0 or self.blocked or self.supply_v < SUPPLY_MIN_V:
            return
        way_us = self._target_us - self.position_us
        step_us = SPEED_US_S * turning_s
        self.position_us += max(-step_us, min(step_us, way_us))
