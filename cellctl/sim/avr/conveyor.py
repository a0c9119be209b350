"""The conveyor's board with its compiled program: a stepper that turns the world's belt."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from cellctl.assembly import Value
from cellctl.boards.constants import LATCHING, BoardRole, ConveyorFlag, ErrorCode
from cellctl.boards.line import REPLY_START, LineError, Reply, decode_reply
from cellctl.config import CellConfig
from cellctl.sim.avr.board import FirmwareBoard
from cellctl.sim.avr.simulator import PinChange
from cellctl.sim.conveyor import BeltWorld, ConveyorTruth
from cellctl.sim.conveyor_faults import FAULTS, Jam, Reset, SensorBlocked, Stall

STEP_M: Final = 0.001 / 40
"""Of the belt, for each of the motor's steps."""
RESTING_S: Final = 0.01
MOVING_S: Final = 0.004
"""How long the program may run at once while the motor turns: 0.4 mm of belt, by which the sensor
may tell late."""
REST_S: Final = 0.01
"""A motor that was not told to step for this long stands still; its slowest step takes 3 ms."""
_PART: Final = "PA4"
"""Low while the sensor sees a part."""
_STALL: Final = "PA5"
"""High while the driver reports that the motor does not follow."""


class FirmwareConveyor(FirmwareBoard):
    """A conveyor's board, its belt drive and its part sensor.

    Args:
        world: the belt and the parts on it.
        config: an emulated cell; ``feeder.port`` is where the port appears.

    Raises:
        UsageError: the program or the simulator is not there.
    """

    def __init__(self, world: BeltWorld, config: CellConfig) -> None:
        super().__init__(
            BoardRole.CONVEYOR,
            config,
            port=config.feeder.port,
            option="feeder.port",
            kinds=FAULTS,
        )
        self._world = world
        self._backward = self._powered = self._saw_part = False
        self._stepped_s = -math.inf
        """When the motor was last told to step, in the board's time."""
        self._travel_m = self._motion_m = self._turning_m = 0.0
        self._motions = self._indexes = 0
        self._error: ErrorCode | None = None

    def truth(self) -> ConveyorTruth:
        """What is really so."""
        return ConveyorTruth(
            moving=self._moving,
            travel_m=self._travel_m,
            motions=self._motions,
            indexes=self._indexes,
            resets=self._resets,
            lines=self._lines,
            error=self._error,
            faults=self._faults.names(),
        )

    @property
    def _longest_s(self) -> float:
        return MOVING_S if self._moving else RESTING_S

    def _wiring(self) -> dict[str, str]:
        stalled = self._moving and self._faults.get(Stall) is not None
        return {_PART: "L" if self._sensor() else "Z", _STALL: "H" if stalled else "L"}

    def _follow(self, changes: Sequence[PinChange]) -> None:
        for change in changes:
            self._obey(change)
        self._turn_belt()
        self._count_index()

    def _obey(self, change: PinChange) -> None:
        """Step, direction (high is backward), and enable, which is low for current."""
        match change.pin:
            case "PA1" if self._powered:
                if change.time_s - self._stepped_s > REST_S:
                    self._motions += 1
                    self._motion_m = 0.0
                self._stepped_s = change.time_s
                self._turning_m += STEP_M
            case "PA2":
                self._turn_belt()
                self._backward = change.high
            case "PA3":
                self._turn_belt()
                self._powered = not change.high

    @property
    def _moving(self) -> bool:
        return self.simulator.time_s - self._stepped_s <= REST_S

    def _turn_belt(self) -> None:
        distance_m, self._turning_m = self._turning_m, 0.0
        if distance_m == 0.0 or self._faults.get(Stall):
            return
        self._travel_m += distance_m
        self._motion_m += distance_m
        if not self._faults.get(Jam):
            self._world.belt_move(-distance_m if self._backward else distance_m)
        reset = self._faults.get(Reset)
        if reset is not None and reset.after_m is not None and self._motion_m >= reset.after_m:
            self._faults.end(Reset)
            self.reset(reset.cause)

    def _count_index(self) -> None:
        sees_part = self._world.part_at_pick()
        if sees_part and not self._saw_part and self._moving and not self._backward:
            self._indexes += 1
        self._saw_part = sees_part

    def _sensor(self) -> bool:
        blocked = self._faults.get(SensorBlocked)
        return self._world.part_at_pick() if blocked is None else blocked.reads

    def _say(self, line: bytes) -> None:
        if line.startswith(REPLY_START):
            self._learn(line)
        else:
            self._error = None  # a banner: the board has forgotten
        super()._say(line)

    def _learn(self, line: bytes) -> None:
        try:
            reply = decode_reply(line)
        except LineError:
            return
        if not isinstance(reply, Reply):
            return
        if reply.error in LATCHING:
            self._error = reply.error
        elif reply.status is not None and not reply.status.flags & ConveyorFlag.LATCHED:
            self._error = None

    def _struck(self, fault: Value) -> None:
        if isinstance(fault, Reset) and fault.after_m is None:
            self._faults.end(Reset)
            self.reset(fault.cause)

    def _mended(self, kind: type[Value]) -> None:
        """Nothing lasts but what the faults themselves say."""
