"""A path for tests: fast, through free space, with a blended corner."""

from __future__ import annotations

from cellctl.assembling.arm import Waypoint
from cellctl.config import Pose

SPEED_M_S = 0.8
ACCELERATION_M_S2 = 4.0


def away_from(start: Pose) -> tuple[Waypoint, ...]:
    """From the home of ``config/sim.toml``: up and over the workspace, 1.0 m in all."""
    x, y, z, *turn = start
    corners = [(x, y, z + 0.1), (x + 0.9, y + 0.1, z + 0.1)]
    return tuple(
        Waypoint(
            pose=(*corner, turn[0], turn[1], turn[2]),
            speed_m_s=SPEED_M_S,
            acceleration_m_s2=ACCELERATION_M_S2,
            blend_radius_m=0.03 if i == 0 else 0.0,
        )
        for i, corner in enumerate(corners)
    )
