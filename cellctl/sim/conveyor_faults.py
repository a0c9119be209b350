"""What can go wrong with the emulated conveyor: each fault a name, and a value with its arguments.

A fault is active from ``inject`` to ``clear``; those with a count end by themselves.
"""

from __future__ import annotations

from typing import Annotated, Any, TypeVar

from pydantic import Field, ValidationError

from cellctl.assembly import Value
from cellctl.boards.constants import ResetCause
from cellctl.errors import UsageError


class Silent(Value):
    """The board is dead: it neither hears nor answers."""


class LostReplies(Value):
    """The next replies never arrive, though the board acts."""

    count: Annotated[int, Field(ge=1)] = 1


class CorruptedReplies(Value):
    """One bit of each of the next replies is flipped."""

    count: Annotated[int, Field(ge=1)] = 1


class Garbage(Value):
    """Random bytes precede every reply."""

    count: Annotated[int, Field(ge=1, le=1000)] = 20


class Jam(Value):
    """The motor runs, the parts stay."""


class Stall(Value):
    """The motor does not turn, and its driver says so."""


class SensorBlocked(Value):
    """The part sensor reads the same whatever is there."""

    reads: bool = True
    """True: it always sees a part; false: it never does."""


class Reset(Value):
    """The board starts anew, once."""

    cause: ResetCause = ResetCause.BROWNOUT
    after_m: Annotated[float, Field(ge=0.0)] | None = None
    """When a motion has gone this far; None resets at once."""


class WrongRole(Value):
    """Another board is on the port."""

    role: Annotated[str, Field(pattern="^[a-z]{1,12}$")] = "gripper"


class WrongProtocol(Value):
    """The firmware speaks another version of the protocol."""

    version: Annotated[int, Field(ge=0, le=255)] = 1


class Unplugged(Value):
    """The port vanishes; it comes back when the fault is cleared, and the board has been reset."""


FAULTS: dict[str, type[Value]] = {
    "silent": Silent,
    "lost_replies": LostReplies,
    "corrupted_replies": CorruptedReplies,
    "garbage": Garbage,
    "jam": Jam,
    "stall": Stall,
    "sensor_blocked": SensorBlocked,
    "reset": Reset,
    "wrong_role": WrongRole,
    "wrong_protocol": WrongProtocol,
    "unplugged": Unplugged,
}

F = TypeVar("F", bound=Value)


class ActiveFaults:
    """The faults that are injected now."""

    def __init__(self) -> None:
        self._active: dict[type[Value], Value] = {}

    def inject(self, name: str, arguments: dict[str, Any]) -> Value:
        """Switch a fault on.

        Raises:
            UsageError: there is no such fault, or not with these arguments.
        """
        try:
            fault = _kind(name).model_validate(arguments)
        except ValidationError as error:
            details = "; ".join(
                f"{'.'.join(map(str, item['loc']))}: {item['msg']}" for item in error.errors()
            )
            raise UsageError(f"Conveyor fault {name}: {details}.") from error
        self._active[type(fault)] = fault
        return fault

    def clear(self, name: str) -> type[Value]:
        """Switch a fault off; one that is not on stays so.

        Raises:
            UsageError: there is no such fault.
        """
        kind = _kind(name)
        self._active.pop(kind, None)
        return kind

    def get(self, kind: type[F]) -> F | None:
        """The fault of this kind, if it is active."""
        fault = self._active.get(kind)
        assert fault is None or isinstance(fault, kind)
        return fault

    def end(self, kind: type[Value]) -> None:
        """A fault has happened and is over."""
        del self._active[kind]

    def use_up(self, kind: type[LostReplies] | type[CorruptedReplies]) -> bool:
        """Whether a counted fault strikes now; counts it down."""
        fault = self.get(kind)
        if fault is None:
            return False
        if fault.count > 1:
            self._active[kind] = fault.model_copy(update={"count": fault.count - 1})
        else:
            self.end(kind)
        return True

    def names(self) -> tuple[str, ...]:
        """The names of the active faults."""
        return tuple(name for name, kind in FAULTS.items() if kind in self._active)


def _kind(name: str) -> type[Value]:
    try:
        return FAULTS[name]
    except KeyError:
        raise UsageError(
            f"The conveyor has no fault {name!r}.", f"It has: {', '.join(FAULTS)}."
        ) from None
