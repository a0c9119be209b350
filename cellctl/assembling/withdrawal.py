"""The check of a short slow step from wherever the arm stands, too close to something or not."""

from __future__ import annotations

import math

import numpy as np

from cellctl.assembling import links
from cellctl.assembling.course import leg_length_m
from cellctl.assembling.frames import Frames
from cellctl.assembling.kinematics import Kinematics
from cellctl.assembling.obstacles import TOUCH_M, Flags, first_named
from cellctl.assembling.poses import Floats, interpolate, to_matrix
from cellctl.assembling.route_check import Scene
from cellctl.config import Pose
from cellctl.errors import PlanError

_STEP_M = 0.002
_CLOSER_M = 1e-4
"""Nothing comes closer by more than this, which is rounding."""
_DEEPEST_M = 0.02
"""An arm that is deeper in something than this is let up past nothing else as deeply."""
_LEAVING_SHARE = 0.1
"""What touches is left by at least this share of the way."""


class WithdrawalCheck:
    """Lets an arm leave, and nothing come closer.

    Args:
        frames: the cell's frames.
        kinematics: its arm.
        margin_m: what is farther away than this stays so; what is nearer never comes nearer.
        link_margin_m: the same of the arm's links.
    """

    def __init__(
        self, frames: Frames, kinematics: Kinematics, margin_m: float, link_margin_m: float
    ) -> None:
        self._frames = frames
        self._kinematics = kinematics
        self._margin_m = margin_m
        self._link_margin_m = link_margin_m

    def check(self, start: Pose, end: Pose, joints_rad: Floats, scene: Scene) -> None:
        """Check a straight way.

        What is farther away than the margin stays so. What is nearer never comes nearer, so that
        an arm can always leave; straight up it may pass beside what is no nearer sideways than
        what is touched already. What touches is left behind and not dragged along sideways.

        Args:
            start: TCP pose in the base frame.
            end: the same.
            joints_rad: n x 6 joint positions along it, its start included.
            scene: what moves, and what is in the way.

        Raises:
            PlanError: something is in the way; the message names it.
        """
        self._check_bodies(start, end, scene)
        arm = links.links(joints_rad, self._kinematics.model)
        for group in scene.obstacles:
            near_m = np.minimum(links.gaps_m(arm, group).min(axis=1), self._link_margin_m)
            nearest_yet_m = np.maximum.accumulate(near_m, axis=0)
            closer: Flags = np.any(near_m < nearest_yet_m - _CLOSER_M, axis=0)
            if (name := first_named(group, closer)) is not None:
                raise PlanError(
                    f"A link of the arm would come closer to {name} than "
                    f"{self._link_margin_m * 100:.0f} cm, or than it is."
                )

    def _check_bodies(self, start: Pose, end: Pose, scene: Scene) -> None:
        a, b = to_matrix(start), to_matrix(end)
        length_m = leg_length_m(start, end)
        steps = max(1, math.ceil(length_m / _STEP_M))
        poses = [interpolate(a, b, i / steps) for i in range(steps + 1)]
        rising_m = (self._frames.cell_from_base @ (b - a))[:3, 3]
        lifting = math.hypot(rising_m[0], rising_m[1]) < 1e-6 < rising_m[2]
        pairs = [(group, body) for group in scene.obstacles for body in scene.bodies]
        touched_m = min(float(group.gaps_m(body, a).min()) for group, body in pairs)
        for group, body in pairs:
            near_m = np.minimum([group.gaps_m(body, pose) for pose in poses], self._margin_m)
            nearest_yet_m = np.maximum.accumulate(near_m, axis=0)
            closer: Flags = np.any(near_m < nearest_yet_m - _CLOSER_M, axis=0)
            if lifting:
                beside_m = max(min(touched_m, -TOUCH_M), -_DEEPEST_M) - _CLOSER_M
                closer = np.logical_and(closer, group.sideways_m(body, a) < beside_m)
            if (name := first_named(group, closer)) is not None:
                raise PlanError(
                    f"The {scene.what} would come closer to {name} than "
                    f"{self._margin_m * 100:.0f} cm, or than it is; only a way that leads off is "
                    "open."
                )
            # Of all that is touched, what is touched most: a corner between two parts is left
            # along the face of the one and away from the other.
            deepest_m = near_m.min(axis=1)
            dragged = np.diff(deepest_m) < _LEAVING_SHARE * length_m / steps
            dragged &= deepest_m[:-1] < TOUCH_M
            if dragged.any() and not lifting:
                name = group.names[int(near_m[int(np.argmax(dragged))].argmin())]
                raise PlanError(
                    f"The {scene.what} touches {name} and would drag along it; go straight up "
                    "first."
                )
