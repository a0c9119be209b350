"""The emulated conveyor: a board behind a pseudo-terminal that turns the world's belt.

It does what a small firmware does: one motion at a time, one sequence number and one outcome
remembered. Everything happens in ``advance``, in cell time, the host's silence included.
"""

from __future__ import annotations

import random
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Protocol

from cellctl.assembly import Value
from cellctl.boards.constants import (
    COMMAND_LIMIT,
    COUNTER_COUNT,
    FIRMWARE_VERSION,
    LATCHING,
    MOTIONS,
    PITCH_MAX,
    PITCH_MIN,
    PITCH_UNIT_M,
    PROTOCOL_VERSION,
    SILENCE_S,
    TRAVEL_LIMIT_PITCHES,
    BoardRole,
    Command,
    ConveyorFlag,
    ErrorCode,
    ReplyKind,
    ResetCause,
)
from cellctl.boards.line import (
    COMMAND_START,
    Banner,
    CommandLine,
    Identity,
    LineError,
    LineSplitter,
    Reply,
    Status,
    decode_command,
    encode_banner,
    encode_reply,
    is_stale,
)
from cellctl.config import CellConfig
from cellctl.sim.conveyor_faults import (
    ActiveFaults,
    CorruptedReplies,
    Garbage,
    Jam,
    LostReplies,
    Reset,
    SensorBlocked,
    Silent,
    Stall,
    Unplugged,
    WrongProtocol,
    WrongRole,
)
from cellctl.sim.pseudo_terminal import PseudoTerminal

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


@dataclass
class _Memory:
    """All that the board remembers; a reset wipes it out."""

    identified: bool = False
    last: int = 0
    """Sequence number of the newest command."""
    outcome: Reply | None = None
    """Of the motion with that number."""
    motion: _Motion | None = None
    error: ErrorCode | None = None
    indexes: int = 0
    unheard_s: float = 0.0
    splitter: LineSplitter = field(
        default_factory=lambda: LineSplitter((COMMAND_START,), COMMAND_LIMIT)
    )


class ConveyorEmulator:
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
        self._port = PseudoTerminal(Path(config.feeder.port))
        self._random = random.Random(config.emulation.seed)  # noqa: S311 - repeatable chance
        self._faults = ActiveFaults()
        self._memory = _Memory()
        self._travel_m = 0.0
        self._motions = self._indexes = self._resets = self._lines = 0

    def start(self) -> None:
        """Make the port and switch the board on.

        Raises:
            UsageError: the port's name is taken by something else, or cannot be made.
        """
        self._port.open()
        self._boot(ResetCause.POWER)

    def stop(self) -> None:
        """Take the port away; safe to repeat."""
        self._port.close()

    def advance(self, dt_s: float) -> None:
        """Hear what has arrived, then let ``dt_s`` of cell time pass. Never waits."""
        self._receive()
        while self._memory.motion is not None and dt_s > 0.0:
            piece_s = min(dt_s, STEP_S)
            self._turn(self._memory.motion, piece_s)
            dt_s -= piece_s
            self._receive()

    def inject(self, fault: str, **arguments: Any) -> None:
        """Switch on one of ``conveyor_faults.FAULTS``.

        Raises:
            UsageError: there is no such fault, or not with these arguments.
        """
        match self._faults.inject(fault, arguments):
            case Unplugged():
                self._port.close()
            case Reset(cause=cause, after_m=None):
                self._faults.end(Reset)
                self._reset(cause)

    def clear(self, fault: str) -> None:
        """Switch a fault off.

        Raises:
            UsageError: there is no such fault.
        """
        if self._faults.clear(fault) is Unplugged and not self._port.is_open:
            self._port.open()
            self._reset(ResetCause.POWER)

    def truth(self) -> ConveyorTruth:
        """What is really so."""
        return ConveyorTruth(
            moving=self._memory.motion is not None,
            travel_m=self._travel_m,
            motions=self._motions,
            indexes=self._indexes,
            resets=self._resets,
            lines=self._lines,
            error=self._memory.error,
            faults=self._faults.names(),
        )

    # --- the board ----------------------------------------------------------------------------

    def _reset(self, cause: ResetCause) -> None:
        self._resets += 1
        self._boot(cause)

    def _boot(self, cause: ResetCause) -> None:
        self._memory = _Memory()
        self._send(encode_banner(Banner(self._role(), self._protocol_version(), cause)))

    def _receive(self) -> None:
        if not self._port.is_open:
            return
        data = self._port.read()
        if self._faults.get(Silent):
            return
        memory = self._memory
        for frame in memory.splitter.feed(data):
            try:
                line = decode_command(frame)
            except LineError:
                continue
            self._lines += 1
            memory.unheard_s = 0.0
            self._send(encode_reply(self._answer(line)))

    def _answer(self, line: CommandLine) -> Reply:
        memory = self._memory
        if line.command == Command.IDENTIFY and line.argument is None:
            self._stop(ErrorCode.HALTED)
            memory.identified, memory.last, memory.outcome = True, line.sequence, None
            return Reply(line.sequence, ReplyKind.OK, identity=self._identity())
        if not memory.identified:
            return _error(line, ErrorCode.UNREADY)
        if is_stale(line.sequence, memory.last):
            return _error(line, ErrorCode.STALE)
        if line.sequence != memory.last:
            memory.last, memory.outcome = line.sequence, None
        if line.command not in MOTIONS:
            return self._answer_at_rest(line)
        motion = memory.motion
        if memory.outcome is None and motion is not None and motion.sequence == line.sequence:
            return Reply(line.sequence, ReplyKind.BUSY, self._status())
        if memory.outcome is None:
            memory.outcome = self._begin(line)
        return memory.outcome or Reply(line.sequence, ReplyKind.BUSY, self._status())

    def _answer_at_rest(self, line: CommandLine) -> Reply:
        """Answer a command that begins no motion; carrying it out again changes nothing."""
        if line.argument is not None:
            return _error(line, ErrorCode.ARGUMENT)
        match line.command:
            case Command.STATUS:
                pass
            case Command.HALT:
                self._stop(ErrorCode.HALTED)
            case Command.CLEAR:
                self._memory.error = None
            case _:
                return _error(line, ErrorCode.COMMAND)
        return Reply(line.sequence, ReplyKind.OK, self._status())

    def _begin(self, line: CommandLine) -> Reply | None:
        """Begin a motion, or say at once how it ends."""
        memory = self._memory
        if line.argument is None or not PITCH_MIN <= line.argument <= PITCH_MAX:
            return _error(line, ErrorCode.ARGUMENT)
        if memory.error is not None:
            return _error(line, ErrorCode.LATCHED)
        if memory.motion is not None:
            return _error(line, ErrorCode.MOVING)
        if line.command == Command.FORWARD and self._sensor():
            return Reply(line.sequence, ReplyKind.OK, self._status())
        self._motions += 1
        memory.motion = _Motion(line.sequence, Command(line.command), line.argument * PITCH_UNIT_M)
        return None

    def _stop(self, error: ErrorCode | None) -> None:
        """End the motion under way, if there is one, and keep its outcome."""
        memory = self._memory
        motion, memory.motion = memory.motion, None
        if motion is None:
            return
        if error in LATCHING:
            memory.error = error
        if motion.sequence == memory.last:
            memory.outcome = (
                Reply(motion.sequence, ReplyKind.OK, self._status())
                if error is None
                else Reply(motion.sequence, ReplyKind.ERR, error=error)
            )

    # --- the drive and the sensor -------------------------------------------------------------

    def _turn(self, motion: _Motion, dt_s: float) -> None:
        self._memory.unheard_s += dt_s
        if self._memory.unheard_s >= self._silence_s:
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
            self._reset(reset.cause)
        elif motion.command is Command.FORWARD:
            self._end_forward(motion)
        elif motion.travelled_m >= motion.pitch_m:
            self._stop(ErrorCode.NO_MOTION if self._sensor() else None)

    def _end_forward(self, motion: _Motion) -> None:
        if self._sensor():
            self._indexes += 1
            self._memory.indexes = (self._memory.indexes + 1) % COUNTER_COUNT
            self._stop(None)
        elif motion.travelled_m >= TRAVEL_LIMIT_PITCHES * motion.pitch_m:
            self._stop(ErrorCode.NO_EDGE)

    def _sensor(self) -> bool:
        blocked = self._faults.get(SensorBlocked)
        return self._world.part_at_pick() if blocked is None else blocked.reads

    # --- what it says -------------------------------------------------------------------------

    def _status(self) -> Status:
        memory = self._memory
        flags = ConveyorFlag(0)
        if self._sensor():
            flags |= ConveyorFlag.PART
        if memory.motion is not None:
            flags |= ConveyorFlag.MOVING
        if memory.error is not None:
            flags |= ConveyorFlag.LATCHED
        return Status(flags, memory.indexes)

    def _identity(self) -> Identity:
        return Identity(
            self._role(),
            SERIAL_NUMBER,
            self._protocol_version(),
            FIRMWARE_VERSION[BoardRole.CONVEYOR],
        )

    def _role(self) -> str:
        wrong = self._faults.get(WrongRole)
        return BoardRole.CONVEYOR if wrong is None else wrong.role

    def _protocol_version(self) -> int:
        wrong = self._faults.get(WrongProtocol)
        return PROTOCOL_VERSION if wrong is None else wrong.version

    def _send(self, frame: bytes) -> None:
        if not self._port.is_open or self._faults.get(Silent):
            return
        if self._faults.use_up(LostReplies):
            return
        if self._faults.use_up(CorruptedReplies):
            damaged = bytearray(frame)
            damaged[self._random.randrange(len(frame))] ^= 1 << self._random.randrange(8)
            frame = bytes(damaged)
        if garbage := self._faults.get(Garbage):
            frame = self._random.randbytes(garbage.count) + frame
        self._port.write(frame)


def _error(line: CommandLine, error: ErrorCode) -> Reply:
    return Reply(line.sequence, ReplyKind.ERR, error=error)
