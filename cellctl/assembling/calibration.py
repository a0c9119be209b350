"""Where things are, by least squares from places that were touched. Pure arithmetic."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from cellctl.assembling.poses import Floats, Matrix, distance, to_pose
from cellctl.errors import UsageError

_FLAT_M = 0.02
"""Points that are nearer to one line than this do not tell a turn about it."""
_TILTED_RAD = math.radians(8.0)
"""Two flanges that are turned by less against each other tell little of the tool."""


class Fit(NamedTuple):
    """A rigid transform, and how far each point is off it."""

    matrix: Matrix
    residuals_m: tuple[float, ...]

    @property
    def rms_m(self) -> float:
        """The root of their mean square."""
        return math.sqrt(sum(one * one for one in self.residuals_m) / len(self.residuals_m))


class Tip(NamedTuple):
    """The tip of a tool, and how far each touch is off it."""

    in_flange_m: Floats
    """(3,)."""
    residuals_m: tuple[float, ...]


def rigid(known_m: Sequence[Sequence[float]], seen_m: Sequence[Sequence[float]]) -> Fit:
    """The transform that takes known points to where they were seen (Kabsch's method).

    Args:
        known_m: n x 3, n at least 3, in the frame that is looked for.
        seen_m: n x 3, in the frame that it is looked for in.

    Raises:
        UsageError: the points are too few, or all near one line.
    """
    known, seen = np.array(known_m, dtype=np.float64), np.array(seen_m, dtype=np.float64)
    if len(known) < 3:
        raise UsageError("A frame needs three points at least.", "Touch more of them.")
    middle, seen_middle = known.mean(axis=0), seen.mean(axis=0)
    spread = np.linalg.svd(known - middle, compute_uv=False)
    if spread[1] / math.sqrt(len(known)) < _FLAT_M:
        raise UsageError("The points lie on one line.", "Touch some beside it, too.")
    left, _, right = np.linalg.svd((known - middle).T @ (seen - seen_middle))
    # Three points in a plane fit their mirror image as well.
    sign = 1.0 if np.linalg.det(left @ right) > 0.0 else -1.0
    turn = right.T @ np.diag([1.0, 1.0, sign]) @ left.T
    matrix = np.eye(4)
    matrix[:3, :3] = turn
    matrix[:3, 3] = seen_middle - turn @ middle
    off = known @ turn.T + matrix[:3, 3] - seen
    return Fit(matrix, tuple(float(one) for one in np.linalg.norm(off, axis=1)))


def tip(flanges: Sequence[Matrix]) -> Tip:
    """The one place in the flange frame that was at the same point each time.

    Args:
        flanges: 4x4 poses in the base frame, n at least 4, turned against each other.

    Raises:
        UsageError: they are too few, or too much alike.
    """
    if len(flanges) < 4:
        raise UsageError("A tool needs four touches at least.", "Touch the point more often.")
    poses = [to_pose(flange) for flange in flanges]
    turned = [distance(one, two)[1] for one in poses for two in poses]
    if max(turned) < _TILTED_RAD:
        raise UsageError(
            "The tool was touched with from one side only.", "Tilt it by 15 degrees and more."
        )
    rows = np.concatenate([np.hstack([flange[:3, :3], -np.eye(3)]) for flange in flanges])
    wanted = -np.concatenate([flange[:3, 3] for flange in flanges])
    found, _, rank, _ = np.linalg.lstsq(rows, wanted, rcond=1e-4)
    if rank < 6:
        raise UsageError(
            "The touches do not tell how long the tool is.", "Tilt it to two sides, not to one."
        )
    off = (rows @ found - wanted).reshape(-1, 3)
    residuals = tuple(float(one) for one in np.linalg.norm(off, axis=1))
    return Tip(np.asarray(found[:3]), residuals)
