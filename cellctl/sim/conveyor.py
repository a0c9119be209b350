"""The emulated conveyor: a board behind a pseudo-terminal that turns the world's belt.

It does what a small firmware does: one motion at a time, one sequence number and one outcome
remembered. Everything happens in ``advance``, in cell time, the host's silence included.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Protocol

from cellctl.assembly import Value
from cellctl.boards.constants import (
    COMMANDS,
    COUNTER_COUNT,
    LATCHING,
    MOTIONS,
    PITCH_MAX,
    PITCH_MIN,
    PITCH_UNIT_M,
    SILENCE_S,
    TRAVEL_LIMIT_PITCHES,
    BoardRole,
    Command,
    ConveyorFlag,
    ErrorCode,
    ReplyKind,
)
from cellctl.boards.line import CommandLine, Reply, Status
from cellctl.config import CellConfig
from cellctl.sim.board import BoardEmulator, error_reply
from cellctl.sim.conveyor_faults import FAULTS, Jam, Reset, SensorBlocked, Stall

BELT_SPEED_M_S: Final = 0.1
"""Speed of the emulated belt, in cell time; it starts and stops at once."""
STEP_S: Final = 0.01
"""The sensor is looked at after each such piece of a motion, which is 1 mm of belt."""
SERIAL_NUMBER: Final = "1E952253494D00000001"


class BeltWorld(Protocol):
    """What the conveyor turns, and what its sensor sees."""

    def belt_move(self, distance_m: float) -> None:
        """Turn the belt; positive feeds towards the pick station."""
        ...

    def part_at_pick(self) -> bool:
        """What the part sensor at the pick station sees."""
        ...


class ConveyorTruth(Value):
    """What the emulated board is really doing, for judges and tests."""

    moving: bool
    travel_m: float
    """How far the motor has turned the belt, in both directions together."""
    motions: int
    """Motions begun; a repeated line begins none."""
    indexes: int
    """Parts brought to the pick station; a reset does not zero it."""
    resets: int
    lines: int
    """Valid command lines heard."""
    error: ErrorCode | None
    """Latched in the board."""
    faults: tuple[str, ...]
    """Names of the injected faults that are active."""


@dataclass
class _Motion:
    """An index under way."""

    sequence: int
    command: Command
    pitch_m: float
    travelled_m: float = 0.0


class ConveyorEmulator(BoardEmulator):
    """A conveyor's board, its belt drive and its part sensor.

    Args:
        world: the belt and the parts on it.
        config: an emulated cell; ``feeder.port`` is where the port appears.
    """

    def __init__(self, world: BeltWorld, config: CellConfig) -> None:
        assert config.emulation is not None, "an emulated cell has an [emulation] table"
        self._world = world
        # The host answers in wall time, so the window grows with the clock.
        self._silence_s = SILENCE_S * max(1.0, config.cell.clock_rate)
        self._travel_m = 0.0
        self._motions = self._indexes = 0
        super().__init__(
            BoardRole.CONVEYOR,
            serial_number=SERIAL_NUMBER,
            port=Path(config.feeder.port),
            option="feeder.port",
            kinds=FAULTS,
            seed=config.emulation.seed,
        )

    def advance(self, dt_s: float) -> None:
        """Hear what has arrived, then let ``dt_s`` of cell time pass. Never waits."""
        self._cable.advance(dt_s)
        self._receive()
        while self._motion is not None and dt_s > 0.0:
            piece_s = min(dt_s, STEP_S)
            self._turn(self._motion, piece_s)
            dt_s -= piece_s
            self._receive()

    def truth(self) -> ConveyorTruth:
        """What is really so."""
        return ConveyorTruth(
            moving=self._motion is not None,
            travel_m=self._travel_m,
            motions=self._motions,
            indexes=self._indexes,
            resets=self._resets,
            lines=self._lines,
            error=self._error,
            faults=self._faults.names(),
        )

    # --- the board ----------------------------------------------------------------------------

    def _struck(self, fault: Value) -> None:
        if isinstance(fault, Reset) and fault.after_m is None:
            self._faults.end(Reset)
            self.reset(fault.cause)

    def _forget(self) -> None:
        super()._forget()
        self._outcome: Reply | None = None
        """Of the motion with the newest number."""
        self._motion: _Motion | None = None
        self._error: ErrorCode | None = None
        self._counter = 0

    def _begin_session(self) -> None:
        self._stop(ErrorCode.HALTED)
        self._outcome = None

    def _act(self, line: CommandLine) -> Reply:
        if line.sequence != self._last:
            self._last, self._outcome = line.sequence, None
        if line.command not in MOTIONS:
            return self._act_at_rest(line)
        motion = self._motion
        if self._outcome is None and motion is not None and motion.sequence == line.sequence:
            return Reply(line.sequence, ReplyKind.BUSY, self._status())
        if self._outcome is None:
            self._outcome = self._begin(line)
        return self._outcome or Reply(line.sequence, ReplyKind.BUSY, self._status())

    def _act_at_rest(self, line: CommandLine) -> Reply:
        """Answer a command that begins no motion; carrying it out again changes nothing."""
        if line.argument is not None:
            return error_reply(line, ErrorCode.ARGUMENT)
        if line.command not in COMMANDS[BoardRole.CONVEYOR]:
            return error_reply(line, ErrorCode.COMMAND)
        match line.command:
            case Command.STATUS:
                pass
            case Command.HALT:
                self._stop(ErrorCode.HALTED)
            case Command.CLEAR:
                self._error = None
        return Reply(line.sequence, ReplyKind.OK, self._status())

    def _begin(self, line: CommandLine) -> Reply | None:
        """Begin a motion, or say at once how it ends."""
        if line.argument is None or not PITCH_MIN <= line.argument <= PITCH_MAX:
            return error_reply(line, ErrorCode.ARGUMENT)
        if self._error is not None:
            return error_reply(line, ErrorCode.LATCHED)
        if self._motion is not None:
            return error_reply(line, ErrorCode.MOVING)
        if line.command == Command.FORWARD and self._sensor():
            return Reply(line.sequence, ReplyKind.OK, self._status())
        self._motions += 1
        self._motion = _Motion(line.sequence, Command(line.command), line.argument * PITCH_UNIT_M)
        return None

    def _stop(self, error: ErrorCode | None) -> None:
        """End the motion under way, if there is one, and keep its outcome."""
        motion, self._motion = self._motion, None
        if motion is None:
            return
        if error in LATCHING:
            self._error = error
        if motion.sequence == self._last:
            self._outcome = (
                Reply(motion.sequence, ReplyKind.OK, self._status())
                if error is None
                else Reply(motion.sequence, ReplyKind.ERR, error=error)
            )

    # --- the drive and the sensor -------------------------------------------------------------

    def _turn(self, motion: _Motion, dt_s: float) -> None:
        self._unheard_s += dt_s
        if self._unheard_s >= self._silence_s:
            self._stop(ErrorCode.SILENCE)
            return
        if self._faults.get(Stall):
            self._stop(ErrorCode.NO_MOTION)
            return
        distance_m = BELT_SPEED_M_S * dt_s
        if not self._faults.get(Jam):
            self._world.belt_move(distance_m if motion.command is Command.FORWARD else -distance_m)
        motion.travelled_m += distance_m
        self._travel_m += distance_m
        reset = self._faults.get(Reset)
        if reset is not None and motion.travelled_m >= (reset.after_m or 0.0):
            self._faults.end(Reset)
            self.reset(reset.cause)
        elif motion.command is Command.FORWARD:
            self._end_forward(motion)
        elif motion.travelled_m >= motion.pitch_m:
            self._stop(ErrorCode.NO_MOTION if self._sensor() else None)

    def _end_forward(self, motion: _Motion) -> None:
        if self._sensor():
            self._indexes += 1
            self._counter = (self._counter + 1) % COUNTER_COUNT
            self._stop(None)
        elif motion.travelled_m >= TRAVEL_LIMIT_PITCHES * motion.pitch_m:
            self._stop(ErrorCode.NO_EDGE)

    def _sensor(self) -> bool:
        blocked = self._faults.get(SensorBlocked)
        return self._world.part_at_pick() if blocked is None else blocked.reads

    # --- what it says -------------------------------------------------------------------------

    def _status(self) -> Status:
        flags = ConveyorFlag(0)
        if self._sensor():
            flags |= ConveyorFlag.PART
        if self._motion is not None:
            flags |= ConveyorFlag.MOVING
        if self._error is not None:
            flags |= ConveyorFlag.LATCHED
        return Status(flags, self._counter)
