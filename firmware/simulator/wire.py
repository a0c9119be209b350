# SPDX-License-Identifier: GPL-3.0-or-later
"""A serial adapter on a simulated microcontroller's pins, bit by bit at the line's rate."""

from __future__ import annotations

from collections import deque
from typing import Any

from yasimavr.lib import core

FRAME_BITS = 10
"""Start, eight of data, stop."""


class SerialWire:
    """Sends bytes to a pin and hears what is on another, or on the same one.

    The adapter's clock is its own: a microcontroller whose rate is off hears and says rubbish.
    On a single wire the adapter only pulls low, and hears itself too.

    Args:
        device: the microcontroller.
        cycles: its cycle manager.
        hears: the pin that the microcontroller talks on.
        talks: the pin that it listens on; the same one on a single wire.
        baud: the adapter's rate.
    """

    def __init__(self, device: Any, cycles: Any, hears: str, talks: str, baud: int) -> None:
        self._cycles = cycles
        self._bit = device.frequency() / baud
        self._pin = device.find_pin(core.sim_id_t(talks))
        self._high = "U" if hears == talks else "H"
        self._edges: deque[tuple[int, bool]] = deque()
        """What is still to be sent: when the level changes, and to what."""
        self._free = 0.0
        """The cycle at which the wire is free for the next byte."""
        self._timer = core.CallableCycleTimer(self._send_edges)
        self._heard: deque[tuple[int, bool]] = deque()
        self._level = True
        self._pin.set_external_state(self._high)
        pin = device.find_pin(core.sim_id_t(hears))
        if hears != talks:
            pin.set_external_state("U")
        self._hook = core.CallableSignalHook(self._hear)
        pin.signal().connect(self._hook)

    def send(self, data: bytes) -> None:
        """Put bytes on the wire, one after the other; returns at once."""
        level = True
        for byte in data:
            self._free = max(self._free, float(self._cycles.cycle() + 1))
            frame = byte << 1 | 1 << (FRAME_BITS - 1)
            for bit in range(FRAME_BITS):
                wanted = bool(frame >> bit & 1)
                if wanted != level:
                    self._edges.append((round(self._free + bit * self._bit), wanted))
                level = wanted
            self._free += FRAME_BITS * self._bit
        if self._edges and not self._timer.scheduled():
            self._cycles.schedule(self._timer, self._edges[0][0])

    def silence(self) -> None:
        """Forget what is still to be sent, as when the cable is pulled."""
        self._edges.clear()
        self._pin.set_external_state(self._high)

    def heard(self) -> bytes:
        """The bytes whose frames have ended since this was last asked; bad frames are dropped."""
        data = bytearray()
        now = self._cycles.cycle()
        while self._heard:
            start, level = self._heard[0]
            if level or self._level is False:
                self._level = level
                self._heard.popleft()
                continue
            if start + (FRAME_BITS - 0.5) * self._bit > now:
                break
            frame = 0
            for bit in range(FRAME_BITS):
                sample = start + (bit + 0.5) * self._bit
                while self._heard and self._heard[0][0] <= sample:
                    self._level = self._heard.popleft()[1]
                frame |= self._level << bit
            if frame & 1 == 0 and frame >> (FRAME_BITS - 1):
                data.append(frame >> 1 & 0xFF)
        return bytes(data)

    def _hear(self, signal: Any, _: int) -> None:
        if signal.sigid == core.Wire.SignalId.DigitalChange:
            self._heard.append((self._cycles.cycle(), bool(signal.data.value())))

    def _send_edges(self, when: int) -> int:
        while self._edges and self._edges[0][0] <= when:
            level = self._edges.popleft()[1]
            self._pin.set_external_state(self._high if level else "L")
        return self._edges[0][0] if self._edges else 0
