"""What can go wrong with an emulated board and its cable: each fault a name, and a value.

A fault is active from ``inject`` to ``clear``; those with a count end by themselves.
"""

from __future__ import annotations

from typing import Annotated, Any, Final, TypeVar

from pydantic import Field, ValidationError

from cellctl.assembly import Value
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


class Noise(Value):
    """Lines in both directions are lost, doubled, delayed, garbled or cut short."""

    share: Annotated[float, Field(gt=0.0, le=1.0)] = 0.2
    """Of all lines, that something happens to; each of the five as often as the others."""
    delay_s: Annotated[float, Field(gt=0.0, le=1.0)] = 0.1
    """Longest delay (cell time); lines may overtake each other by it."""


class WrongRole(Value):
    """Another board is on the port."""

    role: Annotated[str, Field(pattern="^[a-z]{1,12}$")] = "gripper"


class WrongProtocol(Value):
    """The firmware speaks another version of the protocol."""

    version: Annotated[int, Field(ge=0, le=255)] = 1


class OldFirmware(Value):
    """The firmware is of another version."""

    version: Annotated[str, Field(pattern=r"^[0-9.]{1,12}$")] = "0.9.0"


class Hang(Value):
    """The program is caught in an endless loop, once, until its watchdog resets it."""

    interrupts: bool = True
    """Whether interrupts go on meanwhile."""


class Unplugged(Value):
    """The port vanishes; it comes back when the fault is cleared, and the board has been reset."""


BOARD_FAULTS: Final[dict[str, type[Value]]] = {
    "silent": Silent,
    "lost_replies": LostReplies,
    "corrupted_replies": CorruptedReplies,
    "garbage": Garbage,
    "noise": Noise,
    "wrong_role": WrongRole,
    "wrong_protocol": WrongProtocol,
    "old_firmware": OldFirmware,
    "unplugged": Unplugged,
    "hang": Hang,
}
"""What every board can suffer."""

F = TypeVar("F", bound=Value)


class ActiveFaults:
    """The faults of one board that are injected now.

    Args:
        board: what to call it.
        kinds: the faults it can have, by name.
    """

    def __init__(self, board: str, kinds: dict[str, type[Value]]) -> None:
        self._board = board
        self._kinds = kinds
        self._active: dict[type[Value], Value] = {}

    def inject(self, name: str, arguments: dict[str, Any]) -> Value:
        """Switch a fault on.

        Raises:
            UsageError: there is no such fault, or not with these arguments.
        """
        try:
            fault = self._kind(name).model_validate(arguments)
        except ValidationError as error:
            details = "; ".join(
                f"{'.'.join(map(str, item['loc']))}: {item['msg']}" for item in error.errors()
            )
            raise UsageError(f"{self._board.capitalize()} fault {name}: {details}.") from error
        self._active[type(fault)] = fault
        return fault

    def clear(self, name: str) -> type[Value]:
        """Switch a fault off; one that is not on stays so.

        Raises:
            UsageError: there is no such fault.
        """
        kind = self._kind(name)
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
        return tuple(name for name, kind in self._kinds.items() if kind in self._active)

    def _kind(self, name: str) -> type[Value]:
        try:
            return self._kinds[name]
        except KeyError:
            raise UsageError(
                f"The {self._board} has no fault {name!r}.", f"It has: {', '.join(self._kinds)}."
            ) from None
