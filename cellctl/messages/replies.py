"""What is told to those who ask for more than a command: one model a kind of answer."""

from __future__ import annotations

from datetime import datetime
from typing import Annotated, Literal

from pydantic import Field

from cellctl.assembly import BuildPlan, Cell, PartOutcome, Role, Value
from cellctl.messages.commands import FileKind
from cellctl.messages.status import LogData, Outcome


class FileData(Value):
    """About the file that is the reply's second frame."""

    about: Literal["file"] = "file"
    job_id: str
    kind: FileKind
    name: str
    """To save it under."""
    media_type: str
    size_bytes: int
    sha256: str


class JobSummary(Value):
    """One job of the journal, in short."""

    number: int
    """Grows from job to job."""
    job_id: str
    role: Role
    began_at: datetime
    finished_at: datetime | None = None
    what: str
    """The words that it began with, or the name of a file; empty where nothing was understood."""
    title: str = ""
    """What was planned; empty where nothing was."""
    phase: str
    outcome: Outcome
    message: str = ""
    parts_done: int
    """Parts that were placed or taken off."""
    steps: int
    """Of its plan."""
    seconds: float
    """Cell time that its parts took."""
    cellctl_version: str
    """Of the cellctl that wrote it last."""
    config_sha256: str
    """Of that cellctl's configuration."""


class HistoryData(Value):
    """A page of the journal's jobs, newest first."""

    about: Literal["history"] = "history"
    jobs: tuple[JobSummary, ...]
    total: int
    """How many jobs the journal has."""
    next_before: int | None = None
    """Where the next page begins; None after the last one."""


class ActData(Value):
    """One act of the cell, or of a person, as the journal has it."""

    act_id: int
    kind: str
    step: int | None = None
    """Index in the job's plan."""
    cell: Cell | None = None
    intended_at: datetime
    settled_at: datetime | None = None
    outcome: Literal["done", "failed", "interrupted"] | None = None
    """None while it is under way, or was cut off."""
    detail: str = ""
    moves: tuple[str, ...] = ()
    """What became of parts, in order."""


class JobRecordData(Value):
    """All that the journal has of one job but its mesh; ``file`` has that."""

    about: Literal["job"] = "job"
    job: JobSummary
    plan: BuildPlan | None = None
    parts: tuple[PartOutcome, ...] = ()
    """In the order in which they were done."""
    acts: tuple[ActData, ...] = ()
    """In their order."""
    has_mesh: bool = False


class DeviceData(Value):
    """One device of the cell."""

    name: Literal["robot", "conveyor", "gripper", "microphone"]
    connected: bool
    model: str = ""
    serial_number: str = ""
    version: str = ""
    """Of its software."""
    detail: str = ""


class GeneratorData(Value):
    """One source of shapes; they are asked in the order of the list."""

    name: str
    where: str = ""
    """The machine that is asked; empty: this computer."""
    ready: bool
    """Whether it has what it needs, such as its key."""


class AboutData(Value):
    """What the cell consists of."""

    about: Literal["about"] = "about"
    version: str
    """Of cellctl."""
    python: str
    config_sha256: str
    journal: str
    uptime_s: float
    devices: tuple[DeviceData, ...]
    recogniser: str
    language: str
    understanding: str
    """The language model that is asked first; empty: the rules on this computer alone."""
    generators: tuple[GeneratorData, ...]
    packages: dict[str, str]
    """The libraries that it runs on, with their versions."""


class LimitData(Value):
    """One limit that the cell keeps."""

    option: str
    """Of the configuration, with its table; the unit stands in the name."""
    configured: float | str
    in_force: float | str | None = None
    """What holds now, where something else can make it less or tell it anew."""


class LimitsData(Value):
    """The limits that the cell keeps."""

    about: Literal["limits"] = "limits"
    limits: tuple[LimitData, ...]


class LogEntry(Value):
    """A warning or an error, with its time."""

    time: datetime
    entry: LogData


class LogsData(Value):
    """The newest warnings and errors of the daemon, oldest first."""

    about: Literal["log"] = "log"
    entries: tuple[LogEntry, ...]


class AuditEntry(Value):
    """One command that was given at a door."""

    time: datetime
    role: Role
    command: str
    detail: str = ""
    """Its arguments; what somebody said is not among them."""
    ok: bool
    message: str = ""
    """What was answered."""


class AuditData(Value):
    """Commands since the daemon started, oldest first; what only asks is not among them."""

    about: Literal["audit"] = "audit"
    entries: tuple[AuditEntry, ...]


ReplyData = Annotated[
    FileData | HistoryData | JobRecordData | AboutData | LimitsData | LogsData | AuditData,
    Field(discriminator="about"),
]
"""What a reply may carry."""
