"""A row of corners joined by straight lines, rounded by circular arcs, in any number of dimensions.

An arc of blend radius r touches both lines at the distance r from the corner, so it leaves the
corner's neighbourhood untouched and its own radius is ``r / tan(turn / 2)``. At a right angle it
passes the corner at 0.41 r.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cellctl.sim.plant import Floats

_STRAIGHT_RAD = 1e-6
_REVERSAL_RAD = math.pi - 1e-3
_TINY = 1e-9


@dataclass(frozen=True)
class Line:
    """The straight part of leg ``leg``, the way from one corner to the next."""

    leg: int
    start: Floats
    direction: Floats
    length: float
    offset: float
    """Distance of ``start`` from the leg's first corner."""

    def point(self, distance: float) -> Floats:
        """Where it is after a distance."""
        return self.start + self.direction * distance


@dataclass(frozen=True)
class Arc:
    """The rounded corner between leg ``leg`` and the next."""

    leg: int
    centre: Floats
    out: Floats
    """Unit vector from the centre to the arc's start."""
    ahead: Floats
    """Unit vector of the direction at the arc's start."""
    radius: float
    length: float
    blend: float
    """Distance of the arc's ends from the corner."""

    def point(self, distance: float) -> Floats:
        """Where it is after a distance."""
        angle = distance / self.radius
        return self.centre + self.radius * (
            math.cos(angle) * self.out + math.sin(angle) * self.ahead
        )


@dataclass(frozen=True)
class Through:
    """A corner at which the path goes straight on, between leg ``leg`` and the next."""

    leg: int
    start: Floats
    direction: Floats
    length: float
    blend: float
    radius: float = math.inf

    def point(self, distance: float) -> Floats:
        """Where it is after a distance."""
        return self.start + self.direction * distance


Piece = Line | Arc | Through


def turn_rad(before: Floats, corner: Floats, after: Floats) -> float:
    """Change of direction at a corner; 0 goes straight on, pi turns back."""
    one, two = corner - before, after - corner
    cosine = float(one @ two) / (float(np.linalg.norm(one)) * float(np.linalg.norm(two)))
    return math.acos(max(-1.0, min(1.0, cosine)))


def can_blend(before: Floats, corner: Floats, after: Floats) -> bool:
    """Whether a corner can be rounded: both legs have a length, and the path does not turn back."""
    if min(np.linalg.norm(corner - before), np.linalg.norm(after - corner)) < _TINY:
        return False
    return turn_rad(before, corner, after) < _REVERSAL_RAD


def build_pieces(corners: Sequence[Floats], blends: Sequence[float]) -> list[Piece]:
    """Lines and arcs through the corners.

    Args:
        corners: first to last, at least two.
        blends: distance from each corner at which its arc begins and ends; 0 for none. Neighbours
            must not overlap, and ``can_blend`` must hold where it is not 0.
    """
    pieces: list[Piece] = []
    for leg in range(len(corners) - 1):
        start, end = corners[leg], corners[leg + 1]
        length = float(np.linalg.norm(end - start))
        direction = (end - start) / length if length > _TINY else np.zeros_like(start)
        straight = max(0.0, length - blends[leg] - blends[leg + 1])
        pieces.append(Line(leg, start + direction * blends[leg], direction, straight, blends[leg]))
        if blends[leg + 1] > 0.0:
            after = corners[leg + 2]
            pieces.append(_round(leg, direction, end, after, blends[leg + 1]))
    return pieces


def _round(
    leg: int, direction: Floats, corner: Floats, after: Floats, blend: float
) -> Arc | Through:
    onward = (after - corner) / float(np.linalg.norm(after - corner))
    turn = turn_rad(corner - direction, corner, after)
    start = corner - direction * blend
    if turn < _STRAIGHT_RAD:
        return Through(leg, start, direction, 2.0 * blend, blend)
    inward = onward - direction * math.cos(turn)
    inward = inward / float(np.linalg.norm(inward))
    radius = blend / math.tan(turn / 2.0)
    return Arc(
        leg=leg,
        centre=start + inward * radius,
        out=-inward,
        ahead=direction,
        radius=radius,
        length=radius * turn,
        blend=blend,
    )
