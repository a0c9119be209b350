"""Ways across, drawn tight over the heights that they must have."""

from __future__ import annotations

import numpy as np
import pytest

from cellctl.assembling.crossing import profile
from cellctl.assembling.poses import Floats

_COUNT = 33


def heights(shares: Floats, corners: list[tuple[float, float]]) -> Floats:
    """Of the straight way from corner to corner."""
    at, high = np.array(corners).T
    found: Floats = np.interp(shares, at, high)
    return found


def test_a_way_stays_above_all_wishes_however_closely_they_follow_each_other() -> None:
    shares = np.linspace(0.0, 1.0, _COUNT)
    wanted_m = np.where(shares > 0.68, 0.43, 0.33)
    corners = profile(wanted_m, 0.362, 0.43, np.zeros(_COUNT))
    heights_m = heights(shares, corners)
    assert (heights_m >= wanted_m - 0.004).all()
    assert corners == [(0.0, 0.362), (pytest.approx(22 / 32), 0.43), (1.0, 0.43)]


def test_a_way_has_few_corners_whatever_it_passes() -> None:
    rng = np.random.default_rng(5)
    shares = np.linspace(0.0, 1.0, _COUNT)
    for _ in range(300):
        wanted_m = rng.uniform(0.1, 0.6, _COUNT)
        bulge_m = 0.05 * shares * (1.0 - shares)
        corners = profile(wanted_m.copy(), 0.3, 0.2, bulge_m)
        heights_m = heights(shares, corners) + bulge_m
        assert len(corners) <= 4
        assert (heights_m >= wanted_m - 0.004 - 1e-9).all()
        assert corners[0][1] >= 0.3
        assert corners[-1][1] >= 0.2
