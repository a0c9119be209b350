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
    CONVEYOR = "conveyor"
    WORLD = "world"


class Parameter(NamedTuple):
    """One argument of a fault."""

    name: str
    meaning: str
    """With its unit."""
    default: Argument
    """Its type is the argument's type; an int is taken where a float is asked for."""


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

    def check(self, arguments: Mapping[str, Argument]) -> None:
        """Whether the arguments are among the parameters, and of their types.

        Raises:
            UsageError: naming the argument and what is known.
        """
        known = {parameter.name: parameter for parameter in self.parameters}
        for name, value in arguments.items():
            if name not in known:
                names = ", ".join(known) or "none"
                raise UsageError(
                    f"{self.name} has no argument {name!r}.", f"Its arguments: {names}."
                )
            expected = type(known[name].default)
            fits = type(value) is expected or (expected is float and type(value) is int)
            if not fits:
                raise UsageError(
                    f"{self.name}: {name} = {value!r} is no {expected.__name__}.",
                    f"{known[name].meaning}.",
                )

    def complete(self, arguments: Mapping[str, Argument]) -> dict[str, Any]:
        """The arguments, with defaults for those that are not given."""
        return {
            parameter.name: arguments.get(parameter.name, parameter.default)
            for parameter in self.parameters
        }


_ROBOT: tuple[Fault, ...] = ()
_CONVEYOR: tuple[Fault, ...] = ()
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
        "gripper_reboot",
        Device.GRIPPER,
        "reboot",
        "The gripper loses power for a moment: the latch stays where it is, unconfirmed.",
        once=True,
        remedy="Unlatch and latch again.",
    ),
)
_WORLD = (
    Fault("belt_jam", Device.WORLD, "jam", "The belt's motor turns, and its parts stay."),
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
        (Parameter("yaw_rad", "how far it is turned, in radians", 0.26),),
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
)

FAULTS: dict[str, Fault] = {
    fault.name: fault for fault in (*_ROBOT, *_CONVEYOR, *_GRIPPER, *_WORLD)
}
