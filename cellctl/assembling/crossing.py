"""How high a part must be carried: the lowest way across that keeps clear of what stands.

The way across goes from above where the arm is to above where it goes; the joints go straight, and
the TCP's height all but evenly from corner to corner. What it passes asks for a height at a share
of the way; the way is drawn tight over all such wishes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cellctl.assembling.obstacles import TOUCH_M, Body, Obstacles
from cellctl.assembling.poses import Floats, Matrix, inverse

_CORNERS = 2
"""More of them would only slow the arm down."""
_TINY_M = 1e-9
_STRAIGHT_M = 0.004
"""A corner this little above the straight way is none: the way is checked as it is."""


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
    strict, leaving = np.zeros((2, len(points)))
    for group in groups:
        top_from_frame = cell_from_base @ inverse(group.frame_from_base)
        tops_m = top_from_frame[2, 3] + group.high[:, 2]
        for body in bodies:
            apart_m = group.sideways_all_m(body, points, rotations)
            near = apart_m < clearance_m
            # What stands beside the place where it begins, and that it only leads away from, need
            # not be passed over: some clearance upward frees the faces that touched. What stands
            # beside the place where it ends is passed over: nothing would feel a push at its side.
            beside = ~(apart_m < -TOUCH_M).any(axis=0)
            growing_m = np.diff(apart_m, axis=0)
            most_m = TOUCH_M / len(points)
            left = near[0] & beside & (growing_m > -most_m).all(axis=0)
            wanted = np.where(near, tops_m + clearance_m + body.high[2], 0.0)
            strict = np.maximum(strict, wanted.max(axis=1, initial=0.0))
            leaving = np.maximum(leaving, wanted[:, ~left].max(axis=1, initial=0.0))
    return Wishes(strict, leaving)


def sloped(wanted_m: Floats, slope_m: Floats, level_m: float) -> Floats:
    """The same wishes near an end of the way, where a slope is enough for what is no higher than
    the part there.

    Args:
        wanted_m: least heights at even shares of the way.
        slope_m: heights that are enough.
        level_m: wishes that are higher stay.
    """
    enough: Floats = np.where(wanted_m <= level_m + _TINY_M, slope_m, np.inf)
    return np.minimum(wanted_m, enough)


def profile(
    wanted_m: Floats, start_m: float, end_m: float, bulge_m: Floats
) -> list[tuple[float, float]]:
    """The lowest way across that never turns upward: like a string that is drawn tight over what
    the heights must not be less than.

    Args:
        wanted_m: least heights at even shares of the way.
        start_m: height from which the arm comes; it begins no lower.
        end_m: height to which it goes; it ends no lower.
        bulge_m: how much higher than even the way is at each share.

    Returns:
        Shares of the way and heights, from (0, ...) to (1, ...), at most ``_CORNERS`` between them.
    """
    heights = wanted_m - bulge_m
    heights[0], heights[-1] = max(start_m, wanted_m[0]), max(end_m, wanted_m[-1])
    shares = np.linspace(0.0, 1.0, len(heights))
    # The string never hangs below the straight way from end to end.
    kept = heights > heights[0] + shares * (heights[-1] - heights[0])
    kept[0] = kept[-1] = True
    shares = shares[kept]
    hull: list[tuple[float, float]] = []
    for x, y in zip(shares.tolist(), heights[kept].tolist(), strict=True):
        while len(hull) >= 2 and _above_m(hull[-2], hull[-1], (x, y)) <= _TINY_M:
            hull.pop()
        hull.append((x, y))
    return _few(hull)


def _few(hull: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Without corners that the way all but has where it goes straight; two more may stay, or one
    that is above them all."""
    kept = list(hull)
    while len(kept) > 2:
        lowest = min(range(1, len(kept) - 1), key=lambda i: _above_m(*kept[i - 1 : i + 2]))
        first, last = kept[lowest - 1], kept[lowest + 1]
        cut = [point for point in hull if first[0] < point[0] < last[0]]
        if max(_above_m(first, point, last) for point in cut) > _STRAIGHT_M:
            break
        del kept[lowest]
    return kept if len(kept) <= _CORNERS + 2 else [kept[0], _meet(kept), kept[-1]]


def _above_m(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """How far b is above the straight way from a to c; negative below."""
    return b[1] - a[1] - (c[1] - a[1]) * (b[0] - a[0]) / (c[0] - a[0])


def _meet(hull: list[tuple[float, float]]) -> tuple[float, float]:
    """Where the first and the last edge would meet; all corners between them are below that."""
    (x0, y0), (x1, y1), (x2, y2), (x3, y3) = hull[0], hull[1], hull[-2], hull[-1]
    up, down = (y1 - y0) / (x1 - x0), (y3 - y2) / (x3 - x2)
    x = (y3 - y0 + up * x0 - down * x3) / (up - down)
    return x, y0 + up * (x - x0)
