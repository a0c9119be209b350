"""What a joint must pull to bear given forces."""

from __future__ import annotations

import numpy as np

from cellctl.validating.stability.joints import Bools, Floats, Ints
from cellctl.validating.stability.physics import Physics

_ROUNDING = 1e-7
"""Share of the magnets' force below which an overload is rounding of the solver."""


def needed_pull(wrenches: Floats, axis: Ints, bare: Bools, physics: Physics) -> Floats:
    """The least ``lambda`` with which joints bear wrenches: the conditions of the programme.

    Args:
        wrenches: (..., m, 6), force in N and moment in N m about the centre of the faces, by the
            lower part on the upper one.
        axis: of each joint, (m,).
        bare: whether a joint has no magnets, (m,): one with a floor that does not grip.
        physics: what holds them.

    Returns:
        (..., m), at least 0; infinite where no pull is enough.
    """
    index = np.arange(len(axis))
    u, v = (axis + 1) % 3, (axis + 2) % 3
    press = wrenches[..., index, axis]
    lever_m = physics.pitch_m / 2
    first = np.abs(wrenches[..., index, 3 + u]) / lever_m
    second = np.abs(wrenches[..., index, 3 + v]) / lever_m
    tilt = first + second if physics.contact == "diamond" else np.maximum(first, second)
    slide = (
        np.abs(wrenches[..., index, u])
        + np.abs(wrenches[..., index, v])
        + np.abs(wrenches[..., index, 3 + axis]) / lever_m
    )
    rounding_n = _ROUNDING * physics.magnet_force_n
    if physics.friction > 0.0:
        held = slide / physics.friction
    else:
        held = np.where(slide > rounding_n, np.inf, 0.0)
    lacking = np.maximum(np.maximum(tilt, held) - press, 0.0)
    lacking = np.where(lacking <= rounding_n, 0.0, lacking)
    share: Floats = lacking / physics.magnet_force_n
    return np.where(bare & (share > 0.0), np.inf, share)
