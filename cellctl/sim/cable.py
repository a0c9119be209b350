"""The cable between a host and an emulated board: a pseudo-terminal, and what befalls its lines."""

from __future__ import annotations

import heapq
import itertools
import random
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from cellctl.boards.constants import REPLY_LIMIT
from cellctl.boards.line import END
from cellctl.sim.board_faults import ActiveFaults, CorruptedReplies, Garbage, LostReplies, Noise
from cellctl.sim.pseudo_terminal import PseudoTerminal

_GARBLED_BYTES: Final = 3
"""So many bytes of a garbled line at most are others."""


class Cable:
    """Carries bytes between the port and the board. Neither reading nor writing ever waits.

    Args:
        port: where the port appears.
        option: which option names it, for messages.
        faults: of the board at its end.
        chance: what decides which lines the noise strikes.
    """

    def __init__(
        self, port: Path, option: str, faults: ActiveFaults, chance: random.Random
    ) -> None:
        self._port = PseudoTerminal(port, option)
        self._faults = faults
        self._chance = chance
        self._time_s = 0.0
        self._unfinished = b""
        """What came from the host and is no whole line yet."""
        self._under_way: list[tuple[float, int, bool, bytes]] = []
        """Delayed lines: when they are due, a number, whether the host is to get them."""
        self._numbers = itertools.count()
        self._arrived = b""
        """Delayed lines that the board has not read yet."""

    @property
    def is_plugged_in(self) -> bool:
        """Whether the port exists."""
        return self._port.is_open

    def plug_in(self) -> None:
        """Make the port.

        Raises:
            UsageError: its name is taken by something else, or cannot be made.
        """
        self._port.open()

    def unplug(self) -> None:
        """Take the port away; what is under way is lost. Safe to repeat."""
        self._port.close()
        self._unfinished = self._arrived = b""
        self._under_way.clear()

    def advance(self, dt_s: float) -> None:
        """Let cell time pass: delayed lines arrive."""
        self._time_s += dt_s
        while self._under_way and self._under_way[0][0] <= self._time_s:
            *_, to_host, line = heapq.heappop(self._under_way)
            if to_host:
                self._to_host(line)
            else:
                self._arrived += line

    def read(self) -> bytes:
        """What the board hears."""
        if not self._port.is_open:
            return b""
        arrived, self._arrived = self._arrived, b""
        return arrived + b"".join(self._strike(self._lines(self._port.read()), to_host=False))

    def echo(self, line: bytes) -> None:
        """What the host has said comes back to it, as it does on a single wire."""
        self._to_host(line)

    def write(self, frame: bytes) -> None:
        """The board says something."""
        if self._faults.use_up(LostReplies):
            return
        if self._faults.use_up(CorruptedReplies):
            damaged = bytearray(frame)
            damaged[self._chance.randrange(len(frame))] ^= 1 << self._chance.randrange(8)
            frame = bytes(damaged)
        if garbage := self._faults.get(Garbage):
            frame = self._chance.randbytes(garbage.count) + frame
        for line in self._strike(iter((frame,)), to_host=True):
            self._to_host(line)

    def _to_host(self, line: bytes) -> None:
        if self._port.is_open:
            self._port.write(line)

    def _lines(self, data: bytes) -> Iterator[bytes]:
        """Whole lines; without noise there is no need to wait for their ends."""
        data = self._unfinished + data
        *lines, self._unfinished = data.split(END)
        yield from (line + END for line in lines)
        if self._faults.get(Noise) is None or len(self._unfinished) > REPLY_LIMIT:
            rest, self._unfinished = self._unfinished, b""
            yield rest

    def _strike(self, lines: Iterator[bytes], *, to_host: bool) -> Iterator[bytes]:
        """What is left of the lines, at once; delayed ones come later."""
        noise, chance = self._faults.get(Noise), self._chance
        if noise is None:
            yield from lines
            return
        for line in lines:
            kind = chance.randrange(5) if chance.random() < noise.share else None
            match kind:
                case None:
                    yield line
                case 0:  # lost
                    continue
                case 1:  # doubled
                    yield line + line
                case 2:  # delayed
                    due_s = self._time_s + chance.uniform(0.0, noise.delay_s)
                    heapq.heappush(self._under_way, (due_s, next(self._numbers), to_host, line))
                case 3:  # garbled
                    garbled = bytearray(line)
                    for _ in range(chance.randint(1, _GARBLED_BYTES)):
                        garbled[chance.randrange(len(garbled))] = chance.randrange(256)
                    yield bytes(garbled)
                case _:  # cut short
                    yield line[: chance.randrange(len(line))]
