"""The arm's links as rows of spheres along their axes: what of it could touch something, or itself.

The radii hold the tubes and their joint housings, and the gaps between the
spheres' middles. All nominal.
"""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from cellctl.arm_form import FORE_ASIDE_M, LINK_LENGTHS, UPPER_ASIDE_M
from cellctl.assembling.obstacles import Obstacles
from cellctl.assembling.poses import Floats

LinkName = Literal["upper arm", "elbow", "forearm", "wrist"]

_OWN = frozenset({"the arm's own foot", "the pedestal"})
"""What the upper arm is fixed on; its shoulder is always near."""
_UPPER_SHARES = np.linspace(0.12, 1.0, 8)
_ELBOW_SHARES = np.linspace(0.0, 1.0, 3)
_FORE_SHARES = np.linspace(0.0, 1.0, 8)
_WRIST_SHARES = np.linspace(0.0, 1.0, 3)
_UPPER_RADIUS_M = 0.085
_FORE_RADIUS_M = 0.075
_WRIST_RADIUS_M = 0.062


class Links(NamedTuple):
    """Spheres along the links, for each of n joint positions."""

    centres: Floats
    """n x p x 3, metres in the base frame."""
    radii_m: Floats
    """p."""
    names: tuple[LinkName, ...]
    """p."""


class Nearest(NamedTuple):
    """The smallest gap between a link and something else, in metres; negative if they overlap."""

    gap_m: float
    link: str
    other: str


def links(joints_rad: Floats, model: Literal["ur10", "ur10e"]) -> Links:
    """Where the links are.

    Args:
        joints_rad: n x 6.
        model: which arm.
    """
    lengths = LINK_LENGTHS[model]
    turn, lift = joints_rad[:, 0], joints_rad[:, 1]
    bend = lift + joints_rad[:, 2]
    roll, tip = bend + joints_rad[:, 3], joints_rad[:, 4]
    zero = np.zeros_like(turn)
    ahead = np.stack([np.cos(turn), np.sin(turn), zero], axis=1)
    aside = np.stack([np.sin(turn), -np.cos(turn), zero], axis=1)
    up = np.array([0.0, 0.0, 1.0])

    def along(angle: Floats, length_m: float) -> Floats:
        # The links point the other way at angle 0: their lengths are negative in the DH table.
        way: Floats = -length_m * (np.cos(angle)[:, None] * ahead + np.sin(angle)[:, None] * up)
        return way

    shoulder = np.broadcast_to(lengths.d1 * up, ahead.shape)
    upper, fore = along(lift, lengths.upper_arm), along(bend, lengths.forearm)
    upper_aside, fore_aside = UPPER_ASIDE_M[model] * aside, FORE_ASIDE_M[model] * aside
    elbow, wrist = shoulder + upper, shoulder + upper + fore
    fifth = np.sin(roll)[:, None] * ahead - np.cos(roll)[:, None] * up
    level = np.cos(roll)[:, None] * ahead + np.sin(roll)[:, None] * up
    sixth = -np.sin(tip)[:, None] * level + np.cos(tip)[:, None] * aside
    first = wrist + lengths.d4 * aside
    second = first + lengths.d5 * fifth
    flange = second + lengths.d6 * sixth
    rows: list[tuple[LinkName, float, Floats]] = [
        ("upper arm", _UPPER_RADIUS_M, _row(shoulder + upper_aside, upper, _UPPER_SHARES)),
        (
            "elbow",
            _FORE_RADIUS_M,
            _row(elbow + fore_aside, upper_aside - fore_aside, _ELBOW_SHARES),
        ),
        ("forearm", _FORE_RADIUS_M, _row(elbow + fore_aside, fore, _FORE_SHARES)),
        (
            "wrist",
            _WRIST_RADIUS_M,
            _row(wrist + fore_aside, first - wrist - fore_aside, _WRIST_SHARES),
        ),
        ("wrist", _WRIST_RADIUS_M, _row(first, second - first, _WRIST_SHARES)),
        ("wrist", _WRIST_RADIUS_M, _row(second, 0.6 * (flange - second), _WRIST_SHARES)),
    ]
    names = [name for name, _, row in rows for _ in range(row.shape[1])]
    radii = [radius for _, radius, row in rows for _ in range(row.shape[1])]
    return Links(np.concatenate([row for *_, row in rows], axis=1), np.array(radii), tuple(names))


def gaps_m(arm: Links, group: Obstacles) -> Floats:
    """Gap between each sphere and each box: n x p x boxes, negative where they overlap; infinite
    between what is joined to each other."""
    frame = group.frame_from_base
    centres = arm.centres @ frame[:3, :3].T + frame[:3, 3]
    every = np.arange(len(arm.names)), np.arange(len(group.names))
    return _gaps_m(arm, group, centres, *every)


def nearest(arm: Links, groups: tuple[Obstacles, ...], within_m: float) -> Nearest:
    """The smallest gap between any link and any obstacle, of those within a distance."""
    found = Nearest(math.inf, "", "")
    reach_m = (arm.radii_m + within_m)[:, None]
    for group in groups:
        frame = group.frame_from_base
        centres = arm.centres @ frame[:3, :3].T + frame[:3, 3]
        # What each sphere sweeps, as a box: only boxes that meet that can be so near to it.
        low, high = centres.min(axis=0) - reach_m, centres.max(axis=0) + reach_m
        near = ((group.high > low[:, None]) & (group.low < high[:, None])).all(axis=2)
        spheres, boxes = np.flatnonzero(near.any(axis=1)), np.flatnonzero(near.any(axis=0))
        if boxes.size == 0:
            continue
        gaps = _gaps_m(arm, group, centres, spheres, boxes)
        _, sphere, box = np.unravel_index(int(np.argmin(gaps)), gaps.shape)
        gap_m = float(gaps.min())
        if gap_m < found.gap_m:
            found = Nearest(gap_m, arm.names[spheres[sphere]], group.names[boxes[box]])
    return found


def _gaps_m(
    arm: Links,
    group: Obstacles,
    centres: Floats,
    spheres: npt.NDArray[np.intp],
    boxes: npt.NDArray[np.intp],
) -> Floats:
    low, high = group.low[boxes], group.high[boxes]
    points = centres[:, spheres, None, :]
    outside = np.maximum(np.maximum(low - points, points - high), 0.0)
    gaps: Floats = np.sqrt(np.einsum("npbk,npbk->npb", outside, outside))
    gaps -= arm.radii_m[None, spheres, None]
    own = [i for i, box in enumerate(boxes) if group.names[box] in _OWN]
    if own:
        joined = [i for i, sphere in enumerate(spheres) if arm.names[sphere] == "upper arm"]
        gaps[np.ix_(range(len(gaps)), joined, own)] = np.inf
    return gaps


def own_gap_m(arm: Links, tool: Floats, radius_m: float) -> float:
    """Smallest gap between what hangs from the flange and the upper arm, elbow or forearm.

    Args:
        arm: the links.
        tool: n x q x 3 points along what hangs there.
        radius_m: how thick it is.
    """
    away = [i for i, name in enumerate(arm.names) if name != "wrist"]
    between = arm.centres[:, away, None, :] - tool[:, None, :, :]
    distance = np.sqrt(np.einsum("npqk,npqk->npq", between, between))
    return float((distance - arm.radii_m[None, away, None]).min()) - radius_m


def _row(start: Floats, way: Floats, shares: Floats) -> Floats:
    points: Floats = start[:, None, :] + shares[None, :, None] * way[:, None, :]
    return points
