"""What a journal keeps: physical acts, what people did, and jobs."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from enum import StrEnum
from typing import Literal

from cellctl.assembly import (
    BuildPlan,
    Cell,
    Pace,
    PartOutcome,
    Request,
    Role,
    Utterance,
    Value,
)
from cellctl.feeding.inventory import Counts, Move
from cellctl.mesh import GeneratedMesh
from cellctl.messages import Outcome as JobOutcome

Outcome = Literal["done", "failed", "interrupted"]


class ActKind(StrEnum):
    """The acts that a journal knows."""

    # The cell's own.
    FEED = "feed"
    """The belt brings a part to the pick station."""
    PICK = "pick"
    """The arm goes to the station and the latch closes on the part."""
    PLACE = "place"
    """The arm brings the part to its cell."""
    RELEASE = "release"
    """The latch lets the part go."""
    GRIP = "grip"
    """The arm goes to a part that stands and the latch closes on it."""
    TAKE_OFF = "take_off"
    """The arm parts it from its neighbours and lifts it clear."""
    LET_STAND = "let_stand"
    """The latch opens on a part that it gripped, which stays where it stands."""
    RETURN = "return"
    """The arm brings a part back to the pick station, where the belt makes room."""
    PUT_BACK = "put_back"
    """The latch lets the part go at the pick station."""
    RETREAT = "retreat"
    HAND = "hand"
    """A movement that an operator ordered."""
    HAND_OPEN = "hand_open"
    """The latch opened by an operator's order."""
    # What people did, or say of the cell.
    REFILL = "refill"
    CLEAR = "clear"
    HAND_OVER = "hand_over"
    MISSING = "missing"
    """A part of the structure is no longer at its cell."""
    SETTLE = "settle"
    """An operator says where the part is that was in doubt."""
    COUNT = "count"
    """An operator has counted parts."""
    CALIBRATED = "calibrated"
    """Something of the cell was measured; the detail says what came of it."""
    OWN = "own"
    """Parts were bought or sold: the one act that changes their number."""


class Act(Value):
    """One act."""

    act_id: int
    """Grows from act to act and is never used twice."""
    kind: ActKind
    job_id: str = ""
    step: int | None = None
    """Index in the job's plan."""
    cell: Cell | None = None
    intended_at: datetime
    settled_at: datetime | None = None
    outcome: Outcome | None = None
    """None while the act is under way, or was cut off."""
    detail: str = ""
    """For people: why it failed, or what an operator said."""
    moves: tuple[Move, ...] = ()
    """What became of parts, in order."""
    counts: Counts | None = None
    """What the counts are now; only for ``count`` and ``own``."""
    belt_indexes: int | None = None
    """The board's counter of parts that it brought, for a ``pick``: a part at the station that
    comes with the same count was never lifted."""


class JobRecord(Value):
    """One wish as the journal keeps it: enough to go on with it, and to build it again."""

    job_id: str
    role: Role
    began_at: datetime
    finished_at: datetime | None = None
    phase: str
    outcome: JobOutcome = ""
    message: str = ""
    utterance: Utterance | None = None
    request: Request | None = None
    plan: BuildPlan | None = None
    parts: tuple[PartOutcome, ...] = ()
    upload_name: str = ""
    """Name of the mesh or plan file that it began with."""
    pace: Pace | None = None
    """What the movements with a part are told, where it is a trial of that."""
    cancelling: bool = False
    owner: str = ""
    """Mark of the visitor whose it is; empty for the one in front of the cell."""
    owner_name: str = ""
    """What that visitor wants to be called."""


@dataclass(frozen=True)
class JobFiles:
    """The large parts of a job's record, stored apart with their SHA-256."""

    mesh: GeneratedMesh | None = None
    upload: bytes | None = None
    """Content of the file that it began with."""
