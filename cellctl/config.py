"""cell.toml -> validated settings.

One model describes a cell, real or emulated; the units stand in the names. Every refusal names the
file, the key, what is wrong with it and the nearest name that would be right.

All frames are poses in the *cell frame*: right-handed, z up, origin on the floor. A pose is
``[x_m, y_m, z_m, rx_rad, ry_rad, rz_rad]`` with a rotation vector, as the robot's pendant shows it.
"""

from __future__ import annotations

import difflib
import hashlib
import os
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, Self, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from cellctl.assembly import Role
from cellctl.endpoints import endpoint_problem
from cellctl.errors import ConfigError

DEFAULT_PATH = Path("/etc/cellctl/cell.toml")
ENVIRONMENT_VARIABLE = "CELLCTL_CONFIG"

Pose = tuple[float, float, float, float, float, float]
"""x, y, z in metres, then a rotation vector in radians."""
Joints = tuple[float, float, float, float, float, float]
"""Joint positions from base to wrist 3, in radians."""
Vector = tuple[float, float, float]
Positive = Annotated[float, Field(gt=0.0)]
NotNegative = Annotated[float, Field(ge=0.0)]
Port = Annotated[int, Field(ge=1, le=65535)]


class Section(BaseModel):
    """Base of every table of the file."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, strict=True)

    @model_validator(mode="before")
    @classmethod
    def _arrays_are_tuples(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        return {key: tuple(v) if isinstance(v, list) else v for key, v in data.items()}


class CellSection(Section):
    """What this cell is."""

    name: Annotated[str, Field(min_length=1, max_length=80)]
    """What people call it."""
    kind: Literal["real", "emulated"]
    """``emulated`` lets ``cellctl sim`` and ``cellctl demo`` stand in for the metal."""
    clock_rate: Annotated[float, Field(gt=0.0, le=100.0)] = 1.0
    """Cell seconds per wall second; anything but 1.0 needs ``kind = "emulated"``."""


class WorkspaceSection(Section):
    """Where things are built."""

    frame: Pose
    """Minimum corner of the building space, on the floor."""
    size_m: tuple[Positive, Positive, Positive]
    """Along x, y and z; as many whole cells as fit are used."""


class BaseSection(Section):
    """Where the robot stands."""

    frame: Pose
    """The robot's base frame, as the pendant's *Base* feature has it."""


class PedestalSection(Section):
    """The block that the robot stands on: an obstacle."""

    frame: Pose
    """Centre of its top face."""
    size_m: tuple[Positive, Positive, Positive]
    """Along x, y and z."""


class ToolSection(Section):
    """The latch gripper on the robot's flange."""

    frame: Pose
    """TCP in the flange frame: the centre of the top face of a gripped voxel, z into the voxel."""
    width_m: Positive
    """Edge of the square that the gripper's body needs, seen from above."""
    height_m: Positive
    """From the flange to the gripper's lower face."""
    payload_kg: Annotated[float, Field(gt=0.0, le=12.5)]
    """Gripper and one voxel together."""
    payload_cog_m: Vector
    """Centre of gravity of that payload, in the flange frame."""
    voltage_v: Literal[0, 12, 24] = 0
    """Supply of the tool's connector in the robot's installation; compared, never set: only a
    program of its own could set it."""


class VoxelSection(Section):
    """The reusable part."""

    pitch_m: Annotated[float, Field(ge=0.02, le=0.25)]
    """Edge of a cell: the distance from one part's centre to its neighbour's."""
    mass_kg: Positive
    """Mass of one part."""


class LimitsSection(Section):
    """What can be built, after the paper's section 3.3."""

    inventory_parts: Annotated[int, Field(ge=1, le=1000)]
    """Most parts that one object may have."""
    overhang_cells: Annotated[int, Field(ge=0, le=50)]
    """Most cells that a row may reach out from the last supported one, by the policy ``paper``."""
    stack_cells: Annotated[int, Field(ge=1, le=50)]
    """Most cells on top of each other without a neighbour beside them, by the policy ``paper``."""


class StabilitySection(Section):
    """What holds parts together, and what a placement does to them.

    The paper publishes none of it. With parts of 0.15 kg the defaults fit what it reports: its four
    objects stand at every step of a good order; a row of three over nothing holds while it is built
    and one of four does not; a column of four with a part on top does, and one higher does not.
    """

    magnet_force_n: Positive = 22.0
    """Pull that one joint of two faces holds, straight apart."""
    contact: Literal["diamond", "square"] = "square"
    """Where two faces touch: all over, or in a square that stands on its corner (cuboctahedra).
    With ``diamond`` no magnets fit both the paper's table on one leg and its rows of three."""
    friction: Annotated[float, Field(ge=0.0, le=2.0)] = 0.5
    """Coefficient between two faces, and between a part and the floor."""
    floor: Literal["grips", "bare"] = "grips"
    """``grips``: the floor holds a part like another part does; ``bare``: it only carries it."""
    polarity: Literal["genderless", "directed"] = "genderless"
    """``genderless``: any two side faces attract; ``directed``: only opposite ones, so that all
    parts must be placed with the same yaw."""
    yaw_symmetry_deg: Literal[90, 180, 360] = 90
    """A part turned by this about the vertical is the same part."""
    placement_down_n: NotNegative = 1.5
    """How hard a part is pressed down when it is placed."""
    placement_side_n: NotNegative = 2.9
    """How hard it may be pushed aside meanwhile, at its top face, in any direction."""
    least_margin: Annotated[float, Field(ge=1.0, le=10.0)] = 1.0
    """The joints must bear this many times what every step asks of them."""


class RobotSection(Section):
    """The arm and its controller."""

    model: Literal["ur10", "ur10e"]
    """What the controller must say that it is; another one is a fault."""
    host: Annotated[str, Field(min_length=1)]
    """Name or address of the robot's controller."""
    dashboard_port: Port = 29999
    """TCP port of its dashboard server; the other ports are fixed."""
    rtde_frequency_hz: Literal[125, 500]
    """How often the controller reports; a ur10 (CB3) knows 125 only."""
    home_rad: Joints
    """Where the arm rests between jobs, clear of everything."""
    travel_speed_m_s: Annotated[float, Field(gt=0.0, le=3.0)]
    """Speed of the TCP between feeder and workspace."""
    travel_acceleration_m_s2: Annotated[float, Field(gt=0.0, le=10.0)]
    """Acceleration of the TCP, everywhere."""
    approach_speed_m_s: Annotated[float, Field(gt=0.0, le=1.0)]
    """Speed over the last stretch, where parts touch."""
    approach_height_m: Annotated[float, Field(gt=0.0, le=0.2)]
    """Length of that stretch."""
    blend_radius_m: Annotated[float, Field(ge=0.0, le=0.2)]
    """How round the corners of a path may be; 0 stops at each."""
    clearance_m: Annotated[float, Field(gt=0.0, le=0.3)]
    """Least distance between a carried part and what it crosses."""
    watchdog_hz: Annotated[float, Field(ge=5.0, le=50.0)] = 10.0
    """The controller stops the arm when it hears nothing for one period of this."""
    host_silence_s: Annotated[float, Field(ge=0.2, le=5.0)] = 1.0
    """The arm process stops the arm when the daemon says nothing for this long (wall time)."""
    connect_timeout_s: Positive = 10.0
    """For connecting to the controller and starting its program."""
    move_timeout_factor: Annotated[float, Field(ge=1.2, le=20.0)] = 3.0
    """A movement that takes this many times its planned duration, plus 2 s, is a fault."""


class GripperSection(Section):
    """The gripper's lines on the robot's controller. High on the command line unlatches."""

    command_output: Annotated[int, Field(ge=0, le=7)]
    """Standard digital output."""
    status_input: Annotated[int, Field(ge=0, le=7)]
    """Standard digital input; high while a completed latch is confirmed."""
    travel_timeout_s: Positive
    """For the latch to move and say so (cell time)."""
    release_s: Positive = 0.5
    """How long the latch takes to open, which no line tells (cell time)."""
    retries: Annotated[int, Field(ge=0, le=5)] = 1
    """How often a silent gripper or a missed pick is tried again before it is a fault."""


class FeederSection(Section):
    """The conveyor that brings parts."""

    frame: Pose
    """Centre of the top face of the part that waits at the pick station; x along the feed."""
    port: Annotated[str, Field(min_length=1)]
    """Serial port of the conveyor's board."""
    baud: Literal[9600, 19200, 38400, 57600, 115200] = 115200
    """Bits per second on that port."""
    capacity_parts: Annotated[int, Field(ge=1, le=1000)]
    """How many parts a full belt holds."""
    width_m: Positive
    """Width of the belt, an obstacle."""
    reply_timeout_s: Positive = 0.3
    """For one line's answer (wall time); a line is sent again twice before the board is lost."""
    index_timeout_s: Positive = 10.0
    """For bringing one part to the pick station (cell time)."""
    retries: Annotated[int, Field(ge=0, le=5)] = 1
    """How often an index that brought nothing is tried again before it is a fault."""


class HearingSection(Section):
    """Where words come from."""

    language: Literal["en", "ko"] = "en"
    """The language that is recognised."""
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


class PlanningSection(Section):
    """How a shape becomes a plan."""

    scale_unitless_to_workspace: bool = True
    """A mesh without a unit is scaled until it fills the workspace; else it is taken as metres."""
    policy: Literal["cellctl", "paper"] = "cellctl"
    """``cellctl`` proves every step and keeps the shape; ``paper`` follows the paper's algorithms
    1 to 5, its thresholds and its rescaling."""
    budget_s: Positive = 20.0
    """How long a plan may be improved; the best verified one so far is taken then (wall time)."""
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
    controller_version: Literal["3.15", "5.12"] = "5.12"
    """Controller software to emulate; 3.15 is a CB3 with 125 Hz."""


class CellConfig(Section):
    """Everything that cellctl knows about one cell."""

    cell: CellSection
    workspace: WorkspaceSection
    base: BaseSection
    pedestal: PedestalSection
    tool: ToolSection
    voxel: VoxelSection
    limits: LimitsSection
    stability: StabilitySection = StabilitySection()
    robot: RobotSection
    gripper: GripperSection
    feeder: FeederSection
    hearing: HearingSection = HearingSection()
    planning: PlanningSection = PlanningSection()
    bus: BusSection = BusSection()
    journal: JournalSection = JournalSection()
    policy: PolicySection = PolicySection()
    emulation: EmulationSection | None = None

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.cell.kind == "real" and self.cell.clock_rate != 1.0:
            raise ValueError("cell.clock_rate must be 1.0 for a real cell")
        if self.cell.kind == "real" and self.emulation is not None:
            raise ValueError('a real cell has no [emulation] table; set cell.kind = "emulated"')
        if self.cell.kind == "emulated" and self.emulation is None:
            raise ValueError("an emulated cell needs an [emulation] table")
        if self.robot.model == "ur10" and self.robot.rtde_frequency_hz != 125:
            raise ValueError("robot.rtde_frequency_hz must be 125 for a ur10 (CB3 controller)")
        if self.robot.model == "ur10" and self.tool.payload_kg > 10.0:
            raise ValueError("tool.payload_kg must be at most 10.0 for a ur10")
        if min(self.workspace.size_m) < self.voxel.pitch_m:
            raise ValueError("workspace.size_m must hold at least one voxel on every axis")
        return self

    @property
    def sha256(self) -> str:
        """Of all settings: tells whether two runs had the same."""
        return hashlib.sha256(self.model_dump_json().encode()).hexdigest()

    @property
    def grid(self) -> tuple[int, int, int]:
        """How many whole cells fit the workspace along x, y and z."""
        nx, ny, nz = (int(edge / self.voxel.pitch_m + 1e-9) for edge in self.workspace.size_m)
        return (nx, ny, nz)


def find_config(explicit: Path | None) -> Path:
    """Where the configuration is: ``--config``, then the environment, then ``/etc``.

    Raises:
        ConfigError: none of them names a file that exists. The emulated cell is never assumed.
    """
    if explicit is not None:
        return explicit
    if from_environment := os.environ.get(ENVIRONMENT_VARIABLE):
        return Path(from_environment)
    if DEFAULT_PATH.exists():
        return DEFAULT_PATH
    raise ConfigError(
        f"No configuration: --config is not given, ${ENVIRONMENT_VARIABLE} is not set, "
        f"and {DEFAULT_PATH} does not exist.",
        "Name one, for example --config config/sim.toml for the emulated cell.",
    )


def load_config(path: Path) -> CellConfig:
    """Read and validate one file.

    Raises:
        ConfigError: with one line for each thing that is wrong.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}.") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not UTF-8 text.") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: is not valid TOML: {error}.") from error
    return parse_config(data, str(path))


def parse_config(data: dict[str, Any], origin: str) -> CellConfig:
    """Validate settings that are already parsed; ``origin`` names them in errors.

    Raises:
        ConfigError: with one line for each thing that is wrong.
    """
    try:
        return CellConfig.model_validate(data)
    except ValidationError as error:
        lines = [f"{origin}: {_explain(item)}" for item in error.errors()]
        raise ConfigError("\n".join(lines)) from error


UNITS = {
    "_m_s2": "metres per second squared",
    "_m_s": "metres per second",
    "_kg": "kilograms",
    "_hz": "hertz",
    "_rad": "radians",
    "_m": "metres",
    "_s": "seconds",
    "_v": "volts",
}
"""What the endings of option names mean; the longer ones first."""


def unit_of(name: str) -> str:
    """The unit that an option's name ends in, in words; empty for none."""
    return next((unit for ending, unit in UNITS.items() if name.endswith(ending)), "")


def _explain(item: Any) -> str:
    location = list(item["loc"])
    key = ".".join(str(part) for part in location if isinstance(part, str)) or "(whole file)"
    key += "".join(f"[{part}]" for part in location if isinstance(part, int))
    kind = item["type"]
    if kind == "extra_forbidden":
        return f"{key}: unknown key; {_suggest([str(part) for part in location])}"
    if kind == "missing":
        return f"{key}: is missing."
    if kind in {"model_type", "model_attributes_type", "dict_type"}:
        return f"{key} = {item['input']!r}: must be a table, [{key}]."
    message = item["msg"].removeprefix("Value error, ").removeprefix("Input ")
    message = message[0].lower() + message[1:].replace("tuple", "array")
    if kind == "value_error":
        return f"{key}: {message}." if location else f"{message}."
    names = [part for part in location if isinstance(part, str)]
    unit = unit_of(names[-1]) if names else ""
    number = f" (in {unit})" if unit else ""
    return f"{key} = {item['input']!r}: {message.replace('should', 'must', 1)}{number}."


def _suggest(location: list[str]) -> str:
    """The valid name that an unknown one most likely stands for."""
    *tables, name = location
    here = _names_in(tables)
    elsewhere = [
        f"{table}.{name}"
        for table in CellConfig.model_fields
        if [table] != tables and name in _names_in([table])
    ]
    if elsewhere:
        return f"did you mean {' or '.join(elsewhere)}?"
    if near := difflib.get_close_matches(name, here, n=1, cutoff=0.4):
        return f"did you mean {'.'.join([*tables, near[0]])}?"
    return f"known here: {', '.join(sorted(here))}."


def _names_in(tables: list[str]) -> list[str]:
    """The keys that a table may hold; those of the whole file for no table."""
    model: type[BaseModel] = CellConfig
    for table in tables:
        annotation = model.model_fields[table].annotation
        options = (annotation, *get_args(annotation))  # [emulation] may be absent: X | None
        model = next(o for o in options if isinstance(o, type) and issubclass(o, BaseModel))
    return list(model.model_fields)
