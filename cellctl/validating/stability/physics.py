"""What holds the parts of a structure together, and what a placement does to them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from cellctl.config import CellConfig
from cellctl.errors import PlanError

GRAVITY_M_S2 = 9.80665


@dataclass(frozen=True, slots=True)
class Physics:
    """The numbers that decide whether a structure stands; see ``[stability]`` in cell.toml."""

    mass_kg: float
    """Of one part."""
    pitch_m: float
    """Edge of a cell."""
    magnet_force_n: float
    """Pull that one joint of two faces holds, straight apart."""
    friction: float
    """Coefficient between two faces, and between a part and the floor."""
    contact: Literal["diamond", "square"]
    """Where two faces touch: a square that stands on its corner, or the whole face."""
    floor_grips: bool
    """Whether the floor holds a part like another part does, or only carries it."""
    placement_down_n: float
    """How hard a part is pressed down when it is placed."""
    placement_side_n: float
    """How hard a part that is set on another one, or on the floor, is pushed aside meanwhile."""
    least_margin: float
    """How many times what a step asks of them the joints must bear."""

    @classmethod
    def of(cls, config: CellConfig) -> Physics:
        """As the cell is configured.

        No step of a plan turns its part about the vertical, so all stand with the same yaw. Then
        each side face meets the opposite one of its neighbour: every joint attracts, genderless
        or directed. Directed faces that look the same after a turn by less than a full circle
        would meet their like, and repel.

        Raises:
            PlanError: the configured parts repel each other.
        """
        stability = config.stability
        if stability.polarity == "directed" and stability.yaw_symmetry_deg != 360:
            raise PlanError(
                'stability.polarity = "directed" does not go with stability.yaw_symmetry_deg = '
                f"{stability.yaw_symmetry_deg}: opposite side faces of such a part are alike, so "
                "two parts side by side repel each other.",
                "Set yaw_symmetry_deg to 360, or polarity to genderless.",
            )
        return cls(
            mass_kg=config.voxel.mass_kg,
            pitch_m=config.voxel.pitch_m,
            magnet_force_n=stability.magnet_force_n,
            friction=stability.friction,
            contact=stability.contact,
            floor_grips=stability.floor == "grips",
            placement_down_n=stability.placement_down_n,
            placement_side_n=stability.placement_side_n,
            least_margin=stability.least_margin,
        )

    @property
    def weight_n(self) -> float:
        """Of one part."""
        return self.mass_kg * GRAVITY_M_S2
