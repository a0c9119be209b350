"""Measuring where things are: known points are touched, and the frames follow from them.

Nothing moves by itself. The operator guides the arm, by hand or with ``cellctl hand jog``, until
the tip of a pin in the gripper is at a point that is known; the robot is asked where its flange is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from cellctl.assembling.calibration import Fit, rigid, tip
from cellctl.assembling.poses import Matrix, distance, inverse, to_matrix, to_pose
from cellctl.config import CellConfig, Pose
from cellctl.config.rewriting import NewValues
from cellctl.errors import UsageError

WORST_M = 0.0015
"""A point that is farther off than this was not touched well, or is not where it is said to be."""
FARTHEST_M, FARTHEST_RAD = 0.15, math.radians(15.0)
"""A frame that is farther from the configured one is another thing than was meant."""
TOOL_TOUCHES = 6
MEASURED = ("tool", "base", "pedestal", "feeder")
"""Tables of the configuration whose frame comes out."""


class Touch(NamedTuple):
    """One point to be touched."""

    what: str
    """For the operator."""
    at_m: tuple[float, float, float]
    """In its thing's own frame."""
    tilt_rad: tuple[float, float] = (0.0, 0.0)
    """How far the tool is tilted about x and y, at least about so."""


class Guide(Protocol):
    """Whoever stands at the cell."""

    def tell(self, text: str) -> None:
        """Show a line."""
        ...

    def touched(self, frame: str, touch: Touch) -> Matrix | None:
        """Wait until the tip is there; the 4x4 flange pose in the base frame, or None to leave the
        point out."""
        ...


class Measured(NamedTuple):
    """What came of it."""

    values: NewValues
    """For the configuration, by table and key."""
    report: tuple[str, ...]
    """What was found, line by line."""


class FramesWalk:
    """Measures the frames of one cell.

    Args:
        config: the cell as it is configured.
        guide: who touches.
        pin_m: how far the tip is below the TCP, along the tool's z.
    """

    def __init__(self, config: CellConfig, guide: Guide, pin_m: float) -> None:
        self._config = config
        self._guide = guide
        self._pin = np.eye(4)
        self._pin[2, 3] = pin_m
        self._report: list[str] = []

    def run(self) -> Measured:
        """Tool, workspace and feeder, one after the other.

        Raises:
            UsageError: too few points, or what was found is implausible; the message says what.
        """
        config = self._config
        tool = self._tool()
        tip_of = self._tip_of(tool)
        workspace = self._fit("workspace", self._floor_marks(), tip_of)
        base = inverse_of(to_matrix(config.workspace.frame), workspace.matrix)
        self._plausible("base", base, config.base.frame)
        feeder_in_base = self._fit("feeder", self._part_corners(), tip_of)
        feeder = base @ feeder_in_base.matrix
        self._plausible("feeder", feeder, config.feeder.frame)
        # The arm is bolted to its pedestal, whose own edges it does not reach.
        under = inverse(to_matrix(config.base.frame)) @ to_matrix(config.pedestal.frame)
        frames = {
            "tool": tool,
            "base": base,
            "pedestal": base @ under,
            "feeder": feeder,
        }
        values = {(table, "frame"): to_pose(matrix) for table, matrix in frames.items()}
        return Measured(values, tuple(self._report))

    def _tool(self) -> Matrix:
        config = self._config
        tilts = [(0.35 * math.cos(a), 0.35 * math.sin(a)) for a in _angles(TOOL_TOUCHES - 1)]
        touches = [
            Touch(f"the mark at the workspace's middle, tool {how}", _middle(config), tilt)
            for tilt, how in zip(
                [(0.0, 0.0), *tilts], ["upright", *["tilted"] * len(tilts)], strict=True
            )
        ]
        self._guide.tell(
            "Tool: touch one and the same mark again and again, each time tilted to another side "
            "by some 20 degrees."
        )
        flanges = [flange for _, flange in self._touched("workspace", touches)]
        found = tip(flanges)
        self._told("tool", found.residuals_m)
        tcp = to_matrix(config.tool.frame)
        tcp[:3, 3] = found.in_flange_m - tcp[:3, :3] @ self._pin[:3, 3]
        self._plausible("tool", tcp, config.tool.frame)
        return tcp

    def _tip_of(self, tool: Matrix) -> Callable[[Matrix], Sequence[float]]:
        return lambda flange: [float(one) for one in (flange @ tool @ self._pin)[:3, 3]]

    def _floor_marks(self) -> list[Touch]:
        x_m, y_m = (count * self._config.voxel.pitch_m for count in self._config.grid[:2])
        corners = [(0.0, 0.0), (x_m, 0.0), (x_m, y_m), (0.0, y_m)]
        return [
            Touch(f"the mark on the floor at x {x * 1000:.0f}, y {y * 1000:.0f} mm", (x, y, 0.0))
            for x, y in corners
        ]

    def _part_corners(self) -> list[Touch]:
        half_m = self._config.voxel.pitch_m / 2
        names = ("front right", "front left", "back left", "back right")
        signs = ((1, -1), (1, 1), (-1, 1), (-1, -1))
        return [
            Touch(
                f"the {name} upper corner of the part at the pick station, seen along the feed",
                (a * half_m, b * half_m, 0.0),
            )
            for name, (a, b) in zip(names, signs, strict=True)
        ]

    def _fit(
        self, frame: str, touches: list[Touch], tip_of: Callable[[Matrix], Sequence[float]]
    ) -> Fit:
        found = list(self._touched(frame, touches))
        fit = rigid([touch.at_m for touch, _ in found], [tip_of(flange) for _, flange in found])
        self._told(frame, fit.residuals_m)
        return fit

    def _touched(self, frame: str, touches: list[Touch]) -> Iterator[tuple[Touch, Matrix]]:
        for touch in touches:
            flange = self._guide.touched(frame, touch)
            if flange is not None:
                yield touch, flange

    def _told(self, what: str, residuals_m: Sequence[float]) -> None:
        """Report how well the touches agree.

        Raises:
            UsageError: they do not.
        """
        off = ", ".join(f"{one * 1000:.2f}" for one in residuals_m)
        line = f"{what}: the touches are off by {off} mm"
        self._report.append(line)
        self._guide.tell(line)
        if max(residuals_m) > WORST_M:
            worst = int(np.argmax(residuals_m)) + 1
            raise UsageError(
                f"{what}: touch {worst} is {max(residuals_m) * 1000:.1f} mm off; "
                f"{WORST_M * 1000:g} mm are allowed.",
                "Touch the points anew, in the order that is told; measure where the marks are.",
            )

    def _plausible(self, what: str, found: Matrix, configured: Pose) -> None:
        """Report how far a frame is from where it was thought to be.

        Raises:
            UsageError: implausibly far.
        """
        off_m, off_rad = distance(to_pose(found), configured)
        line = f"{what}: {off_m * 1000:.2f} mm and {math.degrees(off_rad):.2f} degrees from the "
        self._report.append(line + "configured one")
        self._guide.tell(line + "configured one")
        if off_m > FARTHEST_M or off_rad > FARTHEST_RAD:
            raise UsageError(
                f"{what}: {off_m * 1000:.0f} mm and {math.degrees(off_rad):.0f} degrees from the "
                "configured frame is no matter of measuring.",
                "Touch the right points, or correct the configuration by hand first.",
            )


def inverse_of(cell_from_workspace: Matrix, base_from_workspace: Matrix) -> Matrix:
    """4x4, base to cell, from where the workspace is in each."""
    return np.asarray(cell_from_workspace @ inverse(base_from_workspace))


def _middle(config: CellConfig) -> tuple[float, float, float]:
    x_m, y_m = (count * config.voxel.pitch_m / 2 for count in config.grid[:2])
    return (x_m, y_m, 0.0)


def _angles(count: int) -> list[float]:
    return [2.0 * math.pi * i / count for i in range(count)]
