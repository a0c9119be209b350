"""What the latch can take hold of, and where a part stays that it lets go."""

from __future__ import annotations

import math
from collections.abc import Set as AbstractSet
from typing import NamedTuple

import numpy as np

from cellctl.assembly import Cell
from cellctl.sim.plant import Floats
from cellctl.sim.world_support import supported
from cellctl.sim.world_values import ViolationKind

LATERAL_TOLERANCE_M = 0.008
"""A latch centres a part, and a magnetic face a voxel, that is off sideways by at most this."""
HEIGHT_TOLERANCE_M = 0.006
"""The same in height: a part may be let go this far above its seat."""
ANGLE_TOLERANCE_RAD = math.radians(4.0)
"""The same for tilt, and for yaw modulo a quarter turn."""


class Release(NamedTuple):
    """What becomes of a part that was let go: it stays at its cell, or something is wrong."""

    cell: Cell
    wrong: ViolationKind | None
    message: str


def fits(top: Floats) -> bool:
    """Whether the latch can take a part whose top face has this pose in the TCP frame."""
    x_m, y_m, z_m = top[:3, 3].tolist()
    return (
        math.hypot(x_m, y_m) <= LATERAL_TOLERANCE_M
        and abs(z_m) <= HEIGHT_TOLERANCE_M
        and square(top[:3, :3])
    )


def square(turn: Floats) -> bool:
    """Whether a rotation turns z straight over and x by quarters, within the tolerance."""
    tilt_rad = math.acos(max(-1.0, min(1.0, -float(turn[2, 2]))))
    quarter = math.pi / 2
    yaw_rad = math.atan2(turn[1, 0], turn[0, 0])
    yaw_rad -= quarter * round(yaw_rad / quarter)
    return tilt_rad <= ANGLE_TOLERANCE_RAD and abs(yaw_rad) <= ANGLE_TOLERANCE_RAD


def judge_release(
    tcp: Floats, placed: AbstractSet[Cell], grid: tuple[int, int, int], pitch_m: float
) -> Release:
    """What becomes of the part that hangs under the TCP when the latch lets it go.

    Args:
        tcp: 4x4 pose of the TCP in the workspace frame.
    """
    centre = tcp[:3, 3] + tcp[:3, 2] * (pitch_m / 2)
    cell = Cell(*(math.floor(value / pitch_m) for value in centre.tolist()))
    x_m, y_m, above_m = (centre - (np.array(cell) + 0.5) * pitch_m).tolist()
    aside_m = math.hypot(x_m, y_m)
    where = f"cell {tuple(cell)}"
    if not all(0 <= index < count for index, count in zip(cell, grid, strict=True)):
        return Release(cell, ViolationKind.RELEASED_OUTSIDE, f"A part was let go at {where}.")
    # Below its seat with nothing solid under it, the part hangs above the cell below.
    pressed_in = above_m < -HEIGHT_TOLERANCE_M and supported(cell, placed)
    if abs(above_m) > HEIGHT_TOLERANCE_M and not pressed_in:
        message = f"A part was let go {above_m * 1e3:+.1f} mm off the height of {where}."
        return Release(cell, ViolationKind.RELEASED_IN_MID_AIR, message)
    upright = square(tcp[:3, :3])
    if pressed_in or aside_m > LATERAL_TOLERANCE_M or not upright:
        message = (
            f"A part was let go {aside_m * 1e3:.1f} mm beside and {above_m * 1e3:+.1f} mm above "
            f"{where}, {'square to it' if upright else 'tilted or yawed'}."
        )
        return Release(cell, ViolationKind.RELEASED_MISALIGNED, message)
    if cell in placed:
        message = f"A part was let go in {where}, where another part is."
        return Release(cell, ViolationKind.RELEASED_INTO_PART, message)
    if cell.z > 0 and not any(near in placed for near in cell.neighbours()):
        message = f"A part was let go at {where}, where it touches nothing."
        return Release(cell, ViolationKind.RELEASED_UNSUPPORTED, message)
    return Release(cell, None, "")
