"""The controller's digital lines and the wires on them, which may be stuck or swapped."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cellctl.sim.plant import Plant

LINES = 18
"""Bits 0-7 are the standard lines, 8-15 the configurable ones, 16 and 17 those of the tool."""
_GROUPS = {"standard": (0, 0xFF), "configurable": (8, 0xFF), "tool": (16, 0x03)}


@dataclass
class Wires:
    """What a bundle of wires does to the levels on it."""

    stuck: dict[int, bool] = field(default_factory=dict)
    flipped: set[int] = field(default_factory=set)

    def carry(self, bits: int) -> int:
        """The levels at the far end."""
        for line in self.flipped:
            bits ^= 1 << line
        for line, high in self.stuck.items():
            bits = bits | 1 << line if high else bits & ~(1 << line)
        return bits


class Lines:
    """Outputs as the program has set them, and inputs as the controller sees them.

    A broken output is not seen by the controller: it shows the level that was asked for.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self.output_wires = Wires()
        self.input_wires = Wires()
        self.outputs = 0
        self.inputs = 0
        self._at_plant: int | None = None

    def write(self, values: Mapping[str, object]) -> None:
        """Take what an RTDE package says of the digital outputs."""
        for group, (first, width) in _GROUPS.items():
            mask = values.get(f"{group}_digital_output_mask")
            levels = values.get(f"{group}_digital_output")
            if isinstance(mask, int) and isinstance(levels, int):
                mask &= width
                cleared = self.outputs & ~(mask << first)
                self.outputs = cleared | (levels & mask) << first

    def switch(self, line: int, high: bool) -> None:
        """Somebody switches a digital output on the teach pendant."""
        self.outputs = self.outputs | 1 << line if high else self.outputs & ~(1 << line)

    def exchange(self) -> None:
        """Bring the outputs to the plant when they have changed, and read its inputs."""
        levels = self.output_wires.carry(self.outputs)
        if levels != self._at_plant:
            self._at_plant = levels
            self._plant.outputs_changed(levels)
        self.inputs = self.input_wires.carry(self._plant.inputs())
