"""Collisions of the arm's links: upper arm, elbow, forearm and wrist, as tubes about their axes.

The arm is judged at least each 30 mm of its fastest point's way, and more finely between two such
places wherever a link comes near something. Lengths: Universal Robots, "DH Parameters"; how far the
tubes run beside the axes, and how thick they are: the makers' drawings, rounded down, so that a
collision is one for certain.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np

from cellctl.sim.plant import Floats
from cellctl.sim.world_contact import Contact
from cellctl.sim.world_geometry import Box, Triple

SWEEP_STEP_M = 0.03
"""No point of a link moves farther between two places at which the arm is judged..."""
FINE_STEP_M = 0.003
"""...and no farther than this where it is near something."""
DEPTH_M = 0.002
"""How deep a tube may be in something before it counts as a collision."""
_REACH_M = 1.5
"""No point of a link is farther from any joint's axis."""
_SPACING_M = 0.02
"""Between the points of an axis at which distances are taken."""


class _Lengths(NamedTuple):
    upper_m: float
    fore_m: float
    shoulder_m: float
    wrist_m: tuple[float, float, float]
    """Along the axes of the last three joints."""
    upper_aside_m: float
    fore_aside_m: float


_LENGTHS = {
    "ur10": _Lengths(0.612, 0.5723, 0.1273, (0.163941, 0.1157, 0.0922), 0.2209, 0.0490),
    "ur10e": _Lengths(0.6127, 0.57155, 0.1807, (0.17415, 0.11985, 0.11655), 0.1762, 0.0393),
}
_RADII_M = {"upper arm": 0.07, "elbow": 0.065, "forearm": 0.055, "wrist": 0.05}


Near = Callable[[Triple, Triple], list[tuple[Contact, Box]]]
"""What is solid within a box between two corners."""


class Tube(NamedTuple):
    """One link, from the middle of one end to that of the other, in metres in the base frame."""

    name: str
    begin: Floats
    end: Floats

    @property
    def radius_m(self) -> float:
        """How thick it is."""
        return _RADII_M[self.name]


def tubes(joints_rad: Sequence[float], model: Literal["ur10", "ur10e"]) -> tuple[Tube, ...]:
    """Where the links are for six joint positions."""
    size = _LENGTHS[model]
    q1, q2, q3, q4, q5, _ = joints_rad
    out = np.array([math.cos(q1), math.sin(q1), 0.0])
    aside = np.array([math.sin(q1), -math.cos(q1), 0.0])
    up = np.array([0.0, 0.0, 1.0])

    def way(angle_rad: float, length_m: float) -> Floats:
        return np.asarray(-length_m * (math.cos(angle_rad) * out + math.sin(angle_rad) * up))

    shoulder = size.shoulder_m * up
    elbow = shoulder + way(q2, size.upper_m)
    wrist = elbow + way(q2 + q3, size.fore_m)
    q234 = q2 + q3 + q4
    down = math.sin(q234) * out - math.cos(q234) * up
    level = math.cos(q234) * out + math.sin(q234) * up
    tool = -math.sin(q5) * level + math.cos(q5) * aside
    along_m, down_m, tool_m = size.wrist_m
    first = wrist + along_m * aside
    second = first + down_m * down
    upper, fore = size.upper_aside_m * aside, size.fore_aside_m * aside
    return (
        # The shoulder's own housing sits on the foot, and moves nowhere.
        Tube("upper arm", shoulder + upper + 0.1 * (elbow - shoulder), elbow + upper),
        Tube("elbow", elbow + upper, elbow + fore),
        Tube("forearm", elbow + fore, wrist + fore),
        Tube("wrist", wrist + fore, first),
        Tube("wrist", first, second),
        # Its far end is the flange, where the gripper's body begins.
        Tube("wrist", second, second + 0.4 * tool_m * tool),
    )


class LinkJudge:
    """Follows the arm's joints and says which links are in something.

    Args:
        model: which arm.
        from_base: 4x4, base frame to the frame that solid things are in.
    """

    def __init__(self, model: Literal["ur10", "ur10e"], from_base: Floats) -> None:
        self._model = model
        self._from_base = from_base
        self._judged: Floats | None = None
        """Joint positions at which the arm was judged last."""

    def lose_sight(self) -> None:
        """Judge no way to where the arm is next."""
        self._judged = None

    def due(self, joints_rad: Floats) -> bool:
        """Whether the arm has moved so far since that it is to be judged again."""
        if self._judged is None:
            return True
        return float(np.abs(joints_rad - self._judged).sum()) * _REACH_M >= SWEEP_STEP_M

    def judge(self, joints_rad: Floats, near: Near) -> set[Contact]:
        """What the links are in on the way from where they were judged last."""
        before = joints_rad if self._judged is None else self._judged
        self._judged = joints_rad.copy()
        way_m = float(np.abs(joints_rad - before).sum()) * _REACH_M
        links = tubes(joints_rad.tolist(), self._model)
        ends = self._seen(np.array([(tube.begin, tube.end) for tube in links]))
        margins_m = np.array([tube.radius_m for tube in links])[:, None] + way_m
        lows = (ends.min(axis=1) - margins_m).tolist()
        highs = (ends.max(axis=1) + margins_m).tolist()
        found: set[Contact] = set()
        for i, tube in enumerate(links):
            solid = near(tuple(lows[i]), tuple(highs[i]))
            if not solid:
                continue
            gap_m = float(_gaps_m(self._points(tube), solid).min()) - tube.radius_m
            if gap_m <= way_m - DEPTH_M:
                found |= self._closely(i, before, joints_rad, solid)
        return found

    def _closely(
        self, link: int, before: Floats, after: Floats, solid: list[tuple[Contact, Box]]
    ) -> set[Contact]:
        """The same for one link that came near something."""
        way_m = float(np.abs(after - before).sum()) * _REACH_M
        steps = max(1, math.ceil(way_m / FINE_STEP_M))
        found: set[Contact] = set()
        for i in range(1, steps + 1):
            joints = before + (after - before) * (i / steps)
            tube = tubes(joints.tolist(), self._model)[link]
            deep = _gaps_m(self._points(tube), solid).min(axis=0) - tube.radius_m < -DEPTH_M
            found |= {solid[box][0]._replace(body=tube.name) for box in np.flatnonzero(deep)}
        return found

    def _points(self, tube: Tube) -> Floats:
        """Points along the middle of a link, n x 3."""
        way = tube.end - tube.begin
        count = max(2, math.ceil(float(np.linalg.norm(way)) / _SPACING_M) + 1)
        return self._seen(tube.begin + np.linspace(0.0, 1.0, count)[:, None] * way)

    def _seen(self, points: Floats) -> Floats:
        """Points of the base frame, in the frame that solid things are in."""
        return np.asarray(points @ self._from_base[:3, :3].T + self._from_base[:3, 3])


def _gaps_m(points: Floats, solid: list[tuple[Contact, Box]]) -> Floats:
    """How far each point is from each box: n x boxes, negative by how deep it is in one."""
    poses = np.array([box.pose for _, box in solid])
    half_m = np.array([box.half_m for _, box in solid])
    # In each box's own frame.
    local = np.einsum("pbi,bij->pbj", points[:, None, :] - poses[:, :3, 3], poses[:, :3, :3])
    beyond = np.abs(local) - half_m
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=2)
    return np.asarray(outside + np.minimum(beyond.max(axis=2), 0.0))
