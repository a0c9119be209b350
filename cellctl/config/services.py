"""The tables of what runs on the computer: hearing, planning, bus, journal, policy, emulation."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from cellctl.assembly import Role
from cellctl.config.section import Pose, Positive, Section
from cellctl.endpoints import endpoint_problem


class HearingSection(Section):
    """Where words come from."""

    language: Annotated[str, Field(pattern=r"^[a-z]{2,3}$")] = "en"
    """The language that is recognised; for others than ``en`` and ``ko`` a Vosk model is needed, in
    the model folder or named by model_path."""
    model_path: str | None = None
    """A Vosk model folder; when set it must be good, nothing else is tried."""
    model_folder: str = "/var/lib/cellctl/models"
    """The cell's own model folder."""
    allow_download: bool = False
    """May fetch the pinned English Vosk model when none is found."""
    microphone: str = "none"
    """``none`` opens no microphone; empty is the system's own choice; else the beginning or a part
    of one's name, as ``cellctl microphone`` lists them."""
    activation: Literal["wake_word", "push_to_talk", "open"] = "wake_word"
    """What makes a sentence a request: the wake word, `cellctl listen`, or nothing. Either of the
    first two leaves the button at work."""
    wake_word: Literal["okay_nabu", "hey_jarvis", "hey_mycroft", "alexa"] = "okay_nabu"
    """The phrase that is waited for."""
    max_audio_s: Annotated[float, Field(ge=1.0, le=120.0)] = 30.0
    """Longer recordings are refused."""


class VoiceSection(Section):
    """How the cell speaks aloud; what it says stands on the screen all the same."""

    loudspeaker: str = "none"
    """``none`` opens no loudspeaker; empty is the system's own choice; else a part of one's name,
    as ``cellctl voice devices`` lists them."""
    voice: Annotated[str, Field(max_length=40, pattern=r"^[A-Za-z0-9+_-]*$")] = ""
    """One of espeak-ng's voices, such as ``en-gb+f3``; empty is the packaged voice for English, and
    espeak-ng's own for other languages."""
    volume: Annotated[float, Field(gt=0.0, le=1.0)] = 0.7
    """Of the loudest moment of each sentence, as a share of what the loudspeaker can."""
    chimes: bool = True
    """Sounds a chime when the cell begins to listen, and when it has heard something."""


class PlanningSection(Section):
    """How a shape becomes a plan."""

    scale_unitless_to_workspace: bool = True
    """A mesh without a unit is scaled until it fills the workspace; else it is taken as metres."""
    policy: Literal["cellctl", "paper"] = "cellctl"
    """``cellctl`` proves every step and keeps the shape; ``paper`` follows the paper's algorithms
    1 to 5, its thresholds and its rescaling."""
    budget_s: Positive = 20.0
    """How long a plan may be improved; the best verified one so far is taken then (wall time)."""
    others_budget_s: Positive = 2.0
    """Where a shape cannot be built, or keeps too little of itself, others are planned until so
    long after its own plan was begun (wall time)."""
    timeout_s: Positive = 60.0
    """For one plan (wall time); more than its budget, for it takes time beyond that."""

    @model_validator(mode="after")
    def _in_time(self) -> Self:
        if self.budget_s >= self.timeout_s:
            raise ValueError(
                f"budget_s must be less than timeout_s ({self.budget_s:g} and {self.timeout_s:g}): "
                "a plan that may be improved for so long is always ended before it is there"
            )
        return self


class BusSection(Section):
    """ZeroMQ end points: ipc, or tcp on loopback; anything wider works with keys only."""

    status: str = "tcp://127.0.0.1:5571"
    """Where status is published."""
    visitor: str = "tcp://127.0.0.1:5572"
    """Where visitors' commands are taken: the visitor's door."""
    operator: str = "tcp://127.0.0.1:5574"
    """Where operators' commands are taken: the operator's door."""
    keys: Annotated[str, Field(min_length=1)] = "/etc/cellctl/keys"
    """Folder of the keys, for end points that are wider than that; `cellctl keys make` fills it."""
    heartbeat_s: Annotated[float, Field(gt=0.0, le=10.0)] = 1.0
    """Longest silence on the status stream (wall time)."""

    @model_validator(mode="after")
    def _end_points(self) -> Self:
        taken: dict[str, str] = {}
        for name, endpoint in self.endpoints.items():
            if problem := endpoint_problem(endpoint):
                raise ValueError(f"{name} {problem} (not {endpoint!r})")
            if other := taken.get(endpoint):
                raise ValueError(f"{other} and {name} must differ (both are {endpoint!r})")
            taken[endpoint] = name
        return self

    @property
    def endpoints(self) -> dict[str, str]:
        """The end points by the names of their options."""
        return {"status": self.status, "visitor": self.visitor, "operator": self.operator}

    def door(self, role: Role) -> str:
        """The end point at which that role asks."""
        return self.operator if role is Role.OPERATOR else self.visitor


class JournalSection(Section):
    """The file that remembers every act, every job and every part."""

    path: Annotated[str, Field(min_length=1)] = "/var/lib/cellctl/journal.db"
    """Where it is; its folder is made if need be."""
    keep_days: Positive = 365.0
    """Jobs that finished longer ago are forgotten, in days."""
    keep_jobs: Annotated[int, Field(ge=1, le=1_000_000)] = 1000
    """The newest jobs are kept, however old."""


class PolicySection(Section):
    """What the cell asks before it acts."""

    confirmation: Literal["ask", "waived"] = "ask"
    """``waived`` builds without asking "Shall I build it?"."""
    confirmation_timeout_s: Positive = 30.0
    """Silence for this long means no."""
    refill_timeout_s: Positive = 1800.0
    """An empty belt waits for parts so long before it is a fault (cell time)."""


class EmulationSection(Section):
    """The emulated cell, for ``cellctl sim``; a real cell has no such table."""

    control: str = "tcp://127.0.0.1:5573"
    """Where faults are injected and the world's truth is read."""
    seed: int = 1
    """Of everything that is random in it."""
    jolt_limit_m2_s3: Positive = 2.6
    """A part that is set down harder falls: commanded speed times acceleration of the movement that
    brings it to its seat. 2.25 to 3.125 give the paper's table."""
    shifted_tool: Pose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """The emulated tool is moved by this, in its own frame, against what ``tool.frame`` says."""
    shifted_base: Pose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """The same of the robot with its pedestal, and ``base.frame`` and ``pedestal.frame``."""
    shifted_feeder: Pose = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    """The same of the conveyor, and ``feeder.frame``."""
    controller_version: Literal["3.15", "5.12"] = "5.12"
    """Controller software to emulate; 3.15 is a CB3 with 125 Hz."""
    firmware: Literal["plain", "elf"] = "plain"
    """The boards: emulators of their own, or the compiled programs in an AVR simulator."""
    firmware_folder: str | None = None
    """Where gripper.elf and conveyor.elf are; none: where ``make firmware`` puts them."""
