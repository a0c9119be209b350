"""What the daemon and its arm process tell each other: one JSON object a line, both ways.

The daemon sends orders with a number; the arm process answers each with ``Done`` or ``Failed`` of
the same number, and sends ``Report`` on its own. A ``Heartbeat`` is an order without an answer.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from cellctl.assembling.arm import ArmCheck, ArmIdentity, ArmState, Path, Switch
from cellctl.assembly import Value
from cellctl.config import Joints, Pose, RobotSection, Vector

LINE_LIMIT_BYTES = 1 << 20
"""Longest line that either side accepts."""
STOPPED_CODE = "stopped"
"""``Failed.code`` of a movement that an order to stop has ended; no fault."""


class Heartbeat(Value):
    """The daemon's event loop is alive."""

    kind: Literal["heartbeat"] = "heartbeat"


class Connect(Value):
    """Open the robot; always the first order, and only once in the life of an arm process."""

    kind: Literal["connect"] = "connect"
    number: int
    robot: RobotSection
    tcp: Pose
    payload_kg: float
    payload_cog_m: Vector
    speed_fraction: float
    """Where the speed slider goes if it is found at 0, as a killed arm process leaves it."""
    recover: bool = False
    """First leave a stop of the robot's own."""
    inspect: bool = False
    """Only end what program runs, and say why the arm stands still."""


class Follow(Value):
    """Move the TCP along a path, and switch an output just before its end."""

    kind: Literal["follow"] = "follow"
    number: int
    path: Path
    planned_duration_s: float
    switch: Switch | None = None


class Prepare(Value):
    """Have a path ready; the arm stays at rest."""

    kind: Literal["prepare"] = "prepare"
    number: int
    path: Path


class MoveJoints(Value):
    """Move in joint space."""

    kind: Literal["move_joints"] = "move_joints"
    number: int
    target_rad: Joints
    speed_rad_s: float


class Stop(Value):
    """Brake now; whatever moves fails with the code ``stopped``."""

    kind: Literal["stop"] = "stop"
    number: int


class SetOutput(Value):
    """Switch one standard digital output."""

    kind: Literal["set_output"] = "set_output"
    number: int
    line: int
    high: bool


class WaitInput(Value):
    """Wait for a level on one standard digital input."""

    kind: Literal["wait_input"] = "wait_input"
    number: int
    line: int
    high: bool
    timeout_s: float
    """In the robot's own time."""


class Verify(Value):
    """Read back what the robot has set; refused while it moves."""

    kind: Literal["verify"] = "verify"
    number: int


class Close(Value):
    """Stop, let go of the robot, and end."""

    kind: Literal["close"] = "close"
    number: int


Order = Annotated[
    Heartbeat
    | Connect
    | Prepare
    | Follow
    | MoveJoints
    | Stop
    | SetOutput
    | WaitInput
    | Verify
    | Close,
    Field(discriminator="kind"),
]


class Done(Value):
    """An order is carried out."""

    kind: Literal["done"] = "done"
    number: int
    identity: ArmIdentity | None = None
    """For ``Connect``."""
    level_seen: bool = True
    """For ``WaitInput``: False on time-out."""
    check: ArmCheck | None = None
    """For ``Verify``."""


class Failed(Value):
    """An order could not be carried out."""

    kind: Literal["failed"] = "failed"
    number: int
    code: str
    """A code of the fault catalogue, or ``stopped`` for a movement that ``Stop`` ended."""
    detail: str = ""


class Report(Value):
    """The newest state."""

    kind: Literal["report"] = "report"
    state: ArmState
    speed_fraction: float
    """The speed slider while no movement is being started."""


Answer = Annotated[Done | Failed | Report, Field(discriminator="kind")]

ORDERS: TypeAdapter[Order] = TypeAdapter(Order)
ANSWERS: TypeAdapter[Answer] = TypeAdapter(Answer)


def encode(message: Value) -> bytes:
    """One line."""
    return message.model_dump_json().encode() + b"\n"
