"""cell.toml -> validated settings.

One model describes a cell, real or emulated; the units stand in the names. Every refusal names the
file, the key, what is wrong with it and the nearest name that would be right.

All frames are poses in the *cell frame*: right-handed, z up, origin on the floor. A pose is
``[x_m, y_m, z_m, rx_rad, ry_rad, rz_rad]`` with a rotation vector, as the robot's pendant shows it.
"""

from __future__ import annotations

from cellctl.config.cell import CellConfig
from cellctl.config.dialogue import DialogueSection
from cellctl.config.generating import GeneratingSection, GeneratorName
from cellctl.config.kiosk import KioskSection
from cellctl.config.loading import (
    DEFAULT_PATH,
    ENVIRONMENT_VARIABLE,
    find_config,
    load_config,
    parse_config,
    unit_of,
)
from cellctl.config.machines import (
    FeederSection,
    GripperSection,
    RobotSection,
)
from cellctl.config.place import (
    BaseSection,
    CellSection,
    LimitsSection,
    PedestalSection,
    StabilitySection,
    ToolSection,
    VoxelSection,
    WorkspaceSection,
)
from cellctl.config.section import Joints, Pose, Section, Vector
from cellctl.config.services import (
    BusSection,
    EmulationSection,
    HearingSection,
    JournalSection,
    PlanningSection,
    PolicySection,
    VoiceSection,
)
from cellctl.config.understanding import UnderstandingSection

__all__ = [
    "DEFAULT_PATH",
    "ENVIRONMENT_VARIABLE",
    "BaseSection",
    "BusSection",
    "CellConfig",
    "CellSection",
    "DialogueSection",
    "EmulationSection",
    "FeederSection",
    "GeneratingSection",
    "GeneratorName",
    "GripperSection",
    "HearingSection",
    "Joints",
    "JournalSection",
    "KioskSection",
    "LimitsSection",
    "PedestalSection",
    "PlanningSection",
    "PolicySection",
    "Pose",
    "RobotSection",
    "Section",
    "StabilitySection",
    "ToolSection",
    "UnderstandingSection",
    "Vector",
    "VoiceSection",
    "VoxelSection",
    "WorkspaceSection",
    "find_config",
    "load_config",
    "parse_config",
    "unit_of",
]
