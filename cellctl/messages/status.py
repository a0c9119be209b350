"""What the daemon publishes: one model a topic."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from cellctl.assembly import Change, Check, Pace, PartOutcome, Request, Role, Utterance, Value
from cellctl.errors import FaultEntry
from cellctl.messages.dialogue import DialogueData
from cellctl.notices import Notice


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
    """The state in words, with what has to be done where the cell waits for people."""
    commands: tuple[str, ...] = ()
    """Commands that can lead on from here, by the machine's table; a visitor may not give all."""


Outcome = (
    Literal["", "built", "taken_apart", "cancelled", "declined"]
    | Literal["unreadable", "no_object", "cannot_plan", "failed"]
)
"""How a job ended; empty while it is under way. ``unreadable``: the recording or file cannot be
used, or there is nothing to recognise speech with; ``failed``: a worker did not do its work."""


class JobData(Value):
    """Topic ``job``: one wish, from the sentence to the last part.

    Title, message, changes and questions are in the cell's language.
    """

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
    pace: Pace | None = None
    """What the movements with a part are told, where it is a trial of that."""
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
    speed_fraction: float = 1.0
    """Where the speed slider on the pendant is; 1 is full speed."""


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


VoiceCondition = Literal["off", "starting", "quiet", "speaking", "silent", "lost"]
"""``off``: no loudspeaker is configured; ``silent``: it is muted in the sound settings; ``lost``:
there is no loudspeaker, or no voice for the language, and it is looked for again."""


class VoiceData(Value):
    """Topic ``voice``: whether and how the cell speaks aloud."""

    state: VoiceCondition
    device: str = ""
    """The loudspeaker's name; empty while there is none."""
    voice: str = ""
    """Who speaks; empty until something was said."""
    saying: str = ""
    """What is being said; empty while nothing is."""
    sentence: str = ""
    """What is wrong, in words for the people in the room; empty while nothing is."""
    notice: Notice | None = None
    """What is wrong with it, while it is."""


class FaultData(Value):
    """Topic ``fault``: the first cause, latched until a reset; ``entry`` None when cleared.

    Title, remedy and detail are in the cell's language.
    """

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
    | VoiceData
    | DialogueData
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
    "voice": VoiceData,
    "dialogue": DialogueData,
    "fault": FaultData,
    "log": LogData,
    "health": HealthData,
}
TOPIC_OF = {model: topic for topic, model in TOPICS.items()}
