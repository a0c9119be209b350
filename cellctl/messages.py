"""What goes over the bus: status messages, requests and replies, with their schema version.

Every status message is a multipart of two frames, the topic and a JSON document; every request is
one JSON frame, with the bytes of a file as a second frame where the command takes one. The JSON
schemas in the docs are generated from these models, and both ends validate with them.
"""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from cellctl.assembly import (
    BuildPlan,
    Cell,
    Change,
    Check,
    PartOutcome,
    Request,
    Role,
    Utterance,
    Value,
)
from cellctl.config import Vector
from cellctl.errors import FaultEntry, Notice

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

SCHEMA_VERSION: Final = 2

MAX_TEXT = 500
"""Longest sentence that ``say`` takes, in characters."""
MAX_ATTACHMENT = 64 * 1024 * 1024
"""Largest file that an operator's request may carry, in bytes."""
MAX_REQUEST = 64 * 1024
"""Largest first frame of a request, in bytes."""


class StateData(Value):
    """Topic ``state``: where the machine is."""

    state: str
    """Leaf of the machine, as ``top`` or ``top_sub``."""
    previous: str
    event: str
    pausing: bool = False
    """A pause was asked for and happens at the next safe point."""
    cancelling: bool = False
    """A cancel was asked for; the part on its way is placed first."""
    sentence: str = ""
    """The state in words for the people in the room."""


Outcome = (
    Literal["", "built", "taken_apart", "cancelled", "declined"]
    | Literal["unreadable", "no_object", "cannot_plan", "failed"]
)
"""How a job ended; empty while it is under way. ``unreadable``: the recording or file cannot be
used, or there is nothing to recognise speech with; ``failed``: a worker did not do its work."""


class JobData(Value):
    """Topic ``job``: one wish, from the sentence to the last part."""

    job_id: str
    role: Role
    utterance: Utterance | None = None
    request: Request | None = None
    title: str = ""
    phase: str = ""
    """Where ``resume`` goes on."""
    message: str = ""
    """What the visitor is told."""
    outcome: Outcome = ""
    plan_id: str = ""
    provenance: str = ""
    parts_total: int = 0
    parts_placed: int = 0
    """Steps that are done; ``parts_total`` counts parts to place and to take off."""
    predicted_s: float | None = None
    checks: tuple[Check, ...] = ()
    changes: tuple[Change, ...] = ()
    questions: tuple[str, ...] = ()
    end_of_speech_s: float | None = None
    """Cell time at which the sentence was complete."""
    first_motion_s: float | None = None
    finished_s: float | None = None


class PartData(Value):
    """Topic ``part``: a part was placed or taken off; the counts are of the plan's steps."""

    job_id: str
    outcome: PartOutcome
    placed: int
    total: int


class ArmData(Value):
    """Topic ``arm``: what the robot says."""

    connected: bool
    robot_time_s: float = 0.0
    joints_rad: tuple[float, ...] = ()
    tcp_pose: tuple[float, ...] = ()
    tcp_speed_m_s: float = 0.0
    moving: bool = False
    safety: str = "unknown"


class BoardData(Value):
    """One of the cell's own boards, as it told when it was connected."""

    port: str
    serial_number: str
    protocol_version: int
    firmware_version: str


class ConveyorData(Value):
    """Topic ``conveyor``: what the belt does."""

    connected: bool
    part_present: bool = False
    activity: str = ""
    board: BoardData | None = None
    """The newest that answered."""


class GripperData(Value):
    """Topic ``gripper``: what the latch holds, as far as the cell knows, and its board."""

    holding: Literal["nothing", "part", "latching", "releasing", "gripped"]
    """``gripped``: it has closed on a part that still stands."""
    board: BoardData | None = None
    """None while its serial port is not connected, which it need not be."""
    resets: int = 0
    """How often it was reset since the daemon began."""
    registers: dict[str, int] = Field(default_factory=dict)
    """What it told of itself when last asked, by name; units stand in the serial protocol."""
    notice: Notice | None = None
    """What is wrong with its board, while it is."""


class SpeechData(Value):
    """Topic ``speech``: what was heard and what was made of it."""

    utterance: Utterance
    request: Request | None = None


EarsCondition = Literal[
    "off", "starting", "listening", "waiting", "recording", "muted", "silent", "slow", "lost"
]
"""``off``: no microphone is configured; ``listening``: every sentence counts; ``waiting``: for the
wake word or the button; ``recording``: what is said now is a request; ``silent``: the microphone
delivers nothing but zeros; ``slow``: sound was lost, for the computer is too busy; ``lost``: there
is no microphone, or it has fallen silent, and it is looked for again."""


class EarsData(Value):
    """Topic ``ears``: whether and how the cell listens."""

    state: EarsCondition
    device: str = ""
    """The microphone's name; empty while there is none."""
    activation: Literal["wake_word", "push_to_talk", "open"] = "wake_word"
    """What makes a sentence a request."""
    sentence: str = ""
    """The state in words for the people in the room."""
    notice: Notice | None = None
    """What is wrong with them, while it is."""


class FaultData(Value):
    """Topic ``fault``: the first cause, latched until a reset; ``entry`` None when cleared."""

    entry: FaultEntry | None = None
    detail: str = ""
    during: str = ""
    """The state in which it struck."""
    later: tuple[str, ...] = ()
    """What came after the first cause, a failed reset included."""


class LogData(Value):
    """Topic ``log``: a warning or an error of the daemon, for people."""

    level: Literal["warning", "error"]
    message: str


class HealthData(Value):
    """Topic ``health``: the heartbeat, sent at a fixed interval whatever happens."""

    uptime_s: float
    loop_blocked_p99_s: float
    """99th percentile of how long the control loop was blocked in the last minute (wall time)."""
    loop_blocked_max_s: float
    inbox: int
    """Events that wait in the controller's inbox."""


StatusData = (
    StateData
    | JobData
    | PartData
    | ArmData
    | ConveyorData
    | GripperData
    | SpeechData
    | EarsData
    | FaultData
    | LogData
    | HealthData
)

TOPICS: dict[str, type[Value]] = {
    "state": StateData,
    "job": JobData,
    "part": PartData,
    "arm": ArmData,
    "conveyor": ConveyorData,
    "gripper": GripperData,
    "speech": SpeechData,
    "ears": EarsData,
    "fault": FaultData,
    "log": LogData,
    "health": HealthData,
}
TOPIC_OF = {model: topic for topic, model in TOPICS.items()}


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
    ears: EarsData = EarsData(state="off")


class SnapshotCommand(Value):
    """Ask for the whole picture."""

    command: Literal["snapshot"] = "snapshot"


class SayCommand(Value):
    """Typed words, as if they had been spoken."""

    command: Literal["say"] = "say"
    text: Annotated[str, Field(min_length=1, max_length=MAX_TEXT)]


class HearCommand(Value):
    """Listen to the wav file in the request's second frame."""

    command: Literal["hear"] = "hear"
    name: Annotated[str, Field(max_length=200)]


class BuildCommand(Value):
    """Build the mesh or the plan in the request's second frame; the name's suffix tells which."""

    command: Literal["build"] = "build"
    name: Annotated[str, Field(max_length=200)]


class ConfirmCommand(Value):
    """Answer "Shall I build it?"."""

    command: Literal["confirm"] = "confirm"
    answer: bool


class PlainCommand(Value):
    """A command without arguments."""

    command: Literal[
        "pause", "resume", "stop", "cancel", "reset", "clear", "hand_over", "take_apart"
    ]


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


class MuteCommand(Value):
    """Close the microphone, or open it again."""

    command: Literal["mute", "unmute"]


Command = Annotated[
    SnapshotCommand
    | SayCommand
    | HearCommand
    | BuildCommand
    | ConfirmCommand
    | PlainCommand
    | ListenCommand
    | MuteCommand
    | RefillCommand
    | RecoverCommand
    | MissingCommand
    | CountCommand
    | OwnCommand
    | HandCommand
    | GripperCommand,
    Field(discriminator="command"),
]


class ControlRequest(Value):
    """A request; the role of the one who asks follows from the door it comes in by."""

    schema_version: Literal[2] = SCHEMA_VERSION
    id: Annotated[str, Field(min_length=1, max_length=64)]
    """Chosen by the one who asks; the reply carries it."""
    body: Command


class ReplyError(Value):
    """Why a request was not carried out; ``busy``: too many wait, the same may be asked again."""

    code: Literal["invalid", "refused", "busy", "usage", "internal"]
    message: str
    hint: str = ""


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
    error: ReplyError | None = None


def attachment_limit(role: Role, max_audio_s: float) -> int:
    """Largest file that a request of that role may carry, in bytes.

    A visitor sends recordings only: the longest that is listened to, in the largest form that
    sound cards deliver (48 kHz, stereo, 32 bit), and the file's header.
    """
    recording = int(max_audio_s * 48_000 * 2 * 4) + MAX_REQUEST
    return MAX_ATTACHMENT if role is Role.OPERATOR else min(recording, MAX_ATTACHMENT)


OPERATOR_COMMANDS = frozenset(
    {"build", "resume", "reset", "clear", "refill", "recover", "missing", "count", "own", "hand"}
    | {"unmute", "gripper"}
)
"""Commands that a visitor may not give."""
