"""How high a part must be carried: the lowest way across that keeps clear of what stands.

The way across goes from above where the arm is to above where it goes; the joints go straight, and
the TCP's height all but evenly from the one to the other. What it passes asks for a height at a
share of the way; of all pairs of heights that grant every such wish, the one with the least way up
and down is taken.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cellctl.assembling.obstacles import TOUCH_M, Body, Obstacles
from cellctl.assembling.poses import Floats, Matrix, inverse

_CHOICES = 16
_HIGHER_M = 0.15
"""A way that begins this much higher than it must may end lower in return."""


class Wishes(NamedTuple):
    """Heights of the TCP above the floor that a way across must have, at even shares of it."""

    strict_m: Floats
    """With what stands right beside the place where it begins."""
    leaving_m: Floats
    """Without what it only leads away from."""


def wishes(
    groups: Sequence[Obstacles],
    bodies: Sequence[Body],
    points: Floats,
    rotations: Floats,
    *,
    clearance_m: float,
    cell_from_base: Matrix,
) -> Wishes:
    """What the obstacles on the way ask for.

    Args:
        groups: the obstacles.
        bodies: what moves.
        points: n x 3 positions of the TCP in the base frame, evenly spaced along the way.
        rotations: n x 3 x 3 orientations there, the tool's axis straight down.
        clearance_m: between what moves and what it passes, sideways too.
        cell_from_base: to measure heights.
    """
    strict, leaving = np.zeros(len(points)), np.zeros(len(points))
    for group in groups:
        top_from_frame = cell_from_base @ inverse(group.frame_from_base)
        tops_m = top_from_frame[2, 3] + group.high[:, 2]
        for body in bodies:
            apart_m = group.sideways_all_m(body, points, rotations)
            near = apart_m < clearance_m
            # What stands beside the place where it begins, and that it only leads away from, need
            # not be passed over: some clearance upward frees the faces that touched.
            left = near[0] & ~(apart_m < -TOUCH_M).any(axis=0)
            left &= (np.diff(apart_m, axis=0) > -TOUCH_M / len(points)).all(axis=0)
            wanted = np.where(near, tops_m + clearance_m + body.high[2], 0.0)
            strict = np.maximum(strict, wanted.max(axis=1, initial=0.0))
            leaving = np.maximum(leaving, wanted[:, ~left].max(axis=1, initial=0.0))
    return Wishes(strict, leaving)


def heights_m(
    wanted_m: Floats, start_m: float, end_m: float, bulge_m: Floats
) -> tuple[float, float]:
    """Heights of the TCP at which the way across begins and ends.

    Args:
        wanted_m: least heights at even shares of the way.
        start_m: height from which the arm comes; it begins no lower.
        end_m: height to which it goes; it ends no lower.
        bulge_m: how much higher the way is at each share than an even one.
    """
    share = np.linspace(0.0, 1.0, len(wanted_m))[1:-1]
    need = (wanted_m - bulge_m)[1:-1]
    from_m = max(start_m, float(wanted_m[0]))
    to_m = max(end_m, float(wanted_m[-1]))
    highest_m = max(from_m, float(need.max(initial=from_m))) + _HIGHER_M
    firsts = np.linspace(from_m, highest_m, _CHOICES)
    asked = (need - (1.0 - share) * firsts[:, None]) / share
    lasts = np.maximum(to_m, asked.max(axis=1, initial=to_m))
    best = int(np.argmin(firsts + lasts))
    return float(firsts[best]), float(lasts[best])
