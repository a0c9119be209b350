"""What can go wrong with the emulated conveyor, beyond what every board can suffer."""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import Field

from cellctl.assembly import Value
from cellctl.boards.constants import ResetCause
from cellctl.sim.board_faults import BOARD_FAULTS


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


FAULTS: Final[dict[str, type[Value]]] = {
    **BOARD_FAULTS,
    "jam": Jam,
    "stall": Stall,
    "sensor_blocked": SensorBlocked,
    "reset": Reset,
}
