"""What the cell consists of, and which limits it keeps, as the bus tells them."""

from __future__ import annotations

import platform
from dataclasses import dataclass
from functools import cache
from importlib import metadata
from typing import Final, Literal
from urllib.parse import urlsplit

from cellctl import __version__
from cellctl.assembling.arm import ArmCheck, ArmIdentity
from cellctl.assembly import Pace
from cellctl.config import CellConfig, GeneratorName
from cellctl.credentials import find_credential
from cellctl.errors import ConfigError
from cellctl.feeding.inventory import Counts
from cellctl.messages import (
    AboutData,
    BoardData,
    ConveyorData,
    DeviceData,
    EarsData,
    GeneratorData,
    GripperData,
    LimitData,
    LimitsData,
)

_LIBRARIES: Final = (
    *("numpy", "ortools", "pydantic", "pyserial", "pyzmq", "scipy", "structlog", "transitions"),
    *("trimesh", "ur-analytic-ik", "ur-rtde", "vosk", "sounddevice", "faster-whisper"),
)
_CREDENTIALS: Final[dict[GeneratorName, str]] = {
    "meshy": "meshy-key",
    "tripo": "tripo-key",
    "model": "llm-key",
}
"""What a source of shapes cannot do without; a machine of one's own may want no key."""
SHOWN_LIMITS: Final = (
    "workspace.size_m",
    "voxel.pitch_m",
    "voxel.mass_kg",
    "limits.inventory_parts",
    "feeder.capacity_parts",
    "planning.policy",
    "stability.least_margin",
    "limits.overhang_cells",
    "limits.stack_cells",
    "planning.timeout_s",
    "robot.model",
    "robot.travel_speed_m_s",
    "robot.travel_acceleration_m_s2",
    "robot.carrying_speed_m_s",
    "robot.carrying_acceleration_m_s2",
    "robot.carrying_measured",
    "robot.approach_speed_m_s",
    "robot.joint_speed_fraction",
    "robot.clearance_m",
    "robot.margin_m",
    "robot.touch_force_n",
    "robot.watchdog_hz",
    "robot.host_silence_s",
    "tool.payload_kg",
    "tool.voltage_v",
    "policy.confirmation",
    "policy.confirmation_timeout_s",
    "policy.refill_timeout_s",
    "hearing.max_audio_s",
    "journal.keep_days",
    "journal.keep_jobs",
)
"""Options that limit what the cell does, in the order in which people look for them."""


@dataclass(frozen=True)
class Present:
    """What is known of the cell at one moment."""

    identity: ArmIdentity | None
    check: ArmCheck | None
    """What the robot has set, as it was last read back."""
    robot_connected: bool
    conveyor: ConveyorData
    gripper: GripperData
    ears: EarsData
    recogniser: str
    counts: Counts
    standing: int
    uptime_s: float


def about(config: CellConfig, now: Present) -> AboutData:
    """Devices, software and their versions. Reads files, so that it belongs into a thread."""
    understanding = config.understanding
    return AboutData(
        version=__version__,
        python=platform.python_version(),
        config_sha256=config.sha256,
        journal=config.journal.path,
        uptime_s=now.uptime_s,
        devices=(_robot(config, now), *_boards(config, now), _microphone(now.ears)),
        recogniser=now.recogniser,
        language=config.hearing.language,
        understanding=understanding.model_name if understanding.back_end == "model" else "",
        generators=tuple(_generator(config, name) for name in config.generating.chain),
        packages=_packages(),
    )


def limits(config: CellConfig, now: Present) -> LimitsData:
    """What is configured, and what is in force."""
    in_force = _in_force(config, now)
    return LimitsData(
        limits=tuple(
            LimitData(option=name, configured=_value(config, name), in_force=in_force.get(name))
            for name in SHOWN_LIMITS
        )
    )


def carrying(config: CellConfig) -> Pace:
    """The most that a movement with a part has."""
    robot = config.robot
    return Pace(
        speed_m_s=min(robot.carrying_speed_m_s, robot.travel_speed_m_s),
        acceleration_m_s2=min(robot.carrying_acceleration_m_s2, robot.travel_acceleration_m_s2),
    )


def _robot(config: CellConfig, now: Present) -> DeviceData:
    identity = now.identity
    return DeviceData(
        name="robot",
        connected=now.robot_connected,
        model=identity.model if identity is not None else config.robot.model,
        serial_number=identity.serial_number if identity is not None else "",
        version=identity.controller_version if identity is not None else "",
        detail=config.robot.host,
    )


def _boards(config: CellConfig, now: Present) -> tuple[DeviceData, DeviceData]:
    conveyor = _board("conveyor", now.conveyor.board, connected=now.conveyor.connected)
    gripper = _board("gripper", now.gripper.board, connected=now.gripper.board is not None)
    if config.gripper.port is None:
        # Its two lines command the latch; the serial port tells more, and need not be there.
        gripper = gripper.model_copy(update={"connected": now.robot_connected, "detail": "lines"})
    return conveyor, gripper


def _board(
    name: Literal["conveyor", "gripper"], board: BoardData | None, *, connected: bool
) -> DeviceData:
    if board is None:
        return DeviceData(name=name, connected=connected)
    return DeviceData(
        name=name,
        connected=connected,
        serial_number=board.serial_number,
        version=board.firmware_version,
        detail=board.port,
    )


def _microphone(ears: EarsData) -> DeviceData:
    heard = ears.state not in {"off", "lost", "starting"}
    return DeviceData(name="microphone", connected=heard, model=ears.device, detail=ears.state)


def _generator(config: CellConfig, name: GeneratorName) -> GeneratorData:
    url = {
        "meshy": config.generating.meshy_url,
        "tripo": config.generating.tripo_url,
        "server": config.generating.server_url,
        "model": config.understanding.model_url,
    }.get(name, "")
    credential = _CREDENTIALS.get(name)
    try:
        ready = credential is None or find_credential(credential) is not None
    except ConfigError:
        ready = False
    return GeneratorData(name=name, where=urlsplit(url).hostname or "", ready=ready)


@cache
def _packages() -> dict[str, str]:
    found = {}
    for name in _LIBRARIES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue  # of an extra that is not installed
    return found


def _value(config: CellConfig, option: str) -> float | str:
    table, name = option.split(".")
    value = getattr(getattr(config, table), name)
    if isinstance(value, tuple):
        return " x ".join(f"{edge:g}" for edge in value)
    return value if isinstance(value, str) else float(value)


def _in_force(config: CellConfig, now: Present) -> dict[str, float | str]:
    """What holds now, by option, where the configuration does not decide alone."""
    counts, carried = now.counts, carrying(config)
    found: dict[str, float | str] = {
        "workspace.size_m": " x ".join(str(edge) for edge in config.grid) + " cells",
        "limits.inventory_parts": min(
            config.limits.inventory_parts, counts.available + now.standing
        ),
        "feeder.capacity_parts": counts.belt,
        "robot.carrying_speed_m_s": carried.speed_m_s,
        "robot.carrying_acceleration_m_s2": carried.acceleration_m_s2,
    }
    if now.identity is not None:
        found["robot.model"] = now.identity.model
    if now.check is not None:
        found["tool.payload_kg"] = now.check.payload_kg
        found["tool.voltage_v"] = now.check.tool_voltage_v
    return found
