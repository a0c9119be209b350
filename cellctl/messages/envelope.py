"""What wraps status, requests and replies: versions, numbers, ids, and the whole picture."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Final, Literal, Self

from pydantic import Field

from cellctl.assembly import BuildPlan, Cell, Pace, PartOutcome, Value
from cellctl.errors import CellctlError, RefusedError
from cellctl.messages.commands import Command
from cellctl.messages.dialogue import DialogueData
from cellctl.messages.replies import ReplyData
from cellctl.messages.status import (
    TOPICS,
    ArmData,
    ConveyorData,
    EarsData,
    FaultData,
    GripperData,
    HealthData,
    JobData,
    StateData,
    StatusData,
    VoiceData,
)

SCHEMA_VERSION: Final = 2


class StatusMessage(Value):
    """Envelope of every status message."""

    schema_version: Literal[2] = SCHEMA_VERSION
    seq: int
    """Counts all messages of one daemon from 1; a gap means that messages were lost."""
    time: datetime
    cell_time_s: float
    state: str
    topic: str
    data: dict[str, Any]

    def payload(self) -> StatusData:
        """The data as the model of its topic."""
        return TOPICS[self.topic].model_validate(self.data)  # type: ignore[return-value]


class Snapshot(Value):
    """The whole picture for one who joins late; ``seq`` is the last message it includes."""

    schema_version: Literal[2] = SCHEMA_VERSION
    seq: int
    version: str
    cell: str
    kind: Literal["real", "emulated"]
    grid: tuple[int, int, int]
    state: StateData
    job: JobData | None
    plan: BuildPlan | None
    parts: tuple[PartOutcome, ...]
    standing: tuple[Cell, ...]
    """Cells that hold a part in the workspace, as far as the cell knows."""
    inventory: dict[str, int]
    """How many parts are in each place."""
    doubt: str = ""
    """What nobody can know about the part that was on its way; empty when nothing is in doubt."""
    arm: ArmData
    conveyor: ConveyorData
    gripper: GripperData
    fault: FaultData
    health: HealthData
    recogniser: str
    carrying: Pace | None = None
    """The most that movements with a part have."""
    carrying_measured: str = ""
    """What that rests on; empty where nobody has measured it."""
    ears: EarsData = EarsData(state="off")
    voice: VoiceData = VoiceData(state="off")
    dialogue: DialogueData = DialogueData(phase="starting")


class ControlRequest(Value):
    """A request; the role of the one who asks follows from the door it comes in by."""

    schema_version: Literal[2] = SCHEMA_VERSION
    id: Annotated[str, Field(min_length=1, max_length=64)]
    """Chosen by the one who asks; the reply carries it."""
    visitor: Annotated[str, Field(max_length=64)] = ""
    """A visitor's secret, such as a browser draws for itself: who shows it again is the owner of
    the same jobs and wishes. Empty for the one in front of the cell, by voice or at its screen."""
    body: Command


class ReplyError(Value):
    """Why a request was not carried out; ``busy``: too many wait, the same may be asked again."""

    code: Literal["invalid", "refused", "busy", "usage", "internal"]
    message: str
    hint: str = ""

    @classmethod
    def of(cls, error: CellctlError) -> Self:
        """What those who asked are told of an error that is theirs."""
        refused = isinstance(error, RefusedError)
        return cls(code="refused" if refused else "usage", message=error.message, hint=error.hint)


class ControlReply(Value):
    """The answer to one request."""

    schema_version: Literal[2] = SCHEMA_VERSION
    id: str
    ok: bool
    state: str
    """The machine's state after the request."""
    message: str = ""
    """For people: what happens now."""
    job_id: str = ""
    snapshot: Snapshot | None = None
    data: ReplyData | None = None
    """What was asked for, by a command that asks."""
    error: ReplyError | None = None
