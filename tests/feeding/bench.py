"""A test bench: a conveyor driver, the emulated board behind a real pty, and a belt of parts."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cellctl.config import CellConfig, load_config
from cellctl.feeding.conveyor import Conveyor
from cellctl.sim.avr.conveyor import FirmwareConveyor
from cellctl.sim.boards import ConveyorBoard
from cellctl.sim.conveyor import ConveyorEmulator
from tests.feeding.paced_clock import PacedClock

SIM_CONFIG = Path(__file__).parents[2] / "config" / "sim.toml"
PITCH_M = 0.1
TICK_S = 0.005
"""Cell time that passes at once, while the host has at least a millisecond to answer."""
SENSOR_M = 0.0015
DEADLINE_S = 20.0


class PartsOnBelt:
    """A belt without an end stop: an advance too many carries a part past the sensor."""

    def __init__(self, parts: int, pitch_m: float = PITCH_M) -> None:
        self.ahead_m = [pitch_m * (number + 1) for number in range(parts)]
        """How far each part has still to go to the pick station."""
        self.travel_m = 0.0
        """Net travel, forward less backward."""
        self._pitch_m = pitch_m

    def belt_move(self, distance_m: float) -> None:
        self.travel_m += distance_m
        self.ahead_m = [ahead_m - distance_m for ahead_m in self.ahead_m]

    def part_at_pick(self) -> bool:
        return any(abs(ahead_m) < SENSOR_M for ahead_m in self.ahead_m)

    def take(self) -> None:
        """The arm takes the part at the pick station."""
        self.ahead_m.remove(next(ahead for ahead in self.ahead_m if abs(ahead) < SENSOR_M))


class PartsAtStop(PartsOnBelt):
    """A belt with an end stop: it slips under the part that waits there, and the others queue up.

    A compiled board presses each part against it, so what counts is how far the last one has come.
    """

    def belt_move(self, distance_m: float) -> None:
        nearest_m, moved_m = 0.0, distance_m
        for number, ahead_m in enumerate(self.ahead_m):
            self.ahead_m[number] = max(ahead_m - distance_m, nearest_m)
            nearest_m = self.ahead_m[number] + self._pitch_m
            moved_m = ahead_m - self.ahead_m[number]
        self.travel_m += moved_m


@dataclass
class Bench:
    """All that a test of the belt works with."""

    config: CellConfig
    clock: PacedClock
    world: PartsOnBelt
    emulator: ConveyorBoard
    conveyor: Conveyor

    async def until(self, holds: Callable[[], bool]) -> None:
        """Wait until something holds; fails after ``DEADLINE_S`` of wall time."""
        async with asyncio.timeout(DEADLINE_S):
            while not holds():
                await self.clock.sleep(0.01)

    async def indexing_at(self, distance_m: float) -> None:
        """Wait until the belt has gone this far."""
        await self.until(lambda: self.world.travel_m >= distance_m)

    async def take(self) -> None:
        """The arm takes the part at the pick station, which a sensor needs a moment to see."""
        self.world.take()
        await self.clock.sleep(0.05)

    async def at_rest(self) -> None:
        """Wait until the belt stands still."""
        await self.until(lambda: not self.emulator.truth().moving)


def cell_config(port: Path, pitch_m: float = PITCH_M, **feeder: Any) -> CellConfig:
    """The emulated cell with its conveyor at this port and with other feeder settings."""
    config = load_config(SIM_CONFIG)
    settings = config.feeder.model_copy(update={"port": str(port), **feeder})
    voxel = config.voxel.model_copy(update={"pitch_m": pitch_m})
    return config.model_copy(update={"feeder": settings, "voxel": voxel})


@asynccontextmanager
async def bench(
    parts: int = 5, pitch_m: float = PITCH_M, kind: str = "plain", **feeder: Any
) -> AsyncIterator[Bench]:
    """Everything running; taken apart again at the end.

    Args:
        parts: how many lie on the belt.
        pitch_m: from part to part.
        kind: plain or elf: what the board is.
        feeder: settings to change.
    """
    with tempfile.TemporaryDirectory() as folder:
        config = cell_config(Path(folder) / "cell" / "conveyor", pitch_m, **feeder)
        clock = PacedClock()
        compiled = kind == "elf"
        world = (PartsAtStop if compiled else PartsOnBelt)(parts, pitch_m)
        emulator: ConveyorBoard = (
            FirmwareConveyor(world, config) if compiled else ConveyorEmulator(world, config)
        )
        emulator.start()
        running = asyncio.create_task(_advance(emulator, clock))
        conveyor = Conveyor(config.feeder, config.voxel.pitch_m, clock)
        try:
            yield Bench(config, clock, world, emulator, conveyor)
        finally:
            await conveyor.close()
            running.cancel()
            with suppress(asyncio.CancelledError):
                await running
            emulator.stop()
        assert not (Path(folder) / "cell").exists(), "the emulator left its port behind"


async def _advance(emulator: ConveyorBoard, clock: PacedClock) -> None:
    while True:
        await asyncio.sleep(0.001)
        emulator.advance(TICK_S)
        clock.step(TICK_S)
