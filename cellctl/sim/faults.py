"""The faults that can be injected into the emulated cell: one table, which is data.

``docs/emulated-cell.md`` shows it to people.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import Any, NamedTuple

from cellctl.errors import UsageError
from cellctl.sim.messages import Argument


class Device(StrEnum):
    """Where a fault is injected."""

    ROBOT = "robot"
    GRIPPER = "gripper"
    GRIPPER_BOARD = "gripper board"
    CONVEYOR = "conveyor"
    WORLD = "world"


class Parameter(NamedTuple):
    """One argument of a fault."""

    name: str
    kind: type[str] | type[int] | type[float] | type[bool]
    """An int is taken where a float is asked for."""
    meaning: str
    """With its unit."""
    default: Argument | None = None
    """None: there is none, and the argument is left out when it is not given."""
    required: bool = False


class Fault(NamedTuple):
    """One row of the table."""

    name: str
    device: Device
    effect: str
    """What the device's own emulator calls it."""
    title: str
    parameters: tuple[Parameter, ...] = ()
    once: bool = False
    """Happens at once and is over; there is nothing to clear."""
    remedy: str = ""
    """What sets it right, where that is not ``clear``."""

    def complete(self, arguments: Mapping[str, Argument]) -> dict[str, Any]:
        """The arguments, with defaults for those that are not given.

        Raises:
            UsageError: one is unknown, missing or of another type; with what is known.
        """
        known = {parameter.name: parameter for parameter in self.parameters}
        for name in arguments:
            if name not in known:
                names = ", ".join(known) or "none"
                raise UsageError(f"{self.name} has no argument {name!r}.", f"It has: {names}.")
        complete = {}
        for name, (_, kind, meaning, default, required) in known.items():
            value = arguments.get(name, default)
            if value is None and required:
                raise UsageError(f"{self.name} needs {name}: {meaning}.")
            if value is None:
                continue
            if type(value) is not kind and not (kind is float and type(value) is int):
                raise UsageError(
                    f"{self.name}: {name} = {value!r} is no {kind.__name__}.", f"It is {meaning}."
                )
            complete[name] = value
        return complete


_LINES = "0-7 standard, 8-15 configurable, 16-17 tool"
_OUTPUT = Parameter("line", int, f"a digital output, {_LINES}", required=True)
_INPUT = Parameter("line", int, f"a digital input, {_LINES}", required=True)
_LEVEL = Parameter("high", bool, "the level at which it is stuck", False)
_ROBOT = (
    Fault(
        "protective_stop",
        Device.ROBOT,
        "protective_stop",
        "The controller makes a protective stop.",
        (Parameter("cause", str, "what the controller tells as its reason", "injected"),),
        once=True,
        remedy="Unlock it, 5 s later at the earliest.",
    ),
    Fault(
        "safeguard_stop",
        Device.ROBOT,
        "safeguard_stop",
        "Somebody enters the guarded space; cleared when they have left it.",
    ),
    Fault(
        "emergency_stop",
        Device.ROBOT,
        "emergency_stop",
        "Somebody presses the emergency stop; cleared when the button is released.",
    ),
    Fault(
        "local_control",
        Device.ROBOT,
        "local_control",
        "Somebody switches the teach pendant to local control.",
    ),
    Fault(
        "kill_program",
        Device.ROBOT,
        "kill_program",
        "Somebody stops the robot's program on the pendant.",
        once=True,
        remedy="Send the program again.",
    ),
    Fault(
        "power_lost",
        Device.ROBOT,
        "power_lost",
        "The robot's controller loses power for a moment: outputs are low, and the arm is off.",
        once=True,
        remedy="Power the arm on, release its brakes, and connect again.",
    ),
    Fault(
        "drop_connections",
        Device.ROBOT,
        "drop_connections",
        "Every connection to the robot's controller is closed.",
        (Parameter("reset", bool, "whether by a TCP reset instead of an orderly close", False),),
        once=True,
        remedy="Connect again.",
    ),
    Fault(
        "freeze",
        Device.ROBOT,
        "freeze",
        "The robot's controller neither reads nor sends, with all connections open.",
    ),
    Fault(
        "refuse_connections",
        Device.ROBOT,
        "refuse_connections",
        "The robot's controller closes its ports.",
    ),
    Fault(
        "stuck_output",
        Device.ROBOT,
        "stuck_output",
        "A digital output keeps its level whatever the controller does.",
        (_OUTPUT, _LEVEL),
    ),
    Fault(
        "stuck_input",
        Device.ROBOT,
        "stuck_input",
        "A digital input reads the same level whatever is wired to it.",
        (_INPUT, _LEVEL),
    ),
    Fault(
        "flipped_output",
        Device.ROBOT,
        "flipped_output",
        "A digital output has the level opposite to what it should.",
        (_OUTPUT,),
    ),
    Fault(
        "flipped_input",
        Device.ROBOT,
        "flipped_input",
        "A digital input reads the level opposite to what is wired to it.",
        (_INPUT,),
    ),
    Fault(
        "payload_changed",
        Device.ROBOT,
        "payload_changed",
        "Somebody sets another payload on the pendant.",
        (Parameter("payload_kg", float, "the payload's mass in kilograms", 3.0),),
        once=True,
        remedy="Connect again, which sets the right one.",
    ),
    Fault(
        "tcp_changed",
        Device.ROBOT,
        "tcp_changed",
        "Somebody sets another TCP on the pendant.",
        (Parameter("z_m", float, "the TCP's distance from the flange in metres", 0.2),),
        once=True,
        remedy="Connect again, which sets the right one.",
    ),
    Fault(
        "tool_voltage_changed",
        Device.ROBOT,
        "tool_voltage_changed",
        "Somebody sets another voltage for the tool's connector on the pendant.",
        (Parameter("voltage_v", int, "0, 12 or 24 volts", 24),),
        once=True,
        remedy="Set the right one on the pendant: inject it with that voltage.",
    ),
    Fault(
        "output_changed",
        Device.ROBOT,
        "output_changed",
        "Somebody switches a digital output on the pendant.",
        (_OUTPUT, Parameter("high", bool, "the level to which it is switched", False)),
        once=True,
        remedy="Switch it back.",
    ),
    Fault(
        "speed_slider",
        Device.ROBOT,
        "speed_slider",
        "Somebody moves the speed slider on the pendant.",
        (Parameter("fraction", float, "its new place, from 0 to 1", 0.02),),
        once=True,
        remedy="Move it back: inject it with fraction 1.",
    ),
    Fault(
        "arm_guided",
        Device.ROBOT,
        "guide",
        "Somebody guides the arm by hand until a tip below the gripper is at a point.",
        (
            Parameter("x_m", float, "the point along x, in the cell frame", required=True),
            Parameter("y_m", float, "along y", required=True),
            Parameter("z_m", float, "its height", required=True),
            Parameter("pin_m", float, "how far the tip is below the TCP", 0.0),
            Parameter("tilt_x_rad", float, "how far the tool is tilted about x", 0.0),
            Parameter("tilt_y_rad", float, "and about y", 0.0),
        ),
        once=True,
        remedy="Guide it back, or move it with `cellctl hand`.",
    ),
    Fault(
        "reduced_mode",
        Device.ROBOT,
        "reduced_mode",
        "A safety input asks for the reduced limits; the arm still moves.",
    ),
)
_COUNT = Parameter("count", int, "how many replies it strikes", 1)
_CONVEYOR = (
    Fault("belt_jam", Device.CONVEYOR, "jam", "The belt's motor turns, and its parts stay."),
    Fault(
        "belt_stall",
        Device.CONVEYOR,
        "stall",
        "The belt's motor does not turn, and its driver says so.",
    ),
    Fault(
        "sensor_blocked",
        Device.CONVEYOR,
        "sensor_blocked",
        "The part sensor reads the same whatever is there.",
        (Parameter("reads", bool, "whether it always sees a part, or never does", True),),
    ),
)


def _of_board(device: Device, prefix: str, board: str, other: str) -> tuple[Fault, ...]:
    """What every board and its cable can suffer."""
    rows: tuple[tuple[str, str, str, tuple[Parameter, ...]], ...] = (
        ("board_silent", "silent", f"{board} neither hears nor answers.", ()),
        (
            "board_unplugged",
            "unplugged",
            f"{board} is unplugged: its port vanishes; once it is back, the board has been reset.",
            (),
        ),
        (
            "replies_lost",
            "lost_replies",
            f"The next replies of {board} never arrive, though it acts.",
            (_COUNT,),
        ),
        (
            "replies_corrupted",
            "corrupted_replies",
            f"One bit of each of the next replies of {board} is flipped.",
            (_COUNT,),
        ),
        (
            "replies_in_garbage",
            "garbage",
            f"Random bytes precede every reply of {board}.",
            (Parameter("count", int, "how many bytes", 20),),
        ),
        (
            "line_noise",
            "noise",
            f"Lines to and from {board} are lost, doubled, delayed, garbled or cut short.",
            (
                Parameter("share", float, "of all lines, that something happens to", 0.2),
                Parameter("delay_s", float, "the longest delay in seconds, 1 at most", 0.1),
            ),
        ),
        (
            "board_role",
            "wrong_role",
            f"Another board is on the port of {board}.",
            (Parameter("role", str, "what it calls itself", other),),
        ),
        (
            "board_protocol",
            "wrong_protocol",
            f"The firmware of {board} speaks another version of the protocol.",
            (Parameter("version", int, "the version, 0 to 255", 1),),
        ),
        (
            "board_firmware",
            "old_firmware",
            f"The firmware of {board} is of another version.",
            (Parameter("version", str, "the version, digits and dots", "0.9.0"),),
        ),
    )
    return tuple(
        Fault(prefix + name, device, effect, title[0].upper() + title[1:], parameters)
        for name, effect, title, parameters in rows
    )


def _hang(device: Device, prefix: str, board: str) -> Fault:
    return Fault(
        f"{prefix}board_hang",
        device,
        "hang",
        f"The program of {board} hangs, until its watchdog resets it.",
        (Parameter("interrupts", bool, "whether interrupts go on meanwhile", True),),
        once=True,
        remedy="Nothing: the watchdog resets the board.",
    )


_CONVEYOR_BOARD = (
    *_of_board(Device.CONVEYOR, "", "the conveyor's board", "gripper"),
    _hang(Device.CONVEYOR, "", "the conveyor's board"),
    Fault(
        "board_reset",
        Device.CONVEYOR,
        "reset",
        "The conveyor's board starts anew.",
        (
            Parameter("cause", str, "the cause that its banner tells", "brownout"),
            Parameter("after_m", float, "when a motion has gone this far, in metres; else at once"),
        ),
        once=True,
        remedy="Identify the board again.",
    ),
)
_GRIPPER_BOARD = (
    *_of_board(Device.GRIPPER_BOARD, "gripper_", "the gripper's board", "conveyor"),
    _hang(Device.GRIPPER_BOARD, "gripper_", "the gripper's board"),
    Fault(
        "gripper_board_reset",
        Device.GRIPPER_BOARD,
        "reset",
        "The gripper's board starts anew: the latch stays where it is, unconfirmed.",
        (
            Parameter("cause", str, "the cause that its banner tells", "watchdog"),
            Parameter("when", str, "now, or once the latch is opening or closing", "now"),
        ),
        once=True,
        remedy="Unlatch and latch again.",
    ),
    Fault(
        "gripper_store_damaged",
        Device.GRIPPER_BOARD,
        "store_damaged",
        "The gripper's calibration in the EEPROM is damaged, which the board finds out when it "
        "starts.",
        once=True,
        remedy="Set the calibration again and keep it.",
    ),
)
_GRIPPER = (
    Fault(
        "gripper_silent",
        Device.GRIPPER,
        "silent",
        "The latch moves, and its status line stays low.",
    ),
    Fault(
        "gripper_fault",
        Device.GRIPPER,
        "fault",
        "The latch does not move, and its status line toggles at 5 Hz.",
    ),
    Fault("gripper_stuck", Device.GRIPPER, "stuck", "The latch does not move; its status is low."),
    Fault(
        "command_glitch",
        Device.GRIPPER,
        "glitch",
        "The gripper's command line has the opposite level for a moment.",
        (Parameter("duration_s", float, "how long, in seconds", 0.004),),
        once=True,
        remedy="Nothing, if it is short: less than 6 ms moves nothing.",
    ),
    Fault(
        "gripper_reboot",
        Device.GRIPPER,
        "reboot",
        "The gripper loses power for a moment: the latch stays where it is, unconfirmed.",
        once=True,
        remedy="Unlatch and latch again.",
    ),
)
_CELL = (
    Parameter("x", int, "the cell of the part along x", required=True),
    Parameter("y", int, "along y", required=True),
    Parameter("z", int, "its layer; 0 on the floor", required=True),
)

_WORLD = (
    Fault(
        "belt_empty",
        Device.WORLD,
        "empty",
        "Somebody takes every part off the belt.",
        once=True,
        remedy="Refill the belt.",
    ),
    Fault(
        "part_yawed",
        Device.WORLD,
        "yaw",
        "The first part on the belt lies turned.",
        (Parameter("yaw_rad", float, "how far it is turned, in radians", 0.26),),
    ),
    Fault(
        "part_sticky",
        Device.WORLD,
        "stick",
        "The first part on the belt sticks to the one behind it.",
    ),
    Fault(
        "part_missing",
        Device.WORLD,
        "remove",
        "The first part is taken off the belt; its place stays empty.",
        once=True,
        remedy="Nothing: the next part comes one pitch later.",
    ),
    Fault(
        "part_dropped",
        Device.WORLD,
        "drop",
        "The part in the gripper slips out and falls.",
        once=True,
        remedy="Clear the workspace.",
    ),
    Fault(
        "part_put",
        Device.WORLD,
        "put",
        "Somebody puts a part from the stock at a cell, and tells nobody.",
        _CELL,
        once=True,
        remedy="Take it out again: inject part_taken.",
    ),
    Fault(
        "part_raised",
        Device.WORLD,
        "raise",
        "A placed part stands higher than its cell, as over a crumb; the arm feels it.",
        (*_CELL, Parameter("height_m", float, "how much higher, in metres", 0.0015)),
    ),
    Fault(
        "part_taken",
        Device.WORLD,
        "take_placed",
        "A visitor takes a part off the structure along.",
        _CELL,
        once=True,
        remedy="Tell the cell that it is missing.",
    ),
    Fault(
        "part_sticks",
        Device.WORLD,
        "stick_to_gripper",
        "Parts that are let go at a cell stick to the gripper, whose latch is open.",
    ),
)

_ALL = (*_ROBOT, *_CONVEYOR, *_CONVEYOR_BOARD, *_GRIPPER, *_GRIPPER_BOARD, *_WORLD)

FAULTS: dict[str, Fault] = {fault.name: fault for fault in _ALL}
