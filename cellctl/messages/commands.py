"""What may be asked of the daemon: one model a command."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cellctl.assembly import Cell, Pace, Role, Value
from cellctl.config import Vector

PartPlace = Literal["gripper", "cell", "station", "stock", "scrap", "unknown"]
"""Where a part can be that was on its way: in the gripper, at the cell of its step, at the pick
station, taken to the stock, written off, or nobody knows."""
HandMove = Literal[
    "home",
    "jog",
    "rise",
    "retreat",
    "open",
    "close",
    "index",
    "check_lines",
    "above_station",
    "above_cell",
]
"""What an operator's hand can do: arm movements, the latch, and bringing one part in."""
FileKind = Literal["mesh", "plan", "steps", "upload"]
"""``mesh``: the shape as it was designed (GLB); ``plan``: what is built, step by step (JSON);
``steps``: the same to look at, a part a node, with an animation (GLB); ``upload``: the mesh or plan
file that the job began with."""

MAX_TEXT = 500
"""Longest sentence that ``say`` takes, in characters."""
MAX_ATTACHMENT = 64 * 1024 * 1024
"""Largest file that an operator's request, or a reply, may carry, in bytes."""
MAX_REQUEST = 64 * 1024
"""Largest first frame of a request, in bytes."""


class SnapshotCommand(Value):
    """Ask for the whole picture."""

    command: Literal["snapshot"] = "snapshot"


class SayCommand(Value):
    """Typed words, as if they had been spoken."""

    command: Literal["say"] = "say"
    text: Annotated[str, Field(min_length=1, max_length=MAX_TEXT)]
    asked: Annotated[str, Field(max_length=64)] | None = None
    """Name of the question that was open where it was typed, as ``dialogue`` tells it, for words
    that say yes; None: of whichever is open when they arrive."""


class HearCommand(Value):
    """Listen to the wav file in the request's second frame."""

    command: Literal["hear"] = "hear"
    name: Annotated[str, Field(max_length=200)]


class BuildCommand(Value):
    """Build the mesh or the plan in the request's second frame; the name's suffix tells which."""

    command: Literal["build"] = "build"
    name: Annotated[str, Field(max_length=200)]
    pace: Pace | None = None
    """For a trial of it: what every movement with a part is told, on the paper's square path; each
    part on a column must then be felt to stand."""


class ConfirmCommand(Value):
    """Answer "Shall I build it?"."""

    command: Literal["confirm"] = "confirm"
    answer: bool
    asked: Annotated[str, Field(max_length=64)]
    """Name of the question that is answered, as ``dialogue`` tells it: a yes that was meant for
    another one is refused. A no counts for any."""


class PlainCommand(Value):
    """A command without arguments."""

    command: Literal[
        "pause", "resume", "stop", "cancel", "reset", "clear", "hand_over", "take_apart", "another"
    ]
    """``another``: instead of yes or no, show another shape for the same wish."""


class DropWishCommand(Value):
    """Forget one wish that waits for its turn."""

    command: Literal["drop_wish"] = "drop_wish"
    ticket: int
    """Its number in the line."""


class RefillCommand(Value):
    """Tell that parts from the stock were laid on the belt."""

    command: Literal["refill"] = "refill"
    parts: Annotated[int, Field(ge=1, le=1000)] | None = None
    """How many; as many as the belt takes when left out."""


class RecoverCommand(Value):
    """Tell where the part is that is in the gripper, or that a crash left in doubt."""

    command: Literal["recover"] = "recover"
    part: PartPlace


class MissingCommand(Value):
    """Tell that the structure has lost the parts at these cells."""

    command: Literal["missing"] = "missing"
    cells: Annotated[tuple[Cell, ...], Field(min_length=1, max_length=1000)]


class CountCommand(Value):
    """Tell how many parts were counted in some places; what is missing then is unknown."""

    command: Literal["count"] = "count"
    stock: Annotated[int, Field(ge=0)] | None = None
    belt: Annotated[int, Field(ge=0)] | None = None
    handed_over: Annotated[int, Field(ge=0)] | None = None
    scrap: Annotated[int, Field(ge=0)] | None = None
    note: Annotated[str, Field(max_length=200)] = ""


class CalibratedCommand(Value):
    """Write down that something of the cell was measured, and with what result."""

    command: Literal["calibrated"] = "calibrated"
    what: Literal["frames", "speed"]
    note: Annotated[str, Field(min_length=1, max_length=1000)]


class OwnCommand(Value):
    """Tell how many parts the cell owns, after some were bought or sold."""

    command: Literal["own"] = "own"
    parts: Annotated[int, Field(ge=1, le=1000)]
    note: Annotated[str, Field(max_length=200)] = ""


class HandCommand(Value):
    """Move something by hand; answered when the movement has ended."""

    command: Literal["hand"] = "hand"
    move: HandMove
    delta_m: Vector = (0.0, 0.0, 0.0)
    """For ``jog``: how far, along the cell frame's axes."""
    turn_rad: float = 0.0
    """For ``jog``: about the vertical."""
    cell: Cell | None = None
    """For ``above_cell``."""
    speed_fraction: Annotated[float, Field(gt=0.0, le=1.0)] = 1.0
    """Share of the speed that a build would have; ``jog`` is slow anyway."""
    part_held: bool = False
    """For ``open`` with a part in the gripper: a person holds the part and takes it away."""


class GripperCommand(Value):
    """Ask the gripper's board, or change its calibration; nothing moves."""

    command: Literal["gripper"] = "gripper"
    do: Literal["show", "test", "set", "keep", "clear"]
    latch_pulse_us: int | None = None
    """For ``set``: the servo's pulse for a closed latch."""
    unlatch_pulse_us: int | None = None
    """For ``set``: the servo's pulse for an open latch."""
    travel_ms: int | None = None
    """For ``set``: how long the servo is given to turn."""


class ListenCommand(Value):
    """Press the button: what is said into the microphone next is a request."""

    command: Literal["listen"] = "listen"


class FileCommand(Value):
    """Ask for a file of a job; it comes as the reply's second frame."""

    command: Literal["file"] = "file"
    kind: FileKind
    job_id: Annotated[str, Field(max_length=64)] = ""
    """Whose; empty: of the job under way, or of the last one. Any other needs the operator."""


class HistoryCommand(Value):
    """Ask for the jobs of the journal, newest first, some at a time."""

    command: Literal["history"] = "history"
    limit: Annotated[int, Field(ge=1, le=50)] = 20
    before: int | None = None
    """Go on where the answer before ended: its ``next_before``."""


class JobCommand(Value):
    """Ask for all that the journal has of one job, to see it being built again."""

    command: Literal["job"] = "job"
    job_id: Annotated[str, Field(min_length=1, max_length=64)]


class AskCommand(Value):
    """Ask about the cell. ``about``: devices, software and their versions; ``limits``: what is
    configured, and what is in force; ``log``: the newest warnings and errors; ``audit``: who gave
    which commands since the daemon started."""

    command: Literal["about", "limits", "log", "audit"]


class MuteCommand(Value):
    """Close the microphone, or open it again."""

    command: Literal["mute", "unmute"]


Inquiry = FileCommand | HistoryCommand | JobCommand | AskCommand
"""Commands that ask, and change nothing; the reply has ``data``."""
Order = (
    SnapshotCommand
    | SayCommand
    | HearCommand
    | BuildCommand
    | ConfirmCommand
    | PlainCommand
    | ListenCommand
    | MuteCommand
    | DropWishCommand
    | RefillCommand
    | RecoverCommand
    | MissingCommand
    | CountCommand
    | OwnCommand
    | CalibratedCommand
    | HandCommand
    | GripperCommand
)
Command = Annotated[Order | Inquiry, Field(discriminator="command")]


OPERATOR_COMMANDS = frozenset(
    {"build", "resume", "reset", "clear", "refill", "recover", "missing", "count", "own", "hand"}
    | {"unmute", "calibrated", "gripper", "history", "job", "about", "audit", "drop_wish"}
)
"""Commands that a visitor may not give."""


def attachment_limit(role: Role, max_audio_s: float) -> int:
    """Largest file that a request of that role may carry, in bytes.

    A visitor sends recordings only: the longest that is listened to, in the largest form that
    sound cards deliver (48 kHz, stereo, 32 bit), and the file's header.
    """
    recording = int(max_audio_s * 48_000 * 2 * 4) + MAX_REQUEST
    return MAX_ATTACHMENT if role is Role.OPERATOR else min(recording, MAX_ATTACHMENT)
