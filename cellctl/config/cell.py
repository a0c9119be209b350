"""All tables together, and what must fit between them."""

from __future__ import annotations

import hashlib
from typing import Self

from pydantic import model_validator

from cellctl.config.dialogue import DialogueSection
from cellctl.config.generating import GeneratingSection
from cellctl.config.kiosk import KioskSection
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
    WallsSection,
    WorkspaceSection,
)
from cellctl.config.section import Section
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


class CellConfig(Section):
    """Everything that cellctl knows about one cell."""

    cell: CellSection
    workspace: WorkspaceSection
    base: BaseSection
    pedestal: PedestalSection
    walls: WallsSection = WallsSection()
    tool: ToolSection
    voxel: VoxelSection
    limits: LimitsSection
    stability: StabilitySection = StabilitySection()
    robot: RobotSection
    gripper: GripperSection
    feeder: FeederSection
    hearing: HearingSection = HearingSection()
    understanding: UnderstandingSection = UnderstandingSection()
    dialogue: DialogueSection = DialogueSection()
    voice: VoiceSection = VoiceSection()
    generating: GeneratingSection = GeneratingSection()
    planning: PlanningSection = PlanningSection()
    bus: BusSection = BusSection()
    kiosk: KioskSection = KioskSection()
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
        asks = self.understanding.model_url and self.understanding.model_name
        if "model" in self.generating.chain and not asks:
            raise ValueError(
                'generating.chain has "model": say which in understanding.model_url and model_name'
            )
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
