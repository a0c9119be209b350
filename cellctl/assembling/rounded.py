"""A row of corners joined by straight legs, rounded by arcs, in any number of dimensions.

A blend of radius r leaves one leg at r before the corner and joins the next at r after it, on an
arc. UR does not publish its blends; this is the shape that its documents draw. Positions of the TCP
have three dimensions, in metres; joint positions have six, in radians.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from cellctl.assembling.poses import Floats

_STRAIGHT_RAD = 1e-3
_REVERSAL_RAD = math.pi - 1e-2
_ARC_STEPS = 8
"""At a right angle, chords of this many steps stay within 0.5 % of the arc's radius of it."""
_ARC_SHARES = np.linspace(0.0, 1.0, _ARC_STEPS + 1)
_LINE_STEPS = 4


@cache
def even(count: int) -> Floats:
    """So many even shares from 0 to 1; shared, hence not to be written to."""
    shares = np.linspace(0.0, 1.0, count)
    shares.flags.writeable = False
    return shares


class Piece(NamedTuple):
    """A stretch of a path: the straight part of a leg, or the arc at its end."""

    leg: int
    """The leg, or the one before the arc."""
    arc: bool
    length: float
    radius: float
    """Of an arc; infinite where the path goes straight on."""
    values: Floats
    """n x d samples from its start to its end, evenly spaced."""
    shares: Floats
    """n: where they are, as the leg's number and the share of it that is behind."""


def pieces(corners: Floats, blends: Sequence[float], spacing: float) -> tuple[Piece, ...]:
    """Straight parts and arcs in turn, as many straight parts as legs.

    Args:
        corners: k x d, from the start to the end.
        blends: radius at each corner but the two ends; 0 for none.
        spacing: greatest distance between two samples of a straight part.
    """
    ways = np.diff(corners, axis=0)
    lengths = np.sqrt((ways**2).sum(axis=1))
    radii = [0.0, *blends, 0.0]
    for i in range(1, len(corners) - 1):
        if turn_rad(corners[i - 1], corners[i], corners[i + 1]) > _REVERSAL_RAD:
            radii[i] = 0.0
    found: list[Piece] = []
    for leg, (way, length) in enumerate(zip(ways, lengths.tolist(), strict=True)):
        first = radii[leg] / length if length > 0.0 else 0.0
        last = max(first, 1.0 - radii[leg + 1] / length if length > 0.0 else 1.0)
        straight = length * (last - first)
        count = max(_LINE_STEPS, math.ceil(straight / spacing)) + 1
        shares = first + (last - first) * even(count)
        values = corners[leg] + shares[:, None] * way
        found.append(Piece(leg, False, straight, math.inf, values, leg + shares))
        if radii[leg + 1] > 0.0:
            directions = (way / length, ways[leg + 1] / lengths[leg + 1])
            found.append(_arc(leg, corners[leg + 1], directions, lengths, radii[leg + 1]))
    return tuple(found)


def turn_rad(before: Floats, corner: Floats, after: Floats) -> float:
    """Change of direction at a corner: 0 goes straight on (or nowhere), pi turns back."""
    arriving, leaving = corner - before, after - corner
    lengths = math.sqrt(float(arriving @ arriving) * float(leaving @ leaving))
    if lengths < 1e-12:
        return 0.0
    return math.acos(max(-1.0, min(1.0, float(arriving @ leaving) / lengths)))


def _arc(
    leg: int, corner: Floats, directions: tuple[Floats, Floats], lengths: Floats, blend: float
) -> Piece:
    one, other = directions
    turn = math.acos(max(-1.0, min(1.0, float(one @ other))))
    steps = _ARC_SHARES
    back = leg + 1.0 - blend / lengths[leg] * (1.0 - 2.0 * steps)
    on = leg + 1.0 + blend / lengths[leg + 1] * (2.0 * steps - 1.0)
    shares = np.where(steps < 0.5, back, on)
    if turn < _STRAIGHT_RAD:
        values = corner + one * ((2.0 * steps - 1.0) * blend)[:, None]
        return Piece(leg, True, 2.0 * blend, math.inf, values, shares)
    radius = blend / math.tan(turn / 2.0)
    inward = other - one * math.cos(turn)
    inward /= math.sqrt(float(inward @ inward))
    angles = (turn * steps)[:, None]
    values = corner - one * blend + radius * (np.sin(angles) * one + (1 - np.cos(angles)) * inward)
    return Piece(leg, True, radius * turn, radius, values, shares)
