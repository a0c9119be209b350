"""The gripper's board with its compiled program: two lines to the robot, a servo, a serial port."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from cellctl.assembly import Value
from cellctl.boards.constants import BoardRole, Command, ReplyKind, ResetCause
from cellctl.boards.line import CommandLine, encode_command
from cellctl.config import CellConfig
from cellctl.sim.avr.board import FirmwareBoard
from cellctl.sim.avr.latch import ServoLatch
from cellctl.sim.avr.simulator import BoardCrashedError, PinChange
from cellctl.sim.gripper_board import FAULTS, Reset, StoreDamaged
from cellctl.sim.world import World

_COMMAND: Final = "PA1"
_STATUS: Final = "PA2"
_SERVO: Final = "PA3"
_PART: Final = "PA7"
"""Low while the switch feels a part."""
_LONGEST_S: Final = 0.01
_BOOT_S: Final = 0.1
_ANSWER_S: Final = 0.05
_KEEP_TRIES: Final = 5
"""A record takes 0.1 s to be written."""


class FirmwareGripper(FirmwareBoard):
    """The board that turns the latch. Its serial port appears where ``gripper.port`` says.

    Args:
        world: where the parts are.
        config: an emulated cell.

    Raises:
        UsageError: the program or the simulator is not there.
    """

    def __init__(self, world: World, config: CellConfig) -> None:
        super().__init__(
            BoardRole.GRIPPER,
            config,
            port=config.gripper.port,
            option="gripper.port",
            kinds=FAULTS,
        )
        self.latch = ServoLatch(world, self.simulator.set_supply)

    def start(self) -> None:
        """Make the port and switch the board on; it has a calibration, as a gripper at work has.

        Raises:
            UsageError: the port's name is taken by something else, or cannot be made.
            BoardCrashedError: the program cannot be loaded, or does not keep a calibration.
        """
        super().start()
        self._keep_calibration()

    def _keep_calibration(self) -> None:
        """Have the program write its record into the EEPROM, before anybody else is heard."""
        pins = {_COMMAND: "L", _PART: "Z"}
        self.simulator.advance(_BOOT_S, pins)
        for sequence, command in enumerate((Command.IDENTIFY, *[Command.KEEP] * _KEEP_TRIES)):
            number = min(sequence, 1)  # the same number asks how the newest command goes on
            line = encode_command(CommandLine(number, command))
            said = self.simulator.advance(_ANSWER_S, pins, line).serial
        if ReplyKind.OK.encode() not in said:
            raise BoardCrashedError(
                f"The gripper's program does not keep its calibration: {said!r}."
            )
        self.simulator.reset(ResetCause.POWER)

    def truth(self) -> dict[str, Any]:
        """What is really so, for judges and tests."""
        return {"resets": self._resets, "lines": self._lines, "faults": self._faults.names()}

    @property
    def _longest_s(self) -> float:
        return _LONGEST_S

    def _wiring(self) -> dict[str, str]:
        return {
            _COMMAND: "H" if self.latch.told_open else "L",
            _PART: "L" if self.latch.holds_part else "Z",
        }

    def _follow(self, changes: Sequence[PinChange]) -> None:
        latch = self.latch
        for change in changes:
            if change.pin == _SERVO:
                latch.servo.level(change.time_s, change.high)
            elif change.pin == _STATUS:
                latch.line = change.high
        latch.servo.advance(self.simulator.time_s)
        latch.follow()
        pending = self._faults.get(Reset)
        doing = "opening" if latch.told_open else "closing"
        if pending is not None and latch.moving and pending.when == doing:
            self._faults.end(Reset)
            self.reset(pending.cause)

    def _struck(self, fault: Value) -> None:
        match fault:
            case Reset(cause=cause, when="now"):
                self._faults.end(Reset)
                self.reset(cause)
            case StoreDamaged():
                self._faults.end(StoreDamaged)
                first = self.simulator.read_eeprom()[0]
                self.simulator.write_eeprom(0, bytes((first ^ 0x10,)))

    def _mended(self, kind: type[Value]) -> None:
        """Nothing lasts but what the cable suffers."""
