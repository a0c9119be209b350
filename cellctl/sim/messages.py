"""What is asked of the emulated cell on its control socket, and what it answers.

One JSON object a message, over a ZeroMQ REQ socket; each request gets one reply. All durations and
times are cell time.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter

from cellctl.assembly import Cell, Value
from cellctl.sim.world_values import Imperfections, PartTruth, Violation, Where

Argument = str | int | float | bool


class Ping(Value):
    """Are you there? Answered with ``Pong``."""

    do: Literal["ping"] = "ping"


class AskTruth(Value):
    """What is the case? Answered with ``CellTruth``."""

    do: Literal["truth"] = "truth"


class Inject(Value):
    """Make a fault of the table happen."""

    do: Literal["inject"] = "inject"
    fault: str
    arguments: dict[str, Argument] = Field(default_factory=dict)


class Clear(Value):
    """Mend what a fault broke."""

    do: Literal["clear"] = "clear"
    fault: str
    arguments: dict[str, Argument] = Field(default_factory=dict)


class Refill(Value):
    """Lay parts on the belt. Answered with ``Moved``."""

    do: Literal["refill"] = "refill"
    parts: Annotated[int, Field(ge=1)] | None = None
    """None fills the belt."""


class HandOver(Value):
    """Give the visitor what stands in the workspace. Answered with ``Moved``."""

    do: Literal["hand_over"] = "hand_over"


class ClearWorkspace(Value):
    """Take what stands or lies in the workspace to the stock. Answered with ``Moved``."""

    do: Literal["clear_workspace"] = "clear_workspace"


class SetImperfections(Value):
    """Belt slip holds at once, the rest for parts that are laid on the belt from now on."""

    do: Literal["set_imperfections"] = "set_imperfections"
    imperfections: Imperfections
    relay: bool = False
    """Take all parts off the belt and lay them anew, so that all of it holds at once."""


class Shutdown(Value):
    """End the emulated cell."""

    do: Literal["shutdown"] = "shutdown"


Request = Annotated[
    Ping
    | AskTruth
    | Inject
    | Clear
    | Refill
    | HandOver
    | ClearWorkspace
    | SetImperfections
    | Shutdown,
    Field(discriminator="do"),
]
REQUEST: TypeAdapter[Request] = TypeAdapter(Request)


class Pong(Value):
    """The emulated cell is ready."""

    pid: int
    cell: str
    """The cell's name in the configuration."""
    speed: float


class Moved(Value):
    """How many parts were moved."""

    parts: int


class CellTruth(Value):
    """All that is the case in the emulated cell."""

    cell_time_s: float
    lost_s: float
    """Cell time left out, because the emulation was stalled or too slow."""
    seed: int
    parts: tuple[PartTruth, ...]
    counts: dict[Where, int]
    built: tuple[Cell, ...]
    """The cells that hold a part, by z, then x, then y."""
    violations: tuple[Violation, ...]
    imperfections: Imperfections
    faults: tuple[str, ...]
    """Faults that were injected and not cleared."""
    robot: dict[str, Any]
    conveyor: dict[str, Any]
    latch: dict[str, Any]
    gripper_board: dict[str, Any]
    """Empty where the board has no serial port."""


class Reply(Value):
    """What every request gets back."""

    ok: bool
    result: dict[str, Any] = Field(default_factory=dict)
    error: str = ""
    hint: str = ""
